//! Hidden data: laws against formulas, sizes and files against independent computations.

mod command_line;
mod data;
mod laws;
mod rates;
mod support;
