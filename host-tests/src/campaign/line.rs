//! A line that spoils what it carries. Frames are taken apart and put together here by the definition of
//! docs/link.md, apart from the code under test.

use hysteron::link::VERSION;

use super::dice::Dice;

/// `COBS(version, body, CRC-32 of both) 0x00`; `spoilt` is added to the checksum.
pub fn framed(version: u8, body: &[u8], spoilt: u32) -> Vec<u8> {
    let mut plain = vec![version];
    plain.extend_from_slice(body);
    let sum = !plain.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ if sum & 1 == 1 { 0xedb8_8320 } else { 0 }
        })
    });
    plain.extend_from_slice(&(sum ^ spoilt).to_le_bytes());
    let mut out = Vec::with_capacity(plain.len() + 4);
    for block in plain.split(|&byte| byte == 0) {
        let mut rest = block;
        while let Some((full, more)) = rest.split_at_checked(254) {
            out.push(255);
            out.extend_from_slice(full);
            rest = more;
        }
        out.push(rest.len() as u8 + 1);
        out.extend_from_slice(rest);
    }
    out.push(0);
    out
}

/// The body of a whole frame.
fn body(frame: &[u8]) -> Vec<u8> {
    let mut plain = Vec::new();
    let mut rest = frame.split_last().map_or(frame, |(_, rest)| rest);
    while let Some((&count, more)) = rest.split_first() {
        let (block, next) = more.split_at(usize::from(count).saturating_sub(1).min(more.len()));
        plain.extend_from_slice(block);
        if count < 255 && !next.is_empty() {
            plain.push(0);
        }
        rest = next;
    }
    let end = plain.len().saturating_sub(4);
    plain.get(1..end).unwrap_or_default().to_vec()
}

/// The frame with a checksum that does not match.
pub fn bad_checksum(frame: &[u8], dice: &mut Dice) -> Vec<u8> {
    let spoilt = 1 + dice.below(u32::MAX as usize) as u32;
    framed(VERSION, &body(frame), spoilt)
}

/// The beginning of the frame, then its end: at least a byte is there and at least one is missing.
pub fn truncated(frame: &[u8], dice: &mut Dice) -> Vec<u8> {
    let kept = 1 + dice.below(frame.len().saturating_sub(2));
    let mut cut = frame.get(..kept).unwrap_or(frame).to_vec();
    cut.push(0);
    cut
}

/// Bytes as a wrong baud rate or a bad earth leaves them: bits turned, bytes lost, doubled, made zero.
pub fn noisy(bytes: &[u8], one_in: usize, dice: &mut Dice) -> Vec<u8> {
    let mut heard = Vec::with_capacity(bytes.len());
    for &byte in bytes {
        if !dice.one_in(one_in) {
            heard.push(byte);
            continue;
        }
        match dice.below(4) {
            0 => heard.push(byte ^ 1 << dice.below(8)),
            1 => {}
            2 => heard.extend([byte; 2]),
            _ => heard.push(0),
        }
    }
    heard
}

#[cfg(test)]
mod tests {
    use hysteron::link::{Command, FRAME_LEN, Request, encode};

    use super::*;

    /// The framing here and that of the firmware are two programs after one definition.
    #[test]
    fn frames_are_those_of_the_link() {
        for count in [0, 1, 60, 64] {
            let request = Request {
                sequence: 513,
                command: Command::Stream {
                    first: 0,
                    samples: (0..count).map(|k| k as f32 * 0.37).collect(),
                },
            };
            let mut frame = [0; FRAME_LEN];
            let len = encode(&request, &mut frame).unwrap();
            let frame = &frame[..len];
            assert_eq!(framed(VERSION, &body(frame), 0), frame);
            assert_ne!(bad_checksum(frame, &mut Dice::new(1)), frame);
        }
    }
}
