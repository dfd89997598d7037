//! Progress on standard error, if it is a terminal: after two seconds of work.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long work runs without a bar.
const SILENT: Duration = Duration::from_secs(2);
/// How often the bar is drawn.
const REFRESH: Duration = Duration::from_millis(200);

/// Work that is shown until it is dropped.
#[derive(Debug)]
pub(crate) struct Progress {
    done: Arc<AtomicU64>,
    /// The end signal and the drawing thread; none without a terminal.
    drawing: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Of so many steps; `what` is being done. Where the number is not known, 0.
    pub(crate) fn over(total: u64, what: &'static str) -> Self {
        let done = Arc::new(AtomicU64::new(0));
        let drawing = stderr().is_terminal().then(|| {
            let (end, ended) = channel::<()>();
            let counted = Arc::clone(&done);
            let draw = move || {
                if !matches!(ended.recv_timeout(SILENT), Err(RecvTimeoutError::Timeout)) {
                    return;
                }
                let bar = bar(total, what);
                while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(REFRESH) {
                    bar.set_position(counted.load(Ordering::Relaxed));
                    bar.tick();
                }
                bar.finish_and_clear();
            };
            (end, std::thread::spawn(draw))
        });
        Self { done, drawing }
    }

    /// Counts a step.
    pub(crate) fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((end, drawing)) = self.drawing.take() {
            drop(end);
            // Cleared before anything else is printed.
            let _ = drawing.join();
        }
    }
}

fn bar(total: u64, what: &'static str) -> ProgressBar {
    let template = match total {
        0 => "{spinner} {elapsed_precise} {msg}: {pos}",
        1 => "{spinner} {elapsed_precise} {msg}",
        _ => "{elapsed_precise} [{wide_bar}] {pos}/{len} {msg}",
    };
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    bar.set_message(what);
    bar.with_style(style)
}
