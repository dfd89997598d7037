//! Closed forms: pairs whose answer needs no search.
//!
//! Each says what it proves and leaves the rest to the general path, which is its oracle. A form
//! stays here only where it measures faster than that path, or where there is no other
//! (half-spaces, which have no support map).

mod binary;
pub mod half_space;
