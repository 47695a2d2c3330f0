//! A second implementation of the library's rules: naive, in f64, one vertex at a time, written from the paper and the design and not from
//! the code. It takes only data from the library: stored displacements, what one hit alone leaves, and documented constants.
#![allow(dead_code)]

pub mod damage;
pub mod marks;
