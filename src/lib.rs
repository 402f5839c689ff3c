#![no_std]
//! Hysteresis models and inverses for piezo actuators.
