//! What every measuring binary shares: the policy of timing, the header that says where a number
//! comes from, and the tables, figures and reports that show it.
//!
//! A binary plans its units (one number or one row each), has [`Units`] run those that an earlier,
//! stopped run of the same build has not finished, and draws a [`Report`] from what is there:
//!
//! ```
//! use dcd_benches::{Cell, Column, Header, Options, Report, Table, Units, timing};
//!
//! # fn main() -> anyhow::Result<()> {
//! # let dir = std::env::temp_dir().join(format!("dcd-benches-example-{}", std::process::id()));
//! # let options = Options { quick: true, out: Some(dir.clone()), ..Options::default() };
//! let header = Header::observe(&options);
//! let dir = options.dir("sums");
//! let sizes = [1_000_u64, 10_000];
//! let key = |n: u64| format!("sum/N={n}");
//!
//! let mut units = Units::open(&dir, &header.fingerprint(), sizes.map(key), options.start())?;
//! for n in sizes {
//!     units.run(&key(n), || Ok(timing::measure(options.effort(), || (0..n).sum::<u64>())))?;
//! }
//!
//! let mut table = Table::new("sums", "Sums", [Column::new("N"), Column::new("median").unit("ms")]);
//! for n in sizes {
//!     let sample: Option<timing::Sample> = units.get(&key(n));
//!     table.push([Cell::from(n), sample.map(|s| s.median).into()])?;
//! }
//! let mut report = Report::new("sums", "Sums of integers", header);
//! report.missing(&units);
//! report.table(table);
//! report.write(&dir)?;
//! units.finish()?;
//! # std::fs::remove_dir_all(&dir)?;
//! # Ok(())
//! # }
//! ```
//!
//! A time for a wrong set is worth nothing: [`Agreement`] compares contact sets and has each
//! difference judged exactly.
//!
//! Deliberately absent: rivals and anything else that is measured. They belong to the binaries, so
//! that the way of measuring does not depend on what is measured.

#![forbid(unsafe_code)]

pub mod agreement;
pub mod digest;
pub mod draw;
pub mod falling;
pub mod figure;
pub mod machine;
pub mod options;
pub mod progress;
pub mod report;
pub mod resume;
pub mod table;
pub mod timing;

pub use agreement::Agreement;
pub use digest::Digest;
pub use draw::draw;
pub use falling::FallingPile;
pub use figure::{Axis, Chart, Figure, Scale, Series, TradeChart};
pub use machine::Header;
pub use options::{Options, Print, exit_code};
pub use progress::Progress;
pub use report::Report;
pub use resume::{Start, Units};
pub use table::{Cell, Column, Origin, Table};
pub use timing::{Effort, Pair, Sample};
