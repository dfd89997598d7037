//! Finished units of measurement outlive the run that measured them.
//!
//! `units.jsonl` in the folder of results holds one JSON object a line: first the fingerprint of the
//! run, then each unit as it is finished, `{"key": …, "value": …}`, and at the end of a run that
//! measured all it planned, `{"finished": [keys]}`. A later run with the same fingerprint starts from
//! the units that no `finished` line names: a stopped run goes on, a finished one starts anew.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;

use crate::progress::Progress;

/// Whether the units that a stopped run has finished count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// They are picked up, if the fingerprint is the same.
    Resume,
    /// They are measured again.
    Anew,
}

/// The units that a run plans to measure, and the values of those that are finished.
#[derive(Debug)]
pub struct Units {
    file: File,
    plan: Vec<String>,
    values: HashMap<String, Value>,
    progress: Progress,
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Line {
    Head { fingerprint: String },
    Unit { key: String, value: Value },
    Finished { finished: Vec<String> },
}

impl Units {
    /// Plans the units named by `plan`, and picks up those that a stopped run with the same
    /// `fingerprint` has left in `dir`.
    ///
    /// # Errors
    /// A key that the plan names twice; a folder or file that cannot be made, read or written.
    pub fn open(
        dir: &Path,
        fingerprint: &str,
        plan: impl IntoIterator<Item = String>,
        start: Start,
    ) -> Result<Self> {
        let plan: Vec<String> = plan.into_iter().collect();
        let mut seen = HashSet::new();
        for key in &plan {
            ensure!(seen.insert(key), "unit `{key}` is planned twice");
        }
        fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
        let path = dir.join("units.jsonl");
        let (values, good) = match start {
            Start::Resume => left_over(&path, fingerprint)?,
            Start::Anew => (HashMap::new(), 0),
        };
        let file = OpenOptions::new().create(true).append(true).open(&path);
        let file = file.with_context(|| format!("cannot open {}", path.display()))?;
        file.set_len(good).with_context(|| format!("cannot cut {}", path.display()))?;

        let progress = Progress::new(plan.len());
        let mut units = Self { file, plan, values, progress };
        if good == 0 {
            units.append(&Line::Head { fingerprint: fingerprint.to_owned() })?;
        }
        let found = units.plan.len() - units.missing().len();
        if found > 0 {
            eprintln!("{found} of {} units are there from a stopped run", units.plan.len());
        }
        Ok(units)
    }

    /// The value of the unit `key`: as found, else as `work` measures it now, and kept.
    ///
    /// # Errors
    /// A key that is not planned, an error of `work`, a value that cannot be written or read back.
    pub fn run<T: Serialize + DeserializeOwned>(
        &mut self,
        key: &str,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        ensure!(self.plan.iter().any(|planned| planned == key), "unit `{key}` is not planned");
        if let Some(value) = self.values.get(key) {
            let value = T::deserialize(value).with_context(|| format!("unit `{key}` as found"))?;
            self.progress.end();
            return Ok(value);
        }
        self.progress.begin(key);
        let result = work().with_context(|| format!("unit `{key}`"))?;
        let value = serde_json::to_value(&result).with_context(|| format!("unit `{key}`"))?;
        self.append(&Line::Unit { key: key.to_owned(), value: value.clone() })?;
        self.values.insert(key.to_owned(), value);
        self.progress.end();
        Ok(result)
    }

    /// The value of a unit that is finished and was written as a `T`.
    #[must_use]
    pub fn get<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        self.values.get(key).and_then(|value| T::deserialize(value).ok())
    }

    /// The number of units planned.
    #[must_use]
    pub fn planned(&self) -> usize {
        self.plan.len()
    }

    /// The planned units that are not finished, in the order of the plan.
    #[must_use]
    pub fn missing(&self) -> Vec<&str> {
        let unfinished = |key: &&String| !self.values.contains_key(*key);
        self.plan.iter().filter(unfinished).map(String::as_str).collect()
    }

    /// Ends the run: if nothing planned is missing, the next run measures these units anew.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.progress.clear();
        if self.missing().is_empty() {
            let finished = std::mem::take(&mut self.plan);
            self.append(&Line::Finished { finished })?;
        }
        Ok(())
    }

    /// One write a line, so that a run that is killed leaves at most the last line cut.
    fn append(&mut self, line: &Line) -> Result<()> {
        let mut text = serde_json::to_string(line)?;
        text.push('\n');
        self.file.write_all(text.as_bytes()).context("cannot write units.jsonl")
    }
}

/// The unfinished run's values in the file at `path`, and the number of its bytes worth keeping: none
/// if there is no such file, or it is of another fingerprint.
fn left_over(path: &Path, fingerprint: &str) -> Result<(HashMap<String, Value>, u64)> {
    let text = match fs::read(path) {
        Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let mut values = HashMap::new();
    let mut good = 0;
    for line in text.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
        match serde_json::from_str(line) {
            Ok(Line::Head { fingerprint: found }) if good == 0 && found == fingerprint => {}
            Ok(Line::Unit { key, value }) if good > 0 => {
                values.insert(key, value);
            }
            Ok(Line::Finished { finished }) if good > 0 => {
                for key in finished {
                    values.remove(&key);
                }
            }
            Ok(_) | Err(_) => break,
        }
        good += line.len() as u64;
    }
    Ok((values, good))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// A folder of its own for a test, removed at its end.
    struct Dir(PathBuf);

    impl Dir {
        fn new(name: &str) -> Self {
            let name = format!("dcd-benches-{}-{name}", std::process::id());
            let dir = std::env::temp_dir().join(name);
            let _ = fs::remove_dir_all(&dir);
            Self(dir)
        }

        fn open(&self, fingerprint: &str, start: Start) -> Result<Units> {
            let plan = ["a", "b", "c"].map(str::to_owned);
            Units::open(&self.0, fingerprint, plan, start)
        }
    }

    impl Drop for Dir {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn never() -> Result<u32> {
        anyhow::bail!("measured again")
    }

    #[test]
    fn a_stopped_run_goes_on_where_it_stopped() -> Result<()> {
        let dir = Dir::new("stopped");
        let mut first = dir.open("same", Start::Resume)?;
        first.run("a", || Ok(1_u32))?;
        first.run("b", || Ok(2_u32))?;
        drop(first);

        let mut second = dir.open("same", Start::Resume)?;
        assert_eq!(second.missing(), ["c"]);
        assert_eq!(second.run("a", never)?, 1);
        assert_eq!(second.get::<u32>("b"), Some(2));
        assert_eq!(second.run("c", || Ok(3_u32))?, 3);
        assert!(second.missing().is_empty());
        Ok(())
    }

    #[test]
    fn a_finished_run_starts_anew() -> Result<()> {
        let dir = Dir::new("finished");
        let mut first = dir.open("same", Start::Resume)?;
        for key in ["a", "b", "c"] {
            first.run(key, || Ok(0_u32))?;
        }
        first.finish()?;
        assert_eq!(dir.open("same", Start::Resume)?.missing(), ["a", "b", "c"]);
        Ok(())
    }

    #[test]
    fn a_run_that_finishes_with_gaps_is_still_to_go_on() -> Result<()> {
        let dir = Dir::new("gaps");
        let mut first = dir.open("same", Start::Resume)?;
        first.run("a", || Ok(0_u32))?;
        first.finish()?;
        assert_eq!(dir.open("same", Start::Resume)?.missing(), ["b", "c"]);
        Ok(())
    }

    #[test]
    fn a_finished_part_leaves_the_rest_of_a_stopped_run() -> Result<()> {
        let dir = Dir::new("part");
        let mut all = dir.open("same", Start::Resume)?;
        all.run("a", || Ok(1_u32))?;
        all.run("b", || Ok(2_u32))?;
        drop(all);
        Units::open(&dir.0, "same", ["b".to_owned()], Start::Resume)?.finish()?;
        assert_eq!(dir.open("same", Start::Resume)?.missing(), ["b", "c"]);
        Ok(())
    }

    #[test]
    fn another_fingerprint_or_a_wish_starts_anew() -> Result<()> {
        let dir = Dir::new("anew");
        dir.open("one", Start::Resume)?.run("a", || Ok(1_u32))?;
        assert_eq!(dir.open("one", Start::Resume)?.missing(), ["b", "c"]);
        assert_eq!(dir.open("other", Start::Resume)?.missing(), ["a", "b", "c"]);
        dir.open("other", Start::Resume)?.run("a", || Ok(1_u32))?;
        assert_eq!(dir.open("other", Start::Anew)?.missing(), ["a", "b", "c"]);
        Ok(())
    }

    #[test]
    fn a_line_that_was_cut_short_is_measured_again() -> Result<()> {
        let dir = Dir::new("cut");
        let mut first = dir.open("same", Start::Resume)?;
        first.run("a", || Ok(1_u32))?;
        first.run("b", || Ok(2_u32))?;
        drop(first);
        let path = dir.0.join("units.jsonl");
        let text = fs::read_to_string(&path)?;
        fs::write(&path, &text[..text.len() - 3])?;

        let mut second = dir.open("same", Start::Resume)?;
        assert_eq!(second.missing(), ["b", "c"]);
        second.run("b", || Ok(5_u32))?;
        drop(second);
        assert_eq!(dir.open("same", Start::Resume)?.get::<u32>("b"), Some(5));
        Ok(())
    }

    #[test]
    fn a_unit_that_fails_stays_missing() -> Result<()> {
        let dir = Dir::new("fails");
        let mut units = dir.open("same", Start::Resume)?;
        assert!(units.run("a", never).is_err());
        assert_eq!(units.missing(), ["a", "b", "c"]);
        Ok(())
    }

    #[test]
    fn keys_outside_the_plan_and_twice_in_it_are_refused() -> Result<()> {
        let dir = Dir::new("keys");
        assert!(dir.open("same", Start::Resume)?.run("d", || Ok(1_u32)).is_err());
        let twice = ["a", "a"].map(str::to_owned);
        assert!(Units::open(&dir.0, "same", twice, Start::Resume).is_err());
        Ok(())
    }
}
