//! A report as one HTML page that needs no other file.

use std::fmt::Write as _;

use anyhow::Result;

use super::{Report, Section};

const STYLE: &str = include_str!("style.css");

pub(super) fn page(report: &Report) -> Result<String> {
    let title = escape(&report.title);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    let header = &report.header;
    let effort = if header.quick { "quick run" } else { "full run" };
    let _ = writeln!(
        html,
        "<p class=\"summary\">{}, {} cores, {} threads · {} · commit {} · seed {} · {effort}</p>",
        escape(&header.cpu),
        header.cores,
        header.threads,
        escape(&header.compiler),
        escape(&header.commit),
        header.seed,
    );
    if let Some(gaps) = report.gaps() {
        let _ = writeln!(html, "<p class=\"gaps\">{}</p>", with_code(&gaps));
    }
    for section in &report.sections {
        let _ = match section {
            Section::Heading(text) => writeln!(html, "<h2>{}</h2>", escape(text)),
            Section::Note(text) => writeln!(html, "<p>{}</p>", with_code(text)),
            Section::Table(table) => writeln!(
                html,
                "<figure>\n<figcaption>{}</figcaption>\n{}</figure>",
                escape(table.title()),
                table.to_html()
            ),
            Section::Figure(figure) => writeln!(html, "<figure>\n{}</figure>", figure.to_svg()?),
        };
    }
    html.push_str("<details>\n<summary>Measured on</summary>\n<dl>\n");
    for (name, value) in header.lines() {
        let _ = writeln!(html, "<dt>{name}</dt><dd>{}</dd>", escape(&value));
    }
    html.push_str("</dl>\n</details>\n</body>\n</html>\n");
    Ok(html)
}

/// Text that HTML shows as it is, in elements and in quoted attributes.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The same with what stands between backquotes as code.
fn with_code(text: &str) -> String {
    let mut html = String::new();
    for (index, part) in text.split('`').enumerate() {
        let part = escape(part);
        let _ = if index % 2 == 1 {
            write!(html, "<code>{part}</code>")
        } else {
            write!(html, "{part}")
        };
    }
    html
}
