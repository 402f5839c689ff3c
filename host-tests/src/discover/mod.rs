//! Discovery: where simulation and measurement disagree, which effect is missing, what adding it does.

pub mod baseline;
pub mod search;
