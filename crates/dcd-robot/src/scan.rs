//! The size of an XML text, found without building anything from it.

use super::RobotError;
use super::bounds::{NESTING, XML_ATTRIBUTES, XML_ELEMENTS, XML_NAMESPACES};

/// Refuses a text that has too much of something, in one pass over its bytes. Says nothing about
/// whether it is XML at all: that is the parser's matter, which may work on what passes here.
pub(super) fn within_bounds(text: &str) -> Result<(), RobotError> {
    let mut scan = Scan { rest: text, line: 1, depth: 0, elements: 0, namespaces: 0 };
    while scan.skip_to("<") {
        scan.markup().map_err(|error| error.at_line(scan.line))?;
    }
    Ok(())
}

struct Scan<'a> {
    rest: &'a str,
    line: usize,
    depth: usize,
    elements: usize,
    namespaces: usize,
}

impl Scan<'_> {
    /// Passes over everything up to the end of `mark`; whether it was there.
    fn skip_to(&mut self, mark: &str) -> bool {
        let (passed, rest) = match self.rest.find(mark) {
            Some(at) => self.rest.split_at(at + mark.len()),
            None => (self.rest, ""),
        };
        self.line += passed.bytes().filter(|&byte| byte == b'\n').count();
        self.rest = rest;
        passed.ends_with(mark)
    }

    /// What stands behind a `<`.
    fn markup(&mut self) -> Result<(), RobotError> {
        let ends = [("!--", "-->"), ("![CDATA[", "]]>"), ("?", "?>"), ("!", ">")];
        if let Some((_, end)) = ends.iter().find(|(start, _)| self.rest.starts_with(start)) {
            self.skip_to(end);
        } else if self.rest.starts_with('/') {
            self.depth = self.depth.saturating_sub(1);
            self.skip_to(">");
        } else {
            self.elements += 1;
            bounded("elements", self.elements, XML_ELEMENTS)?;
            if !self.tag()? {
                self.depth += 1;
                bounded("nested elements", self.depth, NESTING)?;
            }
        }
        Ok(())
    }

    /// A start tag up to its `>`; whether it is its own end.
    fn tag(&mut self) -> Result<bool, RobotError> {
        let (mut attributes, mut last) = (0, 0);
        loop {
            let bytes = self.rest.as_bytes();
            let stop = bytes.iter().position(|byte| matches!(byte, b'>' | b'"' | b'\''));
            let Some(stop) = stop else {
                self.rest = "";
                return Ok(true);
            };
            let (before, mark) = (&bytes[..stop], bytes[stop]);
            self.line += before.iter().filter(|&&byte| byte == b'\n').count();
            last = before.last().copied().unwrap_or(last);
            let declares = before.windows(5).any(|name| name == b"xmlns");
            self.rest = &self.rest[stop + 1..];
            if mark == b'>' {
                return Ok(last == b'/');
            }
            attributes += 1;
            self.namespaces += usize::from(declares);
            bounded("attributes of an element", attributes, XML_ATTRIBUTES)?;
            bounded("namespace declarations", self.namespaces, XML_NAMESPACES)?;
            self.skip_to(if mark == b'"' { "\"" } else { "'" });
            last = mark;
        }
    }
}

/// Refuses more than `limit` of something.
pub(super) fn bounded(what: &'static str, count: usize, limit: usize) -> Result<(), RobotError> {
    if count > limit { Err(RobotError::TooLarge { what, limit }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        within_bounds(text).unwrap_err().to_string()
    }

    #[test]
    fn depth_counts_what_is_open_and_not_what_stands_in_comments_or_values() {
        let deep = "<a x='/>' y=\">\">\n".repeat(NESTING);
        assert!(within_bounds(&deep).is_ok());
        assert!(refusal(&(deep.clone() + "<a>")).contains("line 65: more than 64 nested elements"));
        assert!(
            within_bounds(&(deep + "<!-- <a><a> --><a/><![CDATA[<a>]]><?a <a>?></a><a>")).is_ok()
        );
        let wide = "<a b='1'>'\"</a>".repeat(1000);
        assert!(within_bounds(&wide).is_ok());
    }

    #[test]
    fn attributes_namespaces_and_elements_are_counted_before_anything_is_built() {
        let attributes: String = (0..=XML_ATTRIBUTES).map(|k| format!(" a{k}=''")).collect();
        assert!(refusal(&format!("<a{attributes}>")).contains("attributes of an element"));
        let spaces = "<a xmlns:x='u'/>".repeat(XML_NAMESPACES + 1);
        assert!(refusal(&spaces).contains("namespace declarations"));
        assert!(refusal(&"<a/>".repeat(XML_ELEMENTS + 1)).contains("2000000 elements"));
        for torn in ["<", "<a b='", "<!--", "<a", "</", "<a b=\"\u{e9}"] {
            assert!(within_bounds(torn).is_ok(), "{torn:?}");
        }
    }
}
