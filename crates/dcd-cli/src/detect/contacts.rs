//! Contacts as a file, and their digest.

use crate::reported::Reported;
use dcd_geom::Pair;
use serde::Serialize;
use std::io::{self, Write};

/// u32 count, then u32 i, u32 j each, little endian.
pub(super) fn write(contacts: &[Pair], mut out: impl Write) -> io::Result<()> {
    let count = u32::try_from(contacts.len()).map_err(|_| {
        let count = contacts.len();
        io::Error::other(format!("{count} contacts are more than a u32 counts"))
    })?;
    out.write_all(&count.to_le_bytes())?;
    for &pair in contacts {
        out.write_all(&bytes(pair))?;
    }
    out.flush()
}

#[derive(Serialize)]
struct Line<'a> {
    i: u32,
    j: u32,
    #[serde(flatten)]
    reported: &'a Reported,
}

/// A line of JSON for each contact, in the order given.
pub(super) fn write_reported(contacts: &[(Pair, Reported)], mut out: impl Write) -> io::Result<()> {
    for (Pair { i, j }, reported) in contacts {
        serde_json::to_writer(&mut out, &Line { i: *i, j: *j, reported })?;
        out.write_all(b"\n")?;
    }
    out.flush()
}

/// 64-bit FNV-1a (Fowler, Noll, Vo) of the pairs as [`write()`] writes them, without the count.
pub(crate) fn digest(contacts: &[Pair]) -> u64 {
    fnv1a(contacts.iter().flat_map(|&pair| bytes(pair)))
}

pub(crate) fn fnv1a(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

fn bytes(pair: Pair) -> [u8; 8] {
    let [i, j] = [pair.i, pair.j].map(u32::to_le_bytes);
    [i[0], i[1], i[2], i[3], j[0], j[1], j[2], j[3]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_the_published_fnv1a() {
        assert_eq!(fnv1a(b"".iter().copied()), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"foobar".iter().copied()), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn contacts_are_written_little_endian_behind_their_count() {
        let mut file = Vec::new();
        write(&[Pair::new(1, 2), Pair::new(0x0304, 7)], &mut file).unwrap();
        assert_eq!(file, [2, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 7, 0, 0, 0, 4, 3, 0, 0]);
        assert_eq!(
            digest(&[Pair::new(1, 2), Pair::new(0x0304, 7)]),
            fnv1a(file[4..].iter().copied())
        );
    }
}
