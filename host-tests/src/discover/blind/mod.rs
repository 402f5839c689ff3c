//! Blind trials: effects are hidden and diagnosed in bulk, and the answers held against the truth.
//!
//! `docs/blind.md` defines every figure.

mod json;
mod outcome;
mod page;
mod plan;
mod run;
mod scores;

pub use json::schema_text;
pub use outcome::{Answer, Named, Outcome, REVEALED};
pub use plan::{Plan, Range};
pub use run::{Blind, run};
pub use scores::{Bin, ByEffect, Confusion, Scores, Share, Spread};
