//! Collects header, notes, tables and figures, and writes them as files to read and to reuse.

mod html;
mod markdown;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Map, Value, json};

use crate::figure::Chart;
use crate::machine::Header;
use crate::options::Print;
use crate::resume::Units;
use crate::table::Table;

pub(crate) use html::escape;

/// The results of one measuring binary, in the order of reading.
#[derive(Debug)]
pub struct Report {
    name: String,
    title: String,
    header: Header,
    /// The names of units not measured, and the number planned.
    missing: Option<(Vec<String>, usize)>,
    sections: Vec<Section>,
    /// What only the JSON of the whole holds.
    attached: Map<String, Value>,
}

#[derive(Debug)]
enum Section {
    Heading(String),
    Note(String),
    Table(Table),
    Figure(Box<dyn Chart>),
}

impl Report {
    /// An empty report of the binary `name`.
    #[must_use]
    pub fn new(name: impl Into<String>, title: impl Into<String>, header: Header) -> Self {
        let (name, title) = (name.into(), title.into());
        Self { name, title, header, missing: None, sections: Vec::new(), attached: Map::new() }
    }

    /// Says at the top which planned units are not measured, if any.
    pub fn missing(&mut self, units: &Units) {
        let missing: Vec<String> = units.missing().into_iter().map(str::to_owned).collect();
        self.missing = (!missing.is_empty()).then(|| (missing, units.planned()));
    }

    /// Opens a part under a heading.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.sections.push(Section::Heading(text.into()));
    }

    /// Adds a paragraph; what stands between backquotes is set as code.
    pub fn note(&mut self, text: impl Into<String>) {
        self.sections.push(Section::Note(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.sections.push(Section::Table(table));
    }

    /// Adds a figure.
    pub fn figure(&mut self, figure: impl Chart + 'static) {
        self.sections.push(Section::Figure(Box::new(figure)));
    }

    /// Adds a value that only the JSON of the whole holds, under a key of its own.
    pub fn attach(&mut self, key: impl Into<String>, value: Value) {
        self.attached.insert(key.into(), value);
    }

    /// The whole as Markdown; its figures are files beside it.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        markdown::page(self)
    }

    /// The whole as one HTML page that needs no other file.
    ///
    /// # Errors
    /// A figure that cannot be drawn.
    pub fn to_html(&self) -> Result<String> {
        html::page(self)
    }

    /// The whole as JSON, tables and figures under their ids.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let (mut tables, mut figures, mut notes) = (Map::new(), Map::new(), Vec::new());
        for section in &self.sections {
            match section {
                Section::Heading(_) => {}
                Section::Note(text) => notes.push(text),
                Section::Table(table) => {
                    tables.insert(table.id().to_owned(), table.to_json());
                }
                Section::Figure(figure) => {
                    figures.insert(figure.id().to_owned(), figure.to_json());
                }
            }
        }
        let missing = self.missing.as_ref().map_or(&[][..], |(missing, _)| missing);
        let mut whole = json!({
            "header": self.header,
            "missing": missing,
            "notes": notes,
            "tables": tables,
            "figures": figures,
        });
        for (key, value) in &self.attached {
            whole[key] = value.clone();
        }
        whole
    }

    /// Writes `report.md`, `report.html`, each table as CSV, JSON and Markdown, each figure as SVG and JSON into
    /// `dir`, and the whole as JSON into `NAME.json` beside `dir`. Gives the paths of the pages and of
    /// the whole.
    ///
    /// # Errors
    /// A folder or file that cannot be written, a figure that cannot be drawn.
    pub fn write(&self, dir: &Path) -> Result<Vec<PathBuf>> {
        fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
        for section in &self.sections {
            match section {
                Section::Heading(_) | Section::Note(_) => {}
                Section::Table(table) => {
                    let path = |kind: &str| dir.join(format!("{}.{kind}", table.id()));
                    write(&path("csv"), &(self.comments() + &table.to_csv()))?;
                    write(&path("json"), &self.headed(table.to_json())?)?;
                    write(&path("md"), &table.to_markdown())?;
                }
                Section::Figure(figure) => {
                    let path = |kind: &str| dir.join(format!("{}.{kind}", figure.id()));
                    write(&path("svg"), &figure.to_svg()?)?;
                    write(&path("json"), &self.headed(figure.to_json())?)?;
                }
            }
        }
        let whole = dir.with_file_name(format!("{}.json", self.name));
        let pages = vec![dir.join("report.md"), dir.join("report.html"), whole];
        write(&pages[0], &self.to_markdown())?;
        write(&pages[1], &self.to_html()?)?;
        write(&pages[2], &(serde_json::to_string_pretty(&self.to_json())? + "\n"))?;
        Ok(pages)
    }

    /// Writes it, and prints its tables and where its pages are, or the whole as JSON.
    ///
    /// # Errors
    /// Those of [`Report::write`].
    pub fn hand_out(&self, dir: &Path, print: Print) -> Result<()> {
        let pages = self.write(dir)?;
        if print.json {
            println!("{}", self.to_json());
        } else {
            println!("{}", self.to_markdown());
            pages.iter().for_each(|page| println!("{}", page.display()));
        }
        Ok(())
    }

    /// The header as comment lines, as they stand above comma-separated values.
    fn comments(&self) -> String {
        let lines = self.header.lines();
        lines.into_iter().map(|(name, value)| format!("# {name}: {value}\n")).collect()
    }

    fn headed(&self, value: Value) -> Result<String> {
        let headed = json!({ "header": self.header, "result": value });
        Ok(serde_json::to_string_pretty(&headed)? + "\n")
    }

    /// What is missing, as a sentence.
    fn gaps(&self) -> Option<String> {
        let (missing, planned) = self.missing.as_ref()?;
        let names: Vec<String> = missing.iter().map(|key| format!("`{key}`")).collect();
        let (count, names) = (names.len(), names.join(", "));
        Some(format!(
            "Incomplete: {count} of {planned} units are not measured; the next run goes on with \
             them. Missing: {names}."
        ))
    }
}

/// The whole text or nothing: a run that is interrupted leaves the page that was there.
fn write(path: &Path, text: &str) -> Result<()> {
    let part = path.with_extension("part");
    let write = || fs::write(&part, text).and_then(|()| fs::rename(&part, path));
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Figure, Series};
    use crate::options::Options;
    use crate::resume::Start;
    use crate::table::Column;

    fn report() -> Result<Report> {
        let mut report =
            Report::new("bench", "Tables & figures", Header::observe(&Options::default()));
        report.heading("Stages");
        report.note("Both presets, `paper` < `code`.");
        let mut table = Table::new("table1", "Stages", [Column::new("ours").unit("ms")]);
        table.push([1.25.into()])?;
        report.table(table);
        let mut figure = Figure::new("fig1", "Runtime", Axis::linear("N"), Axis::linear("ms"));
        figure.push(Series::measured("tree", [(1.0, 2.0), (2.0, 3.0)]))?;
        report.figure(figure);
        Ok(report)
    }

    /// Runs a test in a folder of its own.
    fn within<T>(name: &str, test: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
        let name = format!("dcd-benches-{}-{name}", std::process::id());
        let dir = std::env::temp_dir().join(name);
        let result = test(&dir.join("bench"));
        fs::remove_dir_all(&dir)?;
        result
    }

    #[test]
    fn every_file_is_written_and_headed() -> Result<()> {
        within("written", |dir| {
            let pages = report()?.write(dir)?;
            assert!(pages.iter().all(|page| page.is_file()));
            let csv = fs::read_to_string(dir.join("table1.csv"))?;
            assert!(csv.starts_with("# CPU: ") && csv.ends_with("\nours [ms]\n1.25\n"), "{csv}");
            let markdown = fs::read_to_string(dir.join("table1.md"))?;
            assert!(markdown.starts_with("| ours [ms] |"), "{markdown}");
            let json: Value = serde_json::from_str(&fs::read_to_string(dir.join("table1.json"))?)?;
            assert_eq!(json["result"]["rows"][0]["ours [ms]"], json!(1.25));
            assert!(json["header"]["compiler"].is_string());
            let figure: Value = serde_json::from_str(&fs::read_to_string(dir.join("fig1.json"))?)?;
            assert_eq!(figure["result"]["series"][0]["points"][1], json!([2.0, 3.0]));
            assert!(fs::read_to_string(dir.join("fig1.svg"))?.starts_with("<svg"));
            let whole: Value =
                serde_json::from_str(&fs::read_to_string(dir.with_file_name("bench.json"))?)?;
            assert_eq!(whole["tables"]["table1"]["rows"][0]["ours [ms]"], json!(1.25));
            assert_eq!(whole["missing"], json!([]));
            Ok(())
        })
    }

    #[test]
    fn what_is_attached_stands_in_the_whole_alone() -> Result<()> {
        let mut report = report()?;
        report.attach("results", json!([{ "scene": "paper" }]));
        assert_eq!(report.to_json()["results"][0]["scene"], json!("paper"));
        assert!(
            !report.to_markdown().contains("results") && !report.to_html()?.contains("results")
        );
        Ok(())
    }

    #[test]
    fn the_page_needs_no_other_file() -> Result<()> {
        let html = report()?.to_html()?;
        assert!(html.contains("<svg") && html.contains("<style>") && html.contains("<table>"));
        for outside in ["src=", "href=", "url(", "@import"] {
            assert!(!html.contains(outside), "{outside}");
        }
        assert!(html.contains("<h1>Tables &amp; figures</h1>"));
        assert!(html.contains("<code>paper</code> &lt; <code>code</code>"));
        Ok(())
    }

    #[test]
    fn markdown_shows_header_table_and_figure() -> Result<()> {
        let markdown = report()?.to_markdown();
        for part in ["# Tables & figures\n", "| compiler ", "|     1.250 |", "![Runtime](fig1.svg)"]
        {
            assert!(markdown.contains(part), "{part} in {markdown}");
        }
        assert!(!markdown.contains("Incomplete"));
        Ok(())
    }

    #[test]
    fn an_incomplete_report_names_what_is_missing() -> Result<()> {
        within("missing", |dir| {
            let plan = ["table1/serial", "table1/parallel"].map(str::to_owned);
            let mut units = Units::open(dir, "", plan, Start::Anew)?;
            units.run("table1/serial", || Ok(1.0_f64))?;
            let mut report = report()?;
            report.missing(&units);
            for page in [report.to_markdown(), report.to_html()?] {
                assert!(page.contains("Incomplete: 1 of 2 units"), "{page}");
                assert!(page.contains("table1/parallel") && !page.contains("table1/serial"));
            }
            assert_eq!(report.to_json()["missing"], json!(["table1/parallel"]));
            Ok(())
        })
    }
}
