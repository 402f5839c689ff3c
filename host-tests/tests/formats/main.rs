//! The file formats of the host program, by its public functions: data sets, signals, models, output.

mod dataset_errors;
mod dataset_lines;
mod dataset_load;
mod model_file;
mod modified_play;
mod output;
mod schema_and_docs;
mod signals;
mod support;
