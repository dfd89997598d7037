//! Failures of a run, and their exit codes.

use std::fmt::Display;
use std::io::{self, Write, stderr};
use std::process::ExitCode;

/// Why a run ended early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad input: what, with index and value.
    Input(String),
    /// What was found could not be written.
    Output(io::Error),
}

impl Failure {
    /// Bad input from `place`, a file's name as a rule.
    pub(crate) fn at(place: impl Display, error: impl Display) -> Self {
        Self::Input(format!("{place}: {error}"))
    }

    /// Prints it on standard error; returns the exit code.
    pub(crate) fn report(self) -> ExitCode {
        match self {
            Self::Input(message) => {
                print_message(message);
                ExitCode::from(2)
            }
            // The reader has closed the pipe.
            Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::from(1),
            Self::Output(error) => {
                print_message(format_args!("the answer could not be written: {error}"));
                ExitCode::from(1)
            }
        }
    }
}

/// The message without control characters, which a name from a file may hold and a terminal obeys;
/// messages of several lines stay so.
fn escaped(message: &str) -> String {
    let escaped = |c: char| {
        if c.is_control() && c != '\n' { c.escape_debug().to_string() } else { c.into() }
    };
    message.chars().map(escaped).collect()
}

/// Prints a line on standard error; ignores that it cannot be written.
pub(crate) fn print_message(message: impl Display) {
    let _ = writeln!(stderr(), "dcd: {}", escaped(&message.to_string()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_control_character_reaches_the_terminal() {
        assert_eq!(escaped("\u{1b}[2Ja\tb\u{9b}\u{7f}\nc"), "\\u{1b}[2Ja\\tb\\u{9b}\\u{7f}\nc");
        assert_eq!(escaped("grün, 1e-3"), "grün, 1e-3");
    }
}
