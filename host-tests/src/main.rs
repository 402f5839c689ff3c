//! Command line `hysteron`.

mod cli;

use std::process::ExitCode;

use hysteron_host::error::Error;

fn main() -> ExitCode {
    match cli::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(match error {
                Error::Interrupted => 130,
                _ => 2,
            })
        }
    }
}
