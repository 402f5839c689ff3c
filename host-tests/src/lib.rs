//! Host side of hysteron: data sets, identification, simulated stages, reports.

pub mod campaign;
pub mod dataset;
pub mod discover;
pub mod error;
pub mod experiment;
pub mod export;
pub mod identify;
pub mod interrupt;
pub mod link;
pub mod metrics;
pub mod model_file;
pub mod modified_play;
pub mod output;
pub mod pil;
pub mod plant;
pub mod report;
pub mod signals;
pub mod stage;

mod csv_table;
mod numpy;
mod schema_file;
mod table;
mod time_grid;
mod toml_text;
mod units;
