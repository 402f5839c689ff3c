//! The host's side of the link: conversation on bad lines, recordings, files, the command line.

mod client;
mod command_line;
mod files;
mod playing;
mod support;
