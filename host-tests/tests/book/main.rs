//! The book under docs/: its contents and links, and its figures against the golden outputs of docs/golden.
//!
//! Tests that compute the same figures hold the golden outputs against what the program says now.

#[path = "../golden/mod.rs"]
mod golden;

mod beyond;
mod blind;
mod contents;
mod counted;
mod faults;
mod page;
mod paper_j;
mod paper_m;
mod worked;
