//! Progress on stderr: a bar where a terminal is watching, else one line for each unit.

use std::io::{IsTerminal, stderr};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress over a known number of units.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    watched: bool,
}

impl Progress {
    /// A bar over `total` units.
    #[must_use]
    pub fn new(total: usize) -> Self {
        let template = "{elapsed_precise} [{wide_bar}] {pos}/{len} {msg}";
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        let bar = ProgressBar::with_draw_target(Some(total as u64), ProgressDrawTarget::stderr());
        Self { bar: bar.with_style(style), watched: stderr().is_terminal() }
    }

    /// Says what is running now.
    pub fn begin(&self, unit: &str) {
        if !self.watched {
            let (position, total) = (self.bar.position() + 1, self.bar.length().unwrap_or(0));
            eprintln!("[{position}/{total}] {unit}");
        }
        self.bar.set_message(unit.to_owned());
    }

    /// Counts one unit as done.
    pub fn end(&self) {
        self.bar.inc(1);
    }

    /// Takes the bar away, so that it does not stand between a reader and the result.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_unit_counts_once() {
        let progress = Progress::new(2);
        progress.begin("one");
        progress.end();
        assert_eq!((progress.bar.position(), progress.bar.length()), (1, Some(2)));
    }
}
