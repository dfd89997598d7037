//! Ranks that are threads against one machine. One binary: what each file would compile anew is compiled once.

mod common;
mod kinds;
mod one_machine;
mod random;
