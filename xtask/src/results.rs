//! Measured results taken into `docs/results`, and the tables of the documents filled from them.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use crate::cargo;

/// Measuring binaries, and their folders in `docs/results`.
const FOLDERS: [(&str, &str); 10] = [
    ("bench", "paper"),
    ("compare", "compare"),
    ("batch", "batch"),
    ("frames", "frames"),
    ("meshes", "meshes"),
    ("scale", "scale"),
    ("accuracy", "accuracy"),
    ("questions", "questions"),
    ("ranks", "ranks"),
    ("robots", "robots"),
];

/// Documents that show tables of the results.
const DOCUMENTS: [&str; 2] = ["docs/results/README.md", "docs/performance.md"];

/// A line that opens a table: `<!-- table compare/summary -->` is the table `summary` of `compare`.
const OPENS: &str = "<!-- table ";
/// The line that closes it.
const CLOSES: &str = "<!-- end of table -->";

/// Copies reports, CSV, figures and JSON of every binary that has been run in full to
/// `docs/results`, and fills the tables of the documents.
///
/// # Errors
/// Results of a quick run, which are no results; a file that cannot be read or written.
pub fn take_in() -> Result<()> {
    let measured = cargo::root().join("target/dcd");
    for (name, folder) in FOLDERS {
        let whole = measured.join(format!("{name}.json"));
        if !whole.is_file() {
            eprintln!("-- {name}: no results in {}", measured.display());
            continue;
        }
        refuse_quick(&whole)?;
        let to = cargo::root().join("docs/results").join(folder);
        let count = copy(&measured.join(name), &to, &whole)?;
        eprintln!("-- {name}: {count} files to {}", to.display());
    }
    for document in DOCUMENTS {
        let path = cargo::root().join(document);
        if !path.is_file() {
            eprintln!("-- {document}: there is no such document");
            continue;
        }
        let text = read(&path)?;
        let filled = filled(&text, |table| {
            let path = measured.join(format!("{table}.md"));
            let found = fs::read_to_string(&path).ok();
            if found.is_none() {
                eprintln!("-- {document}: {} is not measured, its table stays", table);
            }
            found
        });
        let filled = filled.context(document)?;
        replace(&path, &filled).with_context(|| format!("cannot write {document}"))?;
    }
    Ok(())
}

/// Puts the whole text in a document's place, or leaves it as it was.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let part = path.with_extension("part");
    fs::write(&part, text)?;
    fs::rename(&part, path)
}

/// The text with what stands between each pair of marks replaced by the table of that name; where
/// there is none, what stands there stays.
fn filled(text: &str, table: impl Fn(&str) -> Option<String>) -> Result<String> {
    let mut filled = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        filled += &format!("{line}\n");
        let name = line.strip_prefix(OPENS).and_then(|rest| rest.strip_suffix(" -->"));
        let Some(name) = name else { continue };
        let mut old = String::new();
        loop {
            match lines.next() {
                Some(CLOSES) => break,
                Some(line) => old += &format!("{line}\n"),
                None => bail!("the table {name} is not closed by `{CLOSES}`"),
            }
        }
        filled += &table(name).unwrap_or(old);
        filled += &format!("{CLOSES}\n");
    }
    Ok(filled)
}

/// Fails for results of a quick run.
fn refuse_quick(whole: &Path) -> Result<()> {
    #[derive(Deserialize)]
    struct Whole {
        header: Header,
    }
    #[derive(Deserialize)]
    struct Header {
        quick: bool,
    }
    let parsed: Whole = serde_json::from_str(&read(whole)?)
        .with_context(|| format!("cannot make sense of {}", whole.display()))?;
    ensure!(!parsed.header.quick, "{} is of a quick run", whole.display());
    Ok(())
}

/// Copies the report, its tables as CSV, its figures and the whole as JSON; says how many.
fn copy(from: &Path, to: &Path, whole: &Path) -> Result<usize> {
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    let mut files: Vec<PathBuf> = vec![whole.to_owned()];
    let listed = fs::read_dir(from).with_context(|| format!("cannot list {}", from.display()))?;
    for entry in listed {
        let path = entry.with_context(|| format!("cannot list {}", from.display()))?.path();
        let kept = path.extension().is_some_and(|kind| kind == "csv" || kind == "svg");
        if kept || path.file_name().is_some_and(|name| name == "report.md") {
            files.push(path);
        }
    }
    for file in &files {
        let Some(name) = file.file_name() else { continue };
        fs::copy(file, to.join(name)).with_context(|| format!("cannot copy {}", file.display()))?;
    }
    Ok(files.len())
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "above\n<!-- table a/b -->\nold\n<!-- end of table -->\nbelow\n";

    #[test]
    fn a_table_is_replaced_and_all_else_stays() -> Result<()> {
        let new = filled(TEXT, |name| (name == "a/b").then(|| "| new |\n".to_owned()))?;
        assert_eq!(new, TEXT.replace("old", "| new |"));
        assert_eq!(filled(&new, |_| Some("old\n".to_owned()))?, TEXT);
        Ok(())
    }

    #[test]
    fn a_table_that_is_not_measured_stays() -> Result<()> {
        assert_eq!(filled(TEXT, |_| None)?, TEXT);
        Ok(())
    }

    #[test]
    fn a_table_that_is_not_closed_is_refused() {
        let open = TEXT.replace(CLOSES, "");
        assert!(filled(&open, |_| None).unwrap_err().to_string().contains("a/b"));
    }

    #[test]
    fn every_mark_of_the_documents_is_closed() -> Result<()> {
        for document in DOCUMENTS {
            let text = read(&cargo::root().join(document))?;
            assert_eq!(filled(&text, |_| None)?, text, "{document}");
        }
        Ok(())
    }
}
