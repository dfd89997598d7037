//! How much memory the process has taken, and how much it may take: counts from files and flags are
//! checked against that before allocation, since no program can go on when it gets none.

use crate::failure::Failure;
use std::fmt::Display;
use std::io::{self, Read};
use std::path::Path;

/// The most physical memory that this process has held so far, bytes: `VmHWM` of Linux. `None` on
/// other systems, which have no such file.
pub(crate) fn peak_bytes() -> Option<u64> {
    field("/proc/self/status", "VmHWM:")
}

/// A line of one of Linux's files, in bytes.
fn field(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The available memory where the system does not report it, bytes.
const UNKNOWN: u64 = 64 << 30;

/// How much memory may still be taken, bytes: what the system has left, and what it leaves to this
/// process (`ulimit -v`, a control group).
pub(crate) fn available_bytes() -> u64 {
    let left = field("/proc/meminfo", "MemAvailable:").unwrap_or(UNKNOWN);
    [address_space(), control_group()].into_iter().flatten().fold(left, u64::min)
}

fn address_space() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(field("/proc/self/status", "VmSize:")?))
}

/// What the control group of this process and those around it leave, the least of them.
fn control_group() -> Option<u64> {
    let own = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    // Of version 2, relative to where its files are.
    let own = own.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or("");
    let left = |group: &Path| -> Option<u64> {
        let number = |name: &str| -> Option<u64> {
            let file = Path::new("/sys/fs/cgroup").join(group).join(name);
            std::fs::read_to_string(file).ok()?.trim().parse().ok()
        };
        Some(number("memory.max")?.saturating_sub(number("memory.current")?))
    };
    Path::new(own).ancestors().filter_map(left).min()
}

/// Checks that so many bytes are available.
pub(crate) fn demand(place: impl Display, what: impl Display, bytes: f64) -> Result<(), Failure> {
    let available = available_bytes() as f64;
    // Written so that NaN is refused.
    if bytes <= available {
        return Ok(());
    }
    let estimate = format_args!(
        "{what} take about {bytes:.1e} bytes of memory, but {available:.1e} are available"
    );
    Err(Failure::at(place, estimate))
}

/// Bytes of memory for one of a file, at most: the file, its numbers, the shapes and what a step keeps
/// of them.
const BYTES_A_BYTE: u64 = 8;

/// Reads all of a reader, if memory holds what is made from it.
pub(crate) fn read(place: impl Display, reader: impl Read) -> Result<Vec<u8>, Failure> {
    let most = available_bytes() / BYTES_A_BYTE;
    let mut bytes = Vec::new();
    match reader.take(most + 1).read_to_end(&mut bytes) {
        Ok(count) if count as u64 <= most => Ok(bytes),
        Ok(_) => {
            drop(bytes);
            let (least, available) = (most as f64, (most * BYTES_A_BYTE) as f64);
            let estimate = format_args!(
                "more than {least:.1e} bytes take more than the {available:.1e} bytes of memory \
                 that are available"
            );
            Err(Failure::at(place, estimate))
        }
        Err(error) if error.kind() == io::ErrorKind::OutOfMemory => {
            Err(Failure::at(place, "there is not enough memory for the file"))
        }
        Err(error) => Err(Failure::at(place, error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_available_is_more_than_nothing_and_less_than_everything() {
        let available = available_bytes();
        assert!((1 << 20..1 << 50).contains(&available), "{available}");
    }

    #[test]
    fn what_cannot_be_had_is_refused_with_an_estimate() {
        assert!(demand("--n", "9 objects", 9e3).is_ok());
        for bytes in [1e18, f64::INFINITY, f64::NAN] {
            let Err(Failure::Input(message)) = demand("--n", "9 objects", bytes) else { panic!() };
            assert!(message.starts_with("--n: 9 objects take about "), "{message}");
        }
    }
}
