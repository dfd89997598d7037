//! The size of an XML text, found without building anything from it.

use std::fmt;

/// How much an XML text may have of what costs a parser more than time linear in its length.
#[derive(Clone, Copy, Debug)]
pub struct XmlBounds {
    /// Elements: some hundred bytes of memory each.
    pub elements: usize,
    /// How deep elements are nested.
    pub nesting: usize,
    /// Attributes of one element: whether two are equal is found by comparing all.
    pub attributes: usize,
    /// Namespaces declared: each is copied to what stands inside.
    pub namespaces: usize,
}

/// That an XML text has too much of something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct XmlTooLarge {
    /// Of what.
    pub what: &'static str,
    /// The most that it may have.
    pub limit: usize,
    /// The line, counted from 1.
    pub line: usize,
}

impl fmt::Display for XmlTooLarge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: more than {} {}", self.line, self.limit, self.what)
    }
}

impl std::error::Error for XmlTooLarge {}

impl XmlBounds {
    /// Refuses a text that has too much of something, in one pass over its bytes. Says nothing about
    /// whether it is XML at all: that is the parser's matter, which may work on what passes here.
    ///
    /// # Errors
    /// More of something than the bounds, with its line.
    pub fn check(&self, text: &str) -> Result<(), XmlTooLarge> {
        let mut scan =
            Scan { bounds: self, rest: text, line: 1, depth: 0, elements: 0, namespaces: 0 };
        while scan.skip_to("<") {
            scan.markup().map_err(|Excess(what, limit)| XmlTooLarge {
                what,
                limit,
                line: scan.line,
            })?;
        }
        Ok(())
    }
}

/// What there is too much of, and the most that there may be.
struct Excess(&'static str, usize);

struct Scan<'a> {
    bounds: &'a XmlBounds,
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
    fn markup(&mut self) -> Result<(), Excess> {
        let ends = [("!--", "-->"), ("![CDATA[", "]]>"), ("?", "?>"), ("!", ">")];
        if let Some((_, end)) = ends.iter().find(|(start, _)| self.rest.starts_with(start)) {
            self.skip_to(end);
        } else if self.rest.starts_with('/') {
            self.depth = self.depth.saturating_sub(1);
            self.skip_to(">");
        } else {
            self.elements += 1;
            bounded("elements", self.elements, self.bounds.elements)?;
            if !self.tag()? {
                self.depth += 1;
                bounded("nested elements", self.depth, self.bounds.nesting)?;
            }
        }
        Ok(())
    }

    /// A start tag up to its `>`; whether it is its own end.
    fn tag(&mut self) -> Result<bool, Excess> {
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
            bounded("attributes of an element", attributes, self.bounds.attributes)?;
            bounded("namespace declarations", self.namespaces, self.bounds.namespaces)?;
            self.skip_to(if mark == b'"' { "\"" } else { "'" });
            last = mark;
        }
    }
}

/// Refuses more than `limit` of something.
fn bounded(what: &'static str, count: usize, limit: usize) -> Result<(), Excess> {
    if count > limit { Err(Excess(what, limit)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: XmlBounds =
        XmlBounds { elements: 2_000_000, nesting: 64, attributes: 64, namespaces: 64 };

    fn refusal(text: &str) -> String {
        BOUNDS.check(text).unwrap_err().to_string()
    }

    #[test]
    fn depth_counts_what_is_open_and_not_what_stands_in_comments_or_values() {
        let deep = "<a x='/>' y=\">\">\n".repeat(BOUNDS.nesting);
        assert!(BOUNDS.check(&deep).is_ok());
        assert!(refusal(&(deep.clone() + "<a>")).contains("line 65: more than 64 nested elements"));
        assert!(
            BOUNDS.check(&(deep + "<!-- <a><a> --><a/><![CDATA[<a>]]><?a <a>?></a><a>")).is_ok()
        );
        let wide = "<a b='1'>'\"</a>".repeat(1000);
        assert!(BOUNDS.check(&wide).is_ok());
    }

    #[test]
    fn attributes_namespaces_and_elements_are_counted_before_anything_is_built() {
        let attributes: String = (0..=BOUNDS.attributes).map(|k| format!(" a{k}=''")).collect();
        assert!(refusal(&format!("<a{attributes}>")).contains("attributes of an element"));
        let spaces = "<a xmlns:x='u'/>".repeat(BOUNDS.namespaces + 1);
        assert!(refusal(&spaces).contains("namespace declarations"));
        assert!(refusal(&"<a/>".repeat(BOUNDS.elements + 1)).contains("2000000 elements"));
        for torn in ["<", "<a b='", "<!--", "<a", "</", "<a b=\"\u{e9}"] {
            assert!(BOUNDS.check(torn).is_ok(), "{torn:?}");
        }
    }
}
