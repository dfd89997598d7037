//! Parry's solvers behind our traits. One binary: what each file would compile anew is compiled once.

mod agreement;
mod closed_forms;
mod common;
mod hulls;
mod kinds;
mod objects;
mod parts;
mod threads;
mod undecided;
