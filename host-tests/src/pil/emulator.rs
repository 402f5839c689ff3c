//! The firmware in QEMU, spoken to over its standard streams; `docs/link.md` has the records.

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use super::target::{CHUNK_LEN, Target, Ticked};
use crate::error::Error;

const QEMU: &str = "qemu-system-arm";

/// A running emulator; dropped, it is ended.
#[derive(Debug)]
pub struct Emulator {
    process: Child,
    requests: Option<ChildStdin>,
    responses: ChildStdout,
}

/// What the firmware answers to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// Kind of the request; `F` when the program failed.
    pub kind: u8,
    /// What it did.
    pub ticked: Ticked,
    /// Whether the idle loop fed the watchdog since the response before, which QEMU lacks.
    pub fed: bool,
    /// Link bytes.
    pub payload: Vec<u8>,
}

impl Emulator {
    /// Starts a firmware built with the feature `qemu`.
    ///
    /// # Errors
    /// QEMU is missing, and what to install; what the system refuses.
    pub fn start(firmware: &Path) -> Result<Self, Error> {
        let mut process = Command::new(QEMU)
            .args(["-M", "netduinoplus2", "-nographic", "-monitor", "none"])
            .args(["-serial", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-icount", "shift=0,sleep=off", "-kernel"])
            .arg(firmware)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| match error.kind() {
                io::ErrorKind::NotFound => Error::request(format!(
                    "there is no {QEMU}; install it: 'apt-get install qemu-system-arm' on Debian, \
                     'brew install qemu' on macOS"
                )),
                _ => Error::request(format!("{QEMU}: {error}; check its installation")),
            })?;
        let requests = process.stdin.take();
        let responses = process.stdout.take().ok_or_else(|| {
            Error::request(format!(
                "{QEMU} has no standard output; check its installation"
            ))
        })?;
        Ok(Self {
            process,
            requests,
            responses,
        })
    }

    /// Sends a request. A value that is no sensor code and a payload are for kinds that have them.
    ///
    /// # Errors
    /// A program that has ended.
    pub fn request(&mut self, kind: u8, value: u16, payload: &[u8]) -> Result<(), Error> {
        let len = u8::try_from(payload.len()).map_err(|_| {
            Error::request(format!(
                "a request takes at most {CHUNK_LEN} bytes; split them"
            ))
        })?;
        let [low, high] = value.to_le_bytes();
        let mut bytes = vec![kind, len, low, high];
        bytes.extend_from_slice(payload);
        let sent = match &mut self.requests {
            Some(requests) => requests.write_all(&bytes),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        sent.map_err(|error| self.failed(&error))
    }

    /// Waits for the response to a request.
    ///
    /// # Errors
    /// A program that has ended.
    pub fn response(&mut self) -> Result<Response, Error> {
        let mut header = [0; 12];
        let read = self.responses.read_exact(&mut header);
        read.map_err(|error| self.failed(&error))?;
        let [kind, state, c0, c1, enabled, fed, l0, l1, count @ ..] = header;
        let mut payload = vec![0; usize::from(u16::from_le_bytes([l0, l1]))];
        let read = self.responses.read_exact(&mut payload);
        read.map_err(|error| self.failed(&error))?;
        Ok(Response {
            kind,
            ticked: Ticked {
                state,
                code: u16::from_le_bytes([c0, c1]),
                driver_enabled: enabled == 1,
                instructions: u32::from_le_bytes(count),
            },
            fed: fed == 1,
            payload,
        })
    }

    /// Bytes of stack that were ever used.
    ///
    /// # Errors
    /// A program that has ended.
    pub fn stack_bytes(&mut self) -> Result<u32, Error> {
        self.request(b'S', 0, &[])?;
        Ok(self.expect(b'S')?.ticked.instructions)
    }

    /// Resets the target; what it saved stays.
    ///
    /// # Errors
    /// A program that has ended.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.request(b'R', 0, &[])?;
        self.expect(b'R')?;
        Ok(())
    }

    /// Ends the program by closing its input and gives its exit code and what it said on its error
    /// stream.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn end(mut self) -> Result<(Option<i32>, String), Error> {
        self.finish()
            .map_err(|error| Error::request(format!("{QEMU}: {error}; end it by hand")))
    }

    /// The second half of a sample, for whoever works meanwhile.
    pub(super) fn ticked(&mut self) -> Result<Ticked, Error> {
        Ok(self.expect(b'T')?.ticked)
    }

    /// The second half of a link exchange.
    pub(super) fn linked(&mut self) -> Result<Vec<u8>, Error> {
        Ok(self.expect(b'L')?.payload)
    }

    /// The first half of a sample.
    pub(super) fn request_tick(&mut self, sensor: u16, late: bool) -> Result<(), Error> {
        self.request(if late { b'O' } else { b'T' }, sensor, &[])
    }

    fn expect(&mut self, kind: u8) -> Result<Response, Error> {
        let response = self.response()?;
        let late_tick = kind == b'T' && response.kind == b'O';
        if response.kind == kind || late_tick {
            return Ok(response);
        }
        Err(self.failed(&io::ErrorKind::InvalidData.into()))
    }

    /// Why a program does not answer: what it said itself, if anything.
    fn failed(&mut self, error: &io::Error) -> Error {
        let said = self.finish().map(|(_, said)| said).unwrap_or_default();
        let said = said.trim();
        Error::request(if said.is_empty() {
            format!("the emulated firmware ended: {error}; build it with the feature qemu")
        } else {
            format!("the emulated firmware failed: {said}")
        })
    }

    fn finish(&mut self) -> io::Result<(Option<i32>, String)> {
        drop(self.requests.take());
        let status = self.process.wait()?;
        let mut said = Vec::new();
        if let Some(mut stream) = self.process.stderr.take() {
            stream.read_to_end(&mut said)?;
        }
        Ok((status.code(), String::from_utf8_lossy(&said).into_owned()))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        drop(self.requests.take());
        // Without effect on a process that has been waited for.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Target for Emulator {
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error> {
        self.request_tick(sensor, late)?;
        self.ticked()
    }

    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        self.request(b'L', 0, bytes)?;
        self.linked()
    }
}
