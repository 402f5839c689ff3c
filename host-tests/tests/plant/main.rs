//! The simulated stage against closed forms, identities and published figures.

mod actuator;
mod electronics;
mod support;
