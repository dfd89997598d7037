//! A small table with typed cells and units, published figures beside ours, written in four ways.

use std::fmt::Write as _;
use std::time::Duration;

use anyhow::{Result, ensure};
use serde_json::{Map, Value, json};

use crate::report::escape;

/// Where numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Measured by the run that shows them.
    Measured,
    /// Printed in the paper.
    Published,
}

/// One value of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A count, shown with all its digits.
    Count(u64),
    /// A number, rounded where people read it and exact in CSV and JSON. Not finite: missing.
    Number(f64),
    /// Not measured, or not published.
    Missing,
}

/// What one column holds.
#[derive(Clone, Debug)]
pub struct Column {
    name: String,
    unit: String,
    decimals: usize,
    origin: Origin,
}

/// Rows of cells under columns with units.
#[derive(Clone, Debug)]
pub struct Table {
    id: String,
    title: String,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

impl Column {
    /// A column without a unit, its numbers shown to three decimals.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: String::new(), decimals: 3, origin: Origin::Measured }
    }

    /// The same in a unit, "ms" say.
    #[must_use]
    pub fn unit(self, unit: impl Into<String>) -> Self {
        Self { unit: unit.into(), ..self }
    }

    /// The same with its numbers shown to this many decimals.
    #[must_use]
    pub fn decimals(self, decimals: usize) -> Self {
        Self { decimals, ..self }
    }

    /// The same, as the paper has it: its name gets "(paper)" behind it.
    #[must_use]
    pub fn published(self) -> Self {
        Self { origin: Origin::Published, ..self }
    }

    /// Name, origin and unit.
    #[must_use]
    pub fn heading(&self) -> String {
        let origin = if self.origin == Origin::Published { " (paper)" } else { "" };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" [{}]", self.unit) };
        format!("{}{origin}{unit}", self.name)
    }
}

impl Table {
    /// An empty table. Its `id` names its files; `title` stands above it.
    #[must_use]
    pub fn new(
        id: impl Into<String>,
        title: impl Into<String>,
        columns: impl IntoIterator<Item = Column>,
    ) -> Self {
        let columns = columns.into_iter().collect();
        Self { id: id.into(), title: title.into(), columns, rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A row that has not one cell for each column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) -> Result<()> {
        let row: Vec<Cell> = row.into_iter().collect();
        ensure!(
            row.len() == self.columns.len(),
            "table `{}`, row {}: {} cells for {} columns",
            self.id,
            self.rows.len(),
            row.len(),
            self.columns.len()
        );
        self.rows.push(row);
        Ok(())
    }

    /// The name of its files.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// What stands above it.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Comma-separated values after a line of headings; numbers in full, missing ones empty.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let headings = self.columns.iter().map(|column| quoted(&column.heading()));
        let mut csv = headings.collect::<Vec<_>>().join(",");
        csv.push('\n');
        for row in &self.rows {
            let cells = row.iter().map(|cell| match cell {
                Cell::Text(text) => quoted(text),
                Cell::Count(count) => count.to_string(),
                Cell::Number(number) if number.is_finite() => number.to_string(),
                Cell::Number(_) | Cell::Missing => String::new(),
            });
            csv.push_str(&cells.collect::<Vec<_>>().join(","));
            csv.push('\n');
        }
        csv
    }

    /// The title, and each row as an object with the headings as keys; numbers in full.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let object = |row: &Vec<Cell>| -> Map<String, Value> {
            let named = self.columns.iter().zip(row);
            named.map(|(column, cell)| (column.heading(), cell.to_json())).collect()
        };
        let rows: Vec<_> = self.rows.iter().map(object).collect();
        json!({ "title": self.title, "rows": rows })
    }

    /// A table that lines up as plain text too.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut lines: Vec<Vec<String>> = Vec::with_capacity(self.rows.len() + 1);
        lines.push(self.columns.iter().map(Column::heading).collect());
        lines.extend(self.rows.iter().map(|row| self.shown(row)));
        for cell in lines.iter_mut().flatten() {
            *cell = cell.replace('|', "\\|");
        }
        let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max();
        let widths: Vec<usize> =
            (0..self.columns.len()).map(|k| width(k).unwrap_or(0).max(3)).collect();

        let mut markdown = String::new();
        for (index, line) in lines.iter().enumerate() {
            for (k, cell) in line.iter().enumerate() {
                let width = widths[k];
                let _ = if self.is_text(k) {
                    write!(markdown, "| {cell:<width$} ")
                } else {
                    write!(markdown, "| {cell:>width$} ")
                };
            }
            markdown.push_str("|\n");
            if index == 0 {
                for (k, width) in widths.iter().enumerate() {
                    let rule = "-".repeat(width - 1);
                    let rule =
                        if self.is_text(k) { format!("-{rule}") } else { format!("{rule}:") };
                    let _ = write!(markdown, "| {rule} ");
                }
                markdown.push_str("|\n");
            }
        }
        markdown
    }

    /// A `table` element; published columns are of class `published`, words of class `text`.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut html = String::from("<table>\n");
        let headings: Vec<String> = self.columns.iter().map(Column::heading).collect();
        self.html_row(&mut html, "th", &headings);
        for row in &self.rows {
            self.html_row(&mut html, "td", &self.shown(row));
        }
        html.push_str("</table>\n");
        html
    }

    fn html_row(&self, html: &mut String, element: &str, cells: &[String]) {
        html.push_str("<tr>");
        for (k, cell) in cells.iter().enumerate() {
            let class = match (self.columns[k].origin, self.is_text(k)) {
                (Origin::Published, _) => " class=\"published\"",
                (Origin::Measured, true) => " class=\"text\"",
                (Origin::Measured, false) => "",
            };
            let _ = write!(html, "<{element}{class}>{}</{element}>", escape(cell));
        }
        html.push_str("</tr>\n");
    }

    /// The cells of a row as people read them.
    fn shown(&self, row: &[Cell]) -> Vec<String> {
        let shown = |(column, cell): (&Column, &Cell)| match cell {
            Cell::Text(text) => text.clone(),
            Cell::Count(count) => grouped(&count.to_string()),
            Cell::Number(number) if number.is_finite() => {
                grouped(&format!("{number:.*}", column.decimals))
            }
            Cell::Number(_) | Cell::Missing => "–".to_owned(),
        };
        self.columns.iter().zip(row).map(shown).collect()
    }

    /// Whether column `k` holds words, which line up on the left.
    fn is_text(&self, k: usize) -> bool {
        self.rows.iter().any(|row| matches!(row[k], Cell::Text(_)))
    }
}

impl Cell {
    /// The value alone; numbers in full, missing ones null.
    #[must_use]
    pub fn to_json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Count(count) => json!(count),
            Self::Number(number) => json!(number),
            Self::Missing => Value::Null,
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// A duration stands in a column of milliseconds.
impl From<Duration> for Cell {
    fn from(time: Duration) -> Self {
        Self::Number(time.as_secs_f64() * 1e3)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// A decimal number with its integer part in groups of three digits.
pub(crate) fn grouped(number: &str) -> String {
    let start = usize::from(number.starts_with('-'));
    let end = number.find('.').unwrap_or(number.len());
    let mut grouped = String::with_capacity(number.len() + 4);
    for (index, character) in number.char_indices() {
        if index > start && index < end && (end - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(character);
    }
    grouped
}

/// A field of comma-separated values (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stages() -> Result<Table> {
        let mut table = Table::new(
            "table1",
            "Stages",
            [
                Column::new("stage"),
                Column::new("pairs"),
                Column::new("serial").unit("ms"),
                Column::new("serial").unit("ms").decimals(1).published(),
            ],
        );
        table.push(["AABBs, \"exact\"".into(), 0_u64.into(), 0.5.into(), 1.974.into()])?;
        table.push([
            "a < b | c".into(),
            1_934_215_u64.into(),
            Duration::from_micros(12_345_678).into(),
            Cell::Missing,
        ])?;
        Ok(table)
    }

    #[test]
    fn csv_has_quotes_where_needed_and_numbers_in_full() -> Result<()> {
        let csv = "stage,pairs,serial [ms],serial (paper) [ms]\n\
                   \"AABBs, \"\"exact\"\"\",0,0.5,1.974\n\
                   a < b | c,1934215,12345.678,\n";
        assert_eq!(stages()?.to_csv(), csv);
        Ok(())
    }

    #[test]
    fn markdown_lines_up_and_escapes_bars() -> Result<()> {
        let markdown = "\
            | stage          |     pairs | serial [ms] | serial (paper) [ms] |\n\
            | -------------- | --------: | ----------: | ------------------: |\n\
            | AABBs, \"exact\" |         0 |       0.500 |                 2.0 |\n\
            | a < b \\| c     | 1,934,215 |  12,345.678 |                   – |\n";
        assert_eq!(stages()?.to_markdown(), markdown);
        Ok(())
    }

    #[test]
    fn html_escapes_and_marks_published_columns() -> Result<()> {
        let html = stages()?.to_html();
        assert!(html.contains("<td class=\"text\">a &lt; b | c</td>"), "{html}");
        assert!(html.contains("<td class=\"published\">2.0</td>"), "{html}");
        Ok(())
    }

    #[test]
    fn json_rows_are_objects_and_missing_values_null() -> Result<()> {
        let json = stages()?.to_json();
        assert_eq!(json["rows"][1]["pairs"], json!(1_934_215));
        assert_eq!(json["rows"][0]["serial (paper) [ms]"], json!(1.974));
        assert_eq!(json["rows"][1]["serial (paper) [ms]"], Value::Null);
        Ok(())
    }

    #[test]
    fn a_number_that_is_not_finite_is_shown_as_missing() -> Result<()> {
        let mut table = Table::new("t", "", [Column::new("x")]);
        table.push([f64::NAN.into()])?;
        assert_eq!(table.to_csv(), "x\n\n");
        assert_eq!(table.to_json()["rows"][0]["x"], Value::Null);
        assert!(table.to_markdown().contains('–'));
        Ok(())
    }

    #[test]
    fn a_row_of_another_length_is_refused_with_its_index() {
        let mut table = Table::new("t", "", [Column::new("x")]);
        let error = table.push([]).map_err(|error| error.to_string());
        assert_eq!(error, Err("table `t`, row 0: 0 cells for 1 columns".to_owned()));
    }

    #[test]
    fn digits_are_grouped_left_of_the_point_only() {
        for (plain, shown) in [
            ("1", "1"),
            ("999", "999"),
            ("1000", "1,000"),
            ("-1000", "-1,000"),
            ("-100", "-100"),
            ("1234567.12345", "1,234,567.12345"),
        ] {
            assert_eq!(grouped(plain), shown);
        }
    }
}
