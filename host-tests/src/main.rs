//! Command line `hysteron`.

fn main() {}
