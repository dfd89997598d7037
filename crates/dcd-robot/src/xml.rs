//! XML files: read within bounds, with the line of each element for messages.

use super::bounds::{FILE_BYTES, XML_ELEMENTS};
use super::scan::{bounded, within_bounds};
use super::{RobotError, notes::Unused};
use roxmltree::{Attribute, Document, Node, ParsingOptions};
use std::io::Read;
use std::path::Path;

/// The text of a file, without a byte order mark.
pub(super) fn text_of(path: &Path) -> Result<String, RobotError> {
    let file = std::fs::File::open(path).map_err(RobotError::io(path))?;
    let mut text = String::new();
    let limit = FILE_BYTES as u64 + 1;
    file.take(limit).read_to_string(&mut text).map_err(RobotError::io(path))?;
    bounded("bytes", text.len(), FILE_BYTES).map_err(|error| error.inside(path))?;
    if text.starts_with('\u{feff}') {
        text.remove(0);
    }
    Ok(text)
}

/// The tree of a text that is a `what`.
pub(super) fn parse<'a>(what: &'static str, text: &'a str) -> Result<Document<'a>, RobotError> {
    within_bounds(text)?;
    // Text and comments between elements are nodes too.
    let nodes_limit = 4 * XML_ELEMENTS as u32;
    let options = ParsingOptions { nodes_limit, ..ParsingOptions::default() };
    let refused = |error| RobotError::NotOfKind { what, error };
    let document = Document::parse_with_options(text, options).map_err(|error| match error {
        // The parser names no line of it.
        roxmltree::Error::DtdDetected => {
            let line =
                text.split("<!DOCTYPE").next().map_or(0, |before| before.matches('\n').count());
            refused("a document type and its entities are not read".to_owned()).at_line(line + 1)
        }
        error => refused(error.to_string()).at_line(error.pos().row as usize),
    })?;
    if is_prefixed(document.root_element()) {
        let error =
            format!("the root {:?} has a prefix", document.root_element().tag_name().name());
        return Err(refused(error).at_line(Lines::of(text).line(document.root_element())));
    }
    match document.descendants().find_map(|node| Some((node, nameless(text, node)?))) {
        None => Ok(document),
        Some((node, name)) => {
            let error = format!("a prefix without a name before \":{name}\"");
            Err(refused(error).at_line(Lines::of(text).line(node)))
        }
    }
}

/// The name of an element, or of an attribute of it, that begins with a colon: the parser drops it, and takes <:link> for
/// a link.
fn nameless<'a>(text: &str, node: Node<'a, '_>) -> Option<&'a str> {
    if text[node.range()].starts_with("<:") {
        return Some(node.tag_name().name());
    }
    let mut attributes = node.attributes();
    attributes.find(|attribute| text[attribute.range()].starts_with(':')).map(|a| a.name())
}

/// Where lines begin: the parser's own search for a line walks the text from its start each time.
pub(super) struct Lines(Vec<usize>);

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(at, _)| at).collect())
    }

    /// From 1.
    pub(super) fn line(&self, node: Node<'_, '_>) -> usize {
        self.0.partition_point(|&end| end < node.range().start) + 1
    }
}

/// Whether an attribute is one of those known, which are in no namespace.
fn is_among(attribute: &Attribute<'_, '_>, known: &[&str]) -> bool {
    attribute.namespace().is_none() && known.contains(&attribute.name())
}

/// Whether an element is called by a prefix, which is a part of its name to readers that know no namespaces.
fn is_prefixed(node: Node<'_, '_>) -> bool {
    let text = &node.document().input_text()[node.range()];
    let name = text.split(|c: char| c.is_whitespace() || c == '/' || c == '>').next();
    name.is_some_and(|name| name.contains(':'))
}

/// What stands between the elements inside this one, if it is more than space.
fn said_by_text<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let texts = node.children().filter(Node::is_text).filter_map(|child| child.text());
    texts.map(str::trim).find(|text| !text.is_empty())
}

/// What walks over a file's elements: knows their lines, and collects what it passes over.
pub(super) struct Walk {
    lines: Lines,
    pub(super) unused: Unused,
}

/// Elements of other namespaces that would place shapes, were they of this one.
const CARRY_GEOMETRY: [&str; 10] = [
    "link",
    "joint",
    "collision",
    "geometry",
    "origin",
    "box",
    "sphere",
    "cylinder",
    "capsule",
    "mesh",
];

impl Walk {
    pub(super) fn of(text: &str) -> Self {
        Self { lines: Lines::of(text), unused: Unused::default() }
    }

    pub(super) fn line(&self, node: Node<'_, '_>) -> usize {
        self.lines.line(node)
    }

    /// The error with the element's line.
    pub(super) fn at(&self, node: Node<'_, '_>, error: RobotError) -> RobotError {
        error.at_line(self.line(node))
    }

    /// A refusal of the element.
    pub(super) fn refused(
        &self,
        node: Node<'_, '_>,
        user: &str,
        why: impl Into<String>,
    ) -> RobotError {
        self.at(node, RobotError::Refused { user: user.to_owned(), why: why.into() })
    }

    pub(super) fn pass_over(&mut self, node: Node<'_, '_>) {
        self.unused.add(node.tag_name().name(), self.line(node));
    }

    /// The elements inside this one that are of its own namespace. Others are passed over, unless
    /// they are called as what carries geometry is.
    pub(super) fn children<'a, 'input>(
        &mut self,
        node: Node<'a, 'input>,
    ) -> Result<Vec<Node<'a, 'input>>, RobotError> {
        let mut own = Vec::new();
        if said_by_text(node).is_some() {
            self.unused.add(format!("text in {}", node.tag_name().name()), self.line(node));
        }
        for child in node.children().filter(Node::is_element) {
            let tag = child.tag_name();
            let is_own = tag.namespace() == node.tag_name().namespace();
            // ROS reads an element by its name as it stands, whatever its namespace.
            if is_own == is_prefixed(child) {
                let why =
                    format!("{} has a namespace of its own, or a prefix without one", tag.name());
                return Err(self.refused(child, node.tag_name().name(), why));
            }
            if is_own {
                own.push(child);
            } else if CARRY_GEOMETRY.contains(&tag.name()) {
                let why = format!("a {} in another namespace is not understood", tag.name());
                return Err(self.refused(child, node.tag_name().name(), why));
            } else {
                self.unused.add(format!("{} of another namespace", tag.name()), self.line(child));
            }
        }
        Ok(own)
    }

    /// Refuses what is not expanded: an element of xacro, or a value that is still to be computed.
    pub(super) fn refuse_xacro(&self, document: &Document<'_>) -> Result<(), RobotError> {
        const HOW: &str = "xacro must be expanded first: xacro FILE > robot.urdf";
        for node in document.descendants().filter(Node::is_element) {
            let tag = node.tag_name();
            let is_xacro = |space: Option<&str>| space.is_some_and(|uri| uri.contains("xacro"));
            let user = || format!("element {:?}", tag.name());
            if is_xacro(tag.namespace()) {
                return Err(self.refused(node, &user(), HOW));
            }
            for attribute in node.attributes() {
                let value = attribute.value();
                if is_xacro(attribute.namespace()) || value.contains("${") || value.contains("$(") {
                    let why = format!("{} is {value:?}: {HOW}", attribute.name());
                    return Err(self.refused(node, &user(), why));
                }
            }
        }
        Ok(())
    }

    /// Refuses what an element holds inside, and attributes that are not among those known: of an element that
    /// says all that it says by attributes. Elements of other namespaces are passed over.
    pub(super) fn only_attributes(
        &mut self,
        node: Node<'_, '_>,
        known: &[&str],
        user: &str,
    ) -> Result<(), RobotError> {
        self.only(node, known, user)?;
        let element = node.tag_name().name();
        if let Some(child) = self.children(node)?.first() {
            let why =
                format!("element {:?} is not understood in {element}", child.tag_name().name());
            return Err(self.refused(*child, user, why));
        }
        match said_by_text(node) {
            None => Ok(()),
            Some(text) => {
                let why = format!("{element} says {text:?}, where attributes alone are understood");
                Err(self.refused(node, user, why))
            }
        }
    }

    /// Counts those attributes as not used that are not among those known.
    pub(super) fn pass_over_attributes(&mut self, node: Node<'_, '_>, known: &[&str]) {
        for attribute in node.attributes().filter(|a| !is_among(a, known)) {
            let of = node.tag_name().name();
            self.unused.add(format!("{} of {of}", attribute.name()), self.line(node));
        }
    }

    /// Refuses attributes that are not among those known.
    pub(super) fn only(
        &self,
        node: Node<'_, '_>,
        known: &[&str],
        user: &str,
    ) -> Result<(), RobotError> {
        let unknown = node.attributes().find(|a| !is_among(a, known));
        match unknown {
            None => Ok(()),
            Some(attribute) => {
                let why = format!(
                    "{} has no attribute {:?}{} that is understood, only {}",
                    node.tag_name().name(),
                    attribute.name(),
                    if attribute.namespace().is_some() { " of another namespace" } else { "" },
                    known.join(", ")
                );
                Err(self.refused(node, user, why))
            }
        }
    }

    pub(super) fn required<'a>(
        &self,
        node: Node<'a, '_>,
        name: &str,
        user: &str,
    ) -> Result<&'a str, RobotError> {
        node.attribute(name).ok_or_else(|| {
            self.refused(node, user, format!("{} has no {name}", node.tag_name().name()))
        })
    }

    /// The finite numbers of an attribute, as many as there must be; none where it is absent.
    pub(super) fn numbers<const N: usize>(
        &self,
        node: Node<'_, '_>,
        name: &str,
        user: &str,
    ) -> Result<Option<[f64; N]>, RobotError> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        let numbers = self.any_numbers(node, name, user)?;
        let found = numbers.len();
        let counted = numbers.try_into().map_err(|_| {
            let element = node.tag_name().name();
            let why = format!("{name} of {element} is {text:?}: {found} numbers, not {N}");
            self.refused(node, user, why)
        });
        counted.map(Some)
    }

    /// The finite numbers of an attribute that is there, at least one.
    pub(super) fn any_numbers(
        &self,
        node: Node<'_, '_>,
        name: &str,
        user: &str,
    ) -> Result<Vec<f64>, RobotError> {
        let text = node.attribute(name).unwrap_or_default();
        let element = node.tag_name().name();
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            let Ok(value) = word.parse::<f64>() else {
                let why = format!("{name} of {element} is {text:?}, where {word:?} is no number");
                return Err(self.refused(node, user, why));
            };
            if !value.is_finite() {
                let (what, user) = (format!("{name} of {element}"), user.to_owned());
                return Err(self.at(node, RobotError::NotANumber { what, user, value }));
            }
            numbers.push(value);
        }
        if numbers.is_empty() {
            let why = format!("{name} of {element} is {text:?}: 0 numbers");
            return Err(self.refused(node, user, why));
        }
        Ok(numbers)
    }

    pub(super) fn number(
        &self,
        node: Node<'_, '_>,
        name: &str,
        user: &str,
    ) -> Result<Option<f64>, RobotError> {
        Ok(self.numbers::<1>(node, name, user)?.map(|[value]| value))
    }
}
