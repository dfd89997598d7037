//! Precisions by name, and the words for undecided pairs.

use clap::ValueEnum;
use dcd_gjk::Reason;
use serde::Serialize;

/// Whose answer is computed, and what it guarantees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Precision {
    /// f32 without error bounds: right but for gaps and overlaps of some 1e-5 of the size; in `pairs`
    /// GJK in f32, undecided there
    Fast,
    /// GJK in f64: answers what f64 can prove, else undecided
    F64,
    /// Every answer proved, down to exact integers: never undecided for hulls
    #[default]
    Certified,
    /// Parry's own shapes and queries in f32, passed on right or wrong
    ParryF32,
    /// Parry's own shapes and queries in f64, passed on right or wrong
    ParryF64,
}

/// Whose pipelines or solvers a [`Precision`] uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Library {
    Ours(dcd_pipeline::Precision),
    ParryF32,
    ParryF64,
}

impl Precision {
    /// Whose, and for ours what the answer guarantees.
    pub(crate) fn library(self) -> Library {
        match self {
            Self::Fast => Library::Ours(dcd_pipeline::Precision::Fast),
            Self::F64 => Library::Ours(dcd_pipeline::Precision::F64),
            Self::Certified => Library::Ours(dcd_pipeline::Precision::Certified),
            Self::ParryF32 => Library::ParryF32,
            Self::ParryF64 => Library::ParryF64,
        }
    }

    /// As it is written on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::F64 => "f64",
            Self::Certified => "certified",
            Self::ParryF32 => "parry-f32",
            Self::ParryF64 => "parry-f64",
        }
    }
}

/// How tight the error bound of a measure must be; the contacts do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Accuracy {
    /// Some millionths of the pair's size
    F32,
    /// What f64 gives: some 3e-14 of the pair's size
    F64,
    /// Nine digits of a depth and twelve of a distance, however small
    #[default]
    Certified,
}

impl From<Accuracy> for dcd_gjk::Accuracy {
    fn from(accuracy: Accuracy) -> Self {
        match accuracy {
            Accuracy::F32 => Self::F32,
            Accuracy::F64 => Self::F64,
            Accuracy::Certified => Self::Certified,
        }
    }
}

/// Why a pair stayed undecided, in words.
pub(crate) fn in_words(reason: Reason) -> &'static str {
    match reason {
        Reason::WithinRounding => "within rounding",
        Reason::Iterations => "out of iterations",
        Reason::Range => "out of range",
        Reason::Foreign => "the library gives no answer",
        _ => "for another reason",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_is_named_as_the_command_line_and_json_write_it() {
        for precision in Precision::value_variants() {
            let written = precision.to_possible_value().map(|value| value.get_name().to_owned());
            assert_eq!(written.as_deref(), Some(precision.name()));
            assert_eq!(serde_json::to_value(precision).unwrap(), precision.name());
        }
    }
}
