//! A bench on a socket, in real time: a target to practise on with `hysteron link`.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream};
#[cfg(unix)]
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::bench::Bench;
use super::target::Target;
use crate::error::{Error, quoted};

/// How long the bench rests when nothing is due.
const PAUSE: Duration = Duration::from_millis(1);
/// A bench that cannot keep up with real time lets go of what it is behind beyond this.
const BEHIND_LIMIT: Duration = Duration::from_millis(20);
/// Samples between two looks at the link.
const BLOCK: u32 = 8;
/// A host that takes no bytes for so long is gone.
const SEND_LIMIT: Duration = Duration::from_secs(1);

/// Where hosts connect.
#[derive(Debug)]
pub enum Listener {
    /// `tcp:HOST:PORT`.
    Tcp(TcpListener),
    /// `unix:PATH`; the socket's file goes with it.
    #[cfg(unix)]
    Unix(std::os::unix::net::UnixListener, PathBuf),
}

impl Listener {
    /// Listens at `tcp:HOST:PORT` (port 0: any that is free) or `unix:PATH`.
    ///
    /// # Errors
    /// Another name, or what the system refuses.
    pub fn bind(name: &str) -> Result<Self, Error> {
        let refuse = |problem: io::Error| {
            Error::request(format!("{}: {problem}; choose another", quoted(name)))
        };
        if let Some(address) = name.strip_prefix("tcp:") {
            let listener = TcpListener::bind(address).map_err(refuse)?;
            listener.set_nonblocking(true).map_err(refuse)?;
            return Ok(Self::Tcp(listener));
        }
        #[cfg(unix)]
        if let Some(path) = name.strip_prefix("unix:") {
            let listener = std::os::unix::net::UnixListener::bind(path).map_err(refuse)?;
            listener.set_nonblocking(true).map_err(refuse)?;
            return Ok(Self::Unix(listener, path.into()));
        }
        Err(Error::request(format!(
            "{} is no place to listen at; name tcp:HOST:PORT or unix:PATH",
            quoted(name)
        )))
    }

    /// The name by which a host connects.
    pub fn name(&self) -> String {
        match self {
            Self::Tcp(listener) => match listener.local_addr() {
                Ok(address) => format!("tcp:{address}"),
                Err(_) => "tcp:?".to_owned(),
            },
            #[cfg(unix)]
            Self::Unix(_, path) => format!("unix:{}", path.display()),
        }
    }

    fn accept(&self) -> io::Result<Option<Box<dyn Host>>> {
        let host: io::Result<Box<dyn Host>> = match self {
            Self::Tcp(listener) => listener.accept().and_then(|(stream, _)| {
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(PAUSE))?;
                stream.set_write_timeout(Some(SEND_LIMIT))?;
                Ok(Box::new(stream) as Box<dyn Host>)
            }),
            #[cfg(unix)]
            Self::Unix(listener, _) => listener.accept().and_then(|(stream, _)| {
                stream.set_nonblocking(false)?;
                stream.set_read_timeout(Some(PAUSE))?;
                stream.set_write_timeout(Some(SEND_LIMIT))?;
                Ok(Box::new(stream) as Box<dyn Host>)
            }),
        };
        match host {
            Ok(host) => Ok(Some(host)),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        #[cfg(unix)]
        if let Self::Unix(_, path) = self {
            let _ = std::fs::remove_file(path);
        }
    }
}

trait Host: Read + Write {}
impl Host for TcpStream {}
#[cfg(unix)]
impl Host for std::os::unix::net::UnixStream {}

/// Serves one host after the other until `ended` says so; the stage goes on in between.
///
/// # Errors
/// A target that failed, or a listener that broke.
pub fn serve<T: Target>(
    listener: &Listener,
    bench: &mut Bench<T>,
    ended: &mut dyn FnMut(&Bench<T>) -> bool,
) -> Result<(), Error> {
    let mut host: Option<Box<dyn Host>> = None;
    let sample_time = Duration::from_secs_f64(bench.sample_time_s());
    let mut due = Instant::now();
    while !ended(bench) {
        if let Some(stream) = &mut host {
            let mut buffer = [0; 4096];
            let gone = match stream.read(&mut buffer) {
                Ok(0) => true,
                Ok(len) => {
                    bench.hear(&buffer[..len])?;
                    false
                }
                Err(error) => !matches!(
                    error.kind(),
                    io::ErrorKind::WouldBlock
                        | io::ErrorKind::TimedOut
                        | io::ErrorKind::Interrupted
                ),
            };
            if gone {
                host = None;
            }
        } else {
            host = listener
                .accept()
                .map_err(|error| Error::request(format!("{}: {error}", listener.name())))?;
            std::thread::sleep(PAUSE);
        }
        let now = Instant::now();
        due = due.max(now.checked_sub(BEHIND_LIMIT).unwrap_or(now));
        while due <= now {
            for _ in 0..BLOCK {
                bench.tick()?;
                due += sample_time;
            }
            // Between the samples of a long catching-up too, or recorded ones would be dropped.
            bench.hear(&[])?;
        }
        let heard = bench.heard();
        if let Some(stream) = &mut host
            && !heard.is_empty()
            && stream.write_all(&heard).is_err()
        {
            host = None;
        }
    }
    Ok(())
}
