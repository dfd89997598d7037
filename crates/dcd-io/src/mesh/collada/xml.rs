//! Elements of a COLLADA file: their numbers, and what they refer to.

use super::super::{MeshError, MeshFormat, MeshPlace};
use crate::XmlTooLarge;
use roxmltree::{Document, Node};
use std::borrow::Cow;
use std::collections::HashMap;

/// A refusal of an element.
pub(super) fn refused(node: Node<'_, '_>, problem: impl Into<String>) -> MeshError {
    let tag = node.tag_name().name();
    let name = id(node).map_or_else(|| tag.to_owned(), |id| format!("{tag} id={id:?}"));
    let line = node.document().text_pos_at(node.range().start).row as usize;
    MeshError::refused(MeshFormat::Collada, MeshPlace::Element { name, line }, problem)
}

/// A refusal of the text as XML.
pub(super) fn malformed(error: roxmltree::Error) -> MeshError {
    let place = MeshPlace::Line(error.pos().row as usize);
    MeshError::refused(MeshFormat::Collada, place, error.to_string())
}

/// A refusal of a text that has too much of something.
pub(super) fn too_large(XmlTooLarge { what, limit, line }: XmlTooLarge) -> MeshError {
    let problem = format!("more than {limit} {what}");
    MeshError::refused(MeshFormat::Collada, MeshPlace::Line(line), problem)
}

/// The elements inside.
pub(super) fn children<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(Node::is_element)
}

/// Those with this tag.
pub(super) fn own<'a>(node: Node<'a, 'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    children(node).filter(move |child| child.tag_name().name() == tag)
}

pub(super) fn id<'a>(node: Node<'a, 'a>) -> Option<&'a str> {
    node.attribute("id")
}

/// An attribute that must be there.
pub(super) fn attribute<'a>(node: Node<'a, 'a>, name: &'static str) -> Result<&'a str, MeshError> {
    node.attribute(name).ok_or_else(|| refused(node, format!("there is no attribute {name:?}")))
}

/// A count in an attribute; none where it is absent.
pub(super) fn count(node: Node<'_, '_>, name: &'static str) -> Result<Option<usize>, MeshError> {
    let parse = |text: &str| {
        let wrong = |_| refused(node, format!("{name}={text:?} is no count"));
        text.trim().parse().map_err(wrong)
    };
    node.attribute(name).map(parse).transpose()
}

/// Checks that an element holds as many items as it states, if it states it.
pub(super) fn check_count(node: Node<'_, '_>, found: usize) -> Result<(), MeshError> {
    match count(node, "count")? {
        Some(said) if said != found => {
            Err(refused(node, format!("it counts {said}, but holds {found}")))
        }
        _ => Ok(()),
    }
}

/// All text of an element that has no elements inside.
pub(super) fn text<'a>(node: Node<'a, 'a>) -> Result<Cow<'a, str>, MeshError> {
    if let Some(inner) = children(node).next() {
        return Err(refused(inner, format!("an element inside of <{}>", node.tag_name().name())));
    }
    // Comments part a text.
    let mut parts = node.children().filter_map(|child| child.text().filter(|_| child.is_text()));
    let first = parts.next().unwrap_or_default();
    let rest: String = parts.collect();
    Ok(if rest.is_empty() { first.into() } else { (first.to_owned() + &rest).into() })
}

/// The finite numbers of an element's text.
pub(super) fn numbers(node: Node<'_, '_>) -> Result<Vec<f64>, MeshError> {
    let number = |(index, word): (usize, &str)| match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(refused(node, format!("number {index}, {word:?}, is no finite number"))),
    };
    text(node)?.split_ascii_whitespace().enumerate().map(number).collect()
}

/// The indices of an element's text.
pub(super) fn indices(node: Node<'_, '_>) -> Result<Vec<u32>, MeshError> {
    let number = |(index, word): (usize, &str)| {
        word.parse().map_err(|_| refused(node, format!("number {index}, {word:?}, is no index")))
    };
    text(node)?.split_ascii_whitespace().enumerate().map(number).collect()
}

/// The elements by tag and id.
pub(super) struct Ids<'a>(HashMap<(&'a str, &'a str), Known<'a>>);

enum Known<'a> {
    Once(Node<'a, 'a>),
    Often,
}

impl<'a> Ids<'a> {
    pub(super) fn of(document: &'a Document<'a>) -> Self {
        let mut ids = HashMap::new();
        for node in document.descendants() {
            let Some(id) = id(node) else { continue };
            let known = ids.entry((node.tag_name().name(), id));
            known.and_modify(|known| *known = Known::Often).or_insert(Known::Once(node));
        }
        Self(ids)
    }

    /// What an attribute of an element refers to: an element with that tag in the same file.
    pub(super) fn target(
        &self,
        from: Node<'a, 'a>,
        by: &'static str,
        tag: &'static str,
    ) -> Result<Node<'a, 'a>, MeshError> {
        let url = attribute(from, by)?;
        let Some(name) = url.strip_prefix('#') else {
            return Err(refused(from, format!("{url:?} is in another file, which is not read")));
        };
        // Ids of sources are often used again in another geometry.
        let siblings = from.parent().into_iter().chain(from.ancestors().nth(2));
        let beside =
            siblings.flat_map(|above| own(above, tag)).find(|node| id(*node) == Some(name));
        match (beside, self.0.get(&(tag, name))) {
            (_, Some(Known::Once(node))) => Ok(*node),
            (Some(node), _) => Ok(node),
            (None, Some(Known::Often)) => {
                Err(refused(from, format!("there are several <{tag} id={name:?}>")))
            }
            (None, None) => Err(refused(from, format!("there is no <{tag} id={name:?}>"))),
        }
    }
}
