//! What carries the bytes: a serial device, a TCP connection, a Unix socket.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serial2::SerialPort;

use crate::error::{Error, quoted};

/// Bits a second of the firmware's serial port, 8N1.
const BAUD: u32 = 921_600;
/// A target that takes no bytes for so long is gone.
const SEND_LIMIT: Duration = Duration::from_secs(2);

/// A way for bytes to and from a target, with the clock by which it is waited for.
pub trait Port {
    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// A connection that is broken or takes nothing.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits at most `limit` for bytes and gives their number: zero when none came.
    ///
    /// # Errors
    /// A connection that is broken or was closed.
    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize>;

    /// Time since the port was opened; simulated targets have a time of their own.
    fn now(&self) -> Duration;
}

/// Opens `tcp:HOST:PORT`, `unix:PATH` or, by any other name, a serial device.
///
/// # Errors
/// What the system says; for a serial device with a list of those that are there.
pub fn open(name: &str) -> Result<Box<dyn Port>, Error> {
    let refuse = |problem: io::Error, remedy: &str| {
        Error::request(format!("port {}: {problem}; {remedy}", quoted(name)))
    };
    if let Some(address) = name.strip_prefix("tcp:") {
        let stream = TcpStream::connect(address)
            .and_then(|stream| {
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(SEND_LIMIT))?;
                Ok(stream)
            })
            .map_err(|error| {
                refuse(error, "name it tcp:HOST:PORT and start the other end first")
            })?;
        return Ok(Box::new(Opened::new(stream)));
    }
    if let Some(path) = name.strip_prefix("unix:") {
        return open_unix(path)
            .map_err(|error| refuse(error, "name it unix:PATH and start the other end first"));
    }
    let mut port = SerialPort::open(name, BAUD).map_err(|error| refuse(error, &serial_ports()))?;
    port.set_write_timeout(SEND_LIMIT)
        .and_then(|()| port.discard_buffers())
        .map_err(|error| refuse(error, &serial_ports()))?;
    Ok(Box::new(Opened::new(port)))
}

#[cfg(unix)]
fn open_unix(path: &str) -> io::Result<Box<dyn Port>> {
    let stream = std::os::unix::net::UnixStream::connect(path)?;
    stream.set_write_timeout(Some(SEND_LIMIT))?;
    Ok(Box::new(Opened::new(stream)))
}

#[cfg(not(unix))]
fn open_unix(_: &str) -> io::Result<Box<dyn Port>> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The end of a message about a serial device that cannot be opened.
fn serial_ports() -> String {
    let ports = SerialPort::available_ports().unwrap_or_default();
    if ports.is_empty() {
        return "there is no serial device here; connect the board".to_owned();
    }
    let names: Vec<_> = ports
        .iter()
        .map(|port| port.display().to_string())
        .collect();
    format!("serial devices here: {}", names.join(", "))
}

/// What can be read from for a limited time.
trait Timed: Read + Write {
    fn limit_read(&mut self, limit: Duration) -> io::Result<()>;
}

impl Timed for TcpStream {
    fn limit_read(&mut self, limit: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(limit))
    }
}

#[cfg(unix)]
impl Timed for std::os::unix::net::UnixStream {
    fn limit_read(&mut self, limit: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(limit))
    }
}

impl Timed for SerialPort {
    fn limit_read(&mut self, limit: Duration) -> io::Result<()> {
        self.set_read_timeout(limit)
    }
}

struct Opened<S> {
    stream: S,
    since: Instant,
}

impl<S: Timed> Opened<S> {
    fn new(stream: S) -> Self {
        Self {
            stream,
            since: Instant::now(),
        }
    }
}

impl<S: Timed> Port for Opened<S> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)?;
        self.stream.flush()
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        // Zero would mean no limit, or an error.
        self.stream
            .limit_read(limit.max(Duration::from_millis(1)))?;
        match self.stream.read(buffer) {
            Ok(0) => Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "the other end closed the connection",
            )),
            Ok(len) => Ok(len),
            Err(error) => match error.kind() {
                io::ErrorKind::WouldBlock
                | io::ErrorKind::TimedOut
                | io::ErrorKind::Interrupted => Ok(0),
                _ => Err(error),
            },
        }
    }

    fn now(&self) -> Duration {
        self.since.elapsed()
    }
}
