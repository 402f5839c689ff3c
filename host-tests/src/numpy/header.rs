//! What stands before the numbers of a `.npy` file: their type, shape and order.
//!
//! Format: NumPy Enhancement Proposal 1, "A Simple File Format for NumPy Arrays", versions 1.0 to 3.0.

use std::io::Read;

use super::literal::{Literal, parse};
use crate::error::quoted;

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Longest header: one of a structured array with a thousand fields is shorter.
const LONGEST: u32 = 1 << 16;
/// Bytes of a row at most.
const WIDEST: u64 = 1 << 20;

/// A header.
#[derive(Debug)]
pub(super) struct Header {
    /// Entries along each axis.
    pub(super) shape: Vec<u64>,
    /// Whether the first index runs fastest.
    pub(super) fortran: bool,
    /// What an entry is.
    pub(super) entry: Entry,
    /// Bytes of the file before the numbers.
    pub(super) length: u64,
}

/// An entry of an array.
#[derive(Debug)]
pub(super) enum Entry {
    /// One number.
    Number(Kind),
    /// A record with named fields.
    Fields(Vec<Field>, u64),
}

/// A field of a record.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    /// Bytes of the record before it.
    pub(super) offset: u64,
    /// Its type, or what it is called where it is no number.
    pub(super) kind: Result<Kind, String>,
}

/// Type of a number: bytes, and how they are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kind {
    letter: u8,
    bytes: u8,
    big_endian: bool,
}

impl Kind {
    fn named(text: &str) -> Option<Self> {
        let (order, letter, bytes) = match text.as_bytes() {
            [order @ (b'<' | b'>' | b'|'), letter, bytes @ b'1'..=b'8'] => {
                (*order, *letter, bytes - b'0')
            }
            _ => return None,
        };
        let known = match letter {
            b'f' => matches!(bytes, 4 | 8),
            b'i' | b'u' => bytes.is_power_of_two(),
            _ => false,
        };
        known.then_some(Self {
            letter,
            bytes,
            big_endian: order == b'>',
        })
    }

    /// Bytes of a number.
    pub(super) fn bytes(self) -> u64 {
        u64::from(self.bytes)
    }

    /// The number that begins at the first of `bytes`; zero where there are too few.
    pub(super) fn number(self, bytes: &[u8]) -> f64 {
        let mut word = [0; 8];
        let count = usize::from(self.bytes);
        let Some(bytes) = bytes.get(..count) else {
            return 0.0;
        };
        for (at, &byte) in bytes.iter().enumerate() {
            word[if self.big_endian { count - 1 - at } else { at }] = byte;
        }
        let whole = u64::from_le_bytes(word);
        match (self.letter, self.bytes) {
            (b'f', 4) => f32::from_bits(whole as u32).into(),
            (b'f', _) => f64::from_bits(whole),
            (b'u', _) => whole as f64,
            _ => {
                let unused = 64 - 8 * u32::from(self.bytes);
                ((whole << unused) as i64 >> unused) as f64
            }
        }
    }
}

impl Header {
    /// Reads a header.
    ///
    /// # Errors
    /// What is wrong and what to do.
    pub(super) fn read(from: &mut dyn Read) -> Result<Self, String> {
        let ended = |_| "ends within its header; copy or save the file again".to_owned();
        let mut start = [0; 8];
        from.read_exact(&mut start).map_err(ended)?;
        if !start.starts_with(MAGIC) {
            return Err("is not in NumPy's format; save it with numpy.save or numpy.savez".into());
        }
        let short = start[6] == 1;
        let mut length = [0; 4];
        from.read_exact(&mut length[..if short { 2 } else { 4 }])
            .map_err(ended)?;
        let length = u32::from_le_bytes(length);
        if !(1..=3).contains(&start[6]) || length > LONGEST {
            return Err(format!(
                "has format version {}.{} or a header of {length} bytes, which this program does not \
                 know; save plain numbers",
                start[6], start[7]
            ));
        }
        let mut text = vec![0; length as usize];
        from.read_exact(&mut text).map_err(ended)?;
        let text = match start[6] {
            3 => String::from_utf8(text).ok(),
            _ => Some(text.iter().map(|&byte| char::from(byte)).collect()),
        };
        let header = text.as_deref().and_then(parse).and_then(Self::from_literal);
        let mut header = header
            .ok_or("has a header that cannot be understood; save it again with numpy.save")??;
        header.length = if short { 10 } else { 12 } + u64::from(length);
        Ok(header)
    }

    fn from_literal(literal: Literal) -> Option<Result<Self, String>> {
        let Literal::Dict(entries) = literal else {
            return None;
        };
        let value = |wanted| {
            let entry = entries.iter().find(|(key, _)| key == wanted);
            entry.map(|(_, value)| value)
        };
        let (Literal::Truth(fortran), Literal::List(axes)) =
            (value("fortran_order")?, value("shape")?)
        else {
            return None;
        };
        let axis = |axis: &Literal| match axis {
            Literal::Whole(count) => Some(*count),
            _ => None,
        };
        let shape = axes.iter().map(axis).collect::<Option<Vec<u64>>>()?;
        let entry = match value("descr")? {
            Literal::Text(text) => Kind::named(text)
                .map(Entry::Number)
                .ok_or_else(|| other_type(text)),
            Literal::List(list) => fields(list)?,
            _ => return None,
        };
        Some(entry.map(|entry| Self {
            shape,
            fortran: *fortran,
            entry,
            length: 0,
        }))
    }

    /// Bytes of the numbers, of an entry that may be any.
    pub(super) fn bytes(&self) -> Option<u64> {
        let entry = match &self.entry {
            Entry::Number(kind) => kind.bytes(),
            Entry::Fields(_, bytes) => *bytes,
        };
        let mut axes = self.shape.iter();
        axes.try_fold(entry, |bytes, &count| bytes.checked_mul(count))
    }
}

/// What is said of a type that holds no plain numbers.
pub(super) fn other_type(text: &str) -> String {
    format!(
        "has the type {}, not floats or whole numbers of up to 64 bits; save it with \
         .astype(\"float64\")",
        quoted(text)
    )
}

/// The fields of a record; `None` where they are not as NumPy writes them.
fn fields(list: &[Literal]) -> Option<Result<Entry, String>> {
    let mut fields = Vec::with_capacity(list.len());
    let mut offset = 0u64;
    for field in list {
        let Literal::List(parts) = field else {
            return None;
        };
        let (name, kind, shape) = match parts.as_slice() {
            [name, kind] => (name, kind, &[][..]),
            [name, kind, Literal::List(shape)] => (name, kind, &shape[..]),
            _ => return None,
        };
        let name = match name {
            Literal::Text(name) => name,
            // A title and a name.
            Literal::List(both) => match both.as_slice() {
                [_, Literal::Text(name)] => name,
                _ => return None,
            },
            _ => return None,
        };
        let Literal::Text(text) = kind else {
            return Some(Err(
                "has fields within fields; save the numbers as fields of their own".into(),
            ));
        };
        let mut bytes = width(text)?;
        for axis in shape {
            let Literal::Whole(count) = axis else {
                return None;
            };
            bytes = bytes.checked_mul(*count)?;
        }
        if !name.is_empty() {
            let number = Kind::named(text).filter(|_| shape.is_empty());
            fields.push(Field {
                name: name.clone(),
                offset,
                kind: number.ok_or_else(|| text.clone()),
            });
        }
        offset = offset.checked_add(bytes).filter(|&end| end <= WIDEST)?;
    }
    Some(Ok(Entry::Fields(fields, offset)))
}

/// Bytes of any type, as in `<f8`, `|S10`, `<U5`, `<M8[us]`.
fn width(text: &str) -> Option<u64> {
    let (_, rest) = text.split_at_checked(1)?;
    let (letter, rest) = rest.split_at_checked(1)?;
    let end = rest.find(|c: char| !c.is_ascii_digit());
    let count: u64 = rest[..end.unwrap_or(rest.len())].parse().ok()?;
    match letter {
        "U" => count.checked_mul(4),
        "O" => Some(8),
        _ => Some(count),
    }
}
