//! Bounds of what is read, checked before anything is built from it.

use super::RobotError;
use super::bounds::{NESTING, XML_ATTRIBUTES, XML_ELEMENTS, XML_NAMESPACES};
use dcd_io::{XmlBounds, XmlTooLarge};

/// Refuses an XML text that has too much of something.
pub(super) fn within_bounds(text: &str) -> Result<(), RobotError> {
    let bounds = XmlBounds {
        elements: XML_ELEMENTS,
        nesting: NESTING,
        attributes: XML_ATTRIBUTES,
        namespaces: XML_NAMESPACES,
    };
    let too_large =
        |XmlTooLarge { what, limit, line }| RobotError::TooLarge { what, limit }.at_line(line);
    bounds.check(text).map_err(too_large)
}

/// Refuses more than `limit` of something.
pub(super) fn bounded(what: &'static str, count: usize, limit: usize) -> Result<(), RobotError> {
    if count > limit { Err(RobotError::TooLarge { what, limit }) } else { Ok(()) }
}
