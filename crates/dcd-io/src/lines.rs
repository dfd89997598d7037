//! Lines of a text, one record each.

use crate::bytes::without_mark;
use std::io::{self, BufRead, Read};

/// The longest line that [`read_lines`] takes, bytes: some ten million numbers. Without a limit a file
/// that never ends a line would take all memory.
pub const LONGEST_LINE: u64 = 1 << 28;

/// The lines, without a byte order mark before the first; an end of line is left where there is one. If the
/// reader itself fails, that is the last item; so it is where a line is longer than [`LONGEST_LINE`], whose
/// end is not looked for.
pub fn read_lines(mut reader: impl BufRead) -> impl Iterator<Item = io::Result<Vec<u8>>> {
    let (mut failed, mut is_first) = (false, true);
    std::iter::from_fn(move || {
        if failed {
            return None;
        }
        let mut line = Vec::new();
        let is_start = std::mem::replace(&mut is_first, false);
        match (&mut reader).take(LONGEST_LINE + 1).read_until(b'\n', &mut line) {
            Ok(0) => None,
            Ok(length) if length as u64 > LONGEST_LINE => {
                failed = true;
                let what = format!("a line is longer than {LONGEST_LINE} bytes");
                Some(Err(io::Error::new(io::ErrorKind::InvalidData, what)))
            }
            Ok(_) if is_start => Some(Ok(without_mark(&line).to_vec())),
            Ok(_) => Some(Ok(line)),
            Err(error) => {
                failed = true;
                Some(Err(error))
            }
        }
    })
}
