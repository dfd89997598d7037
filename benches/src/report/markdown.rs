//! A report as Markdown.

use super::{Report, Section};

pub(super) fn page(report: &Report) -> String {
    let mut parts = vec![format!("# {}\n", report.title)];
    if let Some(gaps) = report.gaps() {
        parts.push(format!("**{gaps}**\n"));
    }
    for section in &report.sections {
        parts.push(match section {
            Section::Heading(text) => format!("## {text}\n"),
            Section::Note(text) => format!("{text}\n"),
            Section::Table(table) => format!("**{}**\n\n{}", table.title(), table.to_markdown()),
            Section::Figure(figure) => format!("![{}]({}.svg)\n", figure.title(), figure.id()),
        });
    }
    let mut header = String::from("## Measured on\n\n| | |\n| --- | --- |\n");
    for (name, value) in report.header.lines() {
        header.push_str(&format!("| {name} | {} |\n", value.replace('|', "\\|")));
    }
    parts.push(header);
    parts.join("\n")
}
