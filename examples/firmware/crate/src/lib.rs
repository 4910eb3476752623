//! A crate for field-oriented control, and the module that drivegate calls.

mod adapter;
mod foc;
mod records;
