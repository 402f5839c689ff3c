//! CRC-32 of frames and of what is saved: one copy of it on the target.

use crc::{CRC_32_ISO_HDLC, Crc};

/// Without a table: 1 KiB of flash saved, and nothing here runs in the interrupt.
const CHECK: Crc<u32, crc::NoTable> = Crc::<u32, crc::NoTable>::new(&CRC_32_ISO_HDLC);

/// Of the parts, one after another.
#[inline(never)]
pub fn crc32(parts: &[&[u8]]) -> u32 {
    let mut digest = CHECK.digest();
    for part in parts {
        digest.update(part);
    }
    digest.finalize()
}
