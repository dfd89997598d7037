//! The instruction sets, and which of them a process runs on.

use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicU8, Ordering};

/// The instruction set that a kernel runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// AVX-512 F, DQ, BW and VL beside what [`Path::Avx2`] has: one register of sixteen.
    Avx512,
    /// AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT: two registers of eight.
    Avx2,
    /// What every CPU of the target has: four SSE2 registers of four on x86-64, plain Rust on arrays elsewhere.
    Portable,
}

impl Path {
    /// All, the widest first.
    pub const ALL: [Self; 3] = [Self::Avx512, Self::Avx2, Self::Portable];

    /// Whether this CPU has it.
    #[inline]
    pub fn is_available(self) -> bool {
        let found = match FOUND.load(Ordering::Relaxed) {
            0 => Self::find(),
            found => found,
        };
        found & self.bit() != 0
    }

    /// Asks the CPU for all paths.
    #[cold]
    fn find() -> u8 {
        let found = Self::ALL.into_iter().filter(|path| path.is_detected());
        let found = found.fold(0, |found, path| found | path.bit());
        FOUND.store(found, Ordering::Relaxed);
        found
    }

    fn bit(self) -> u8 {
        1 << self as u8
    }

    fn is_detected(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_detected()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                // All that its code is compiled with: a virtual machine may hide any of them.
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            Self::Portable => true,
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The widest that this CPU has, or the one that the process was [restricted to](Self::force).
    #[inline]
    pub fn best() -> Self {
        match FORCED.load(Ordering::Relaxed) {
            0 => Self::ALL.into_iter().find(|path| path.is_available()).unwrap_or(Self::Portable),
            forced => Self::ALL[usize::from(forced) - 1],
        }
    }

    /// Makes [`Path::best`] return this path in the whole process from now on: for measurements and tests, on a
    /// CPU with wider registers, of what another CPU would run. Answers that are proved do not change.
    ///
    /// # Errors
    /// This CPU does not have it.
    pub fn force(self) -> Result<(), UnavailablePath> {
        if !self.is_available() {
            return Err(UnavailablePath(self));
        }
        FORCED.store(self as u8 + 1, Ordering::Relaxed);
        Ok(())
    }

    /// Its name on a command line: `avx512`, `avx2` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
            Self::Portable => "portable",
        }
    }
}

/// The bit of each path that this CPU has; 0 before it was asked. Kernels are dispatched thousands of times a step, and the twelve
/// features of the widest path are twelve loads.
static FOUND: AtomicU8 = AtomicU8::new(0);

/// The path that [`Path::force`] has chosen, by its place in [`Path::ALL`] from 1; 0 for none.
static FORCED: AtomicU8 = AtomicU8::new(0);

/// An instruction set that this CPU does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnavailablePath(pub Path);

impl fmt::Display for UnavailablePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "this CPU does not have the instructions of {}", self.0.name())
    }
}

impl std::error::Error for UnavailablePath {}

impl FromStr for Path {
    type Err = String;

    /// By its [name](Path::name).
    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|path| path.name() == name);
        found.ok_or_else(|| format!("{name:?} is none of avx512, avx2 and portable"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_read_by_its_name_and_by_no_other() {
        for path in Path::ALL {
            assert_eq!(path.name().parse(), Ok(path));
        }
        assert!("AVX2".parse::<Path>().is_err_and(|error| error.contains("\"AVX2\"")));
    }

    #[test]
    fn a_path_of_this_cpu_can_be_forced_and_another_is_refused() {
        let widest = Path::best();
        for path in Path::ALL {
            let forced = path.force();
            assert_eq!(forced.is_ok(), path.is_available(), "{path:?}");
            if forced.is_ok() {
                assert_eq!(Path::best(), path);
            }
        }
        // The other tests of this process run on whichever path; the widest is what they would have had.
        assert_eq!(widest.force(), Ok(()));
    }
}
