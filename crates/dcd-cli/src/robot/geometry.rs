//! How meshes of links are represented, and how an answer reports it.

use crate::failure::Failure;
use dcd_robot::{LinkShapes, Robot};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// How meshes of links are represented: `hulls`, `hulls:N` or `meshes`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Links(pub(super) LinkShapes);

impl FromStr for Links {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let shapes = match text.split_once(':') {
            None if text == "hulls" => Some(LinkShapes::Hulls),
            None if text == "meshes" => Some(LinkShapes::Meshes),
            Some(("hulls", count)) => {
                count.parse().ok().map(|vertices| LinkShapes::OuterHulls { vertices })
            }
            _ => None,
        };
        let refused = || format!("{text:?} is none of hulls, hulls:N and meshes");
        shapes.map(Self).ok_or_else(refused)
    }
}

impl fmt::Display for Links {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            LinkShapes::OuterHulls { vertices } => write!(f, "hulls:{vertices}"),
            LinkShapes::Meshes => f.write_str("meshes"),
            _ => f.write_str("hulls"),
        }
    }
}

impl Serialize for Links {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The meshes of one link: `LINK=` and their representation.
#[derive(Clone, Debug)]
pub(super) struct LinksOf(String, Links);

impl FromStr for LinksOf {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A link's name may have an equals sign in it.
        let (link, links) =
            text.rsplit_once('=').ok_or("it is no LINK=hulls, hulls:N or meshes")?;
        Ok(Self(link.to_owned(), links.parse()?))
    }
}

/// The subject of an answer.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Geometry {
    geometry: Links,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    geometry_of: BTreeMap<String, Links>,
    /// The most by which hulls of few vertices exceed their meshes, metres, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
}

impl Geometry {
    pub(super) fn new(links: Links, of_links: &[LinksOf], robot: &Robot) -> Self {
        let largest = robot.parts().iter().map(|part| part.tolerance).fold(0.0, f64::max);
        Self {
            geometry: links,
            geometry_of: shapes_of(of_links),
            tolerance: (largest > 0.0).then_some(largest),
        }
    }
}

impl fmt::Display for Geometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // That meshes are taken as meshes says nothing.
        let taken = |links: &Links| match links.0 {
            LinkShapes::Meshes => "their triangles".to_owned(),
            _ => links.to_string(),
        };
        write!(f, "meshes are taken as {}", taken(&self.geometry))?;
        let mut of = self.geometry_of.iter();
        of.try_for_each(|(link, links)| write!(f, ", of {link:?} as {}", taken(links)))
    }
}

/// By the links' names.
fn shapes_of(of_links: &[LinksOf]) -> BTreeMap<String, Links> {
    of_links.iter().map(|LinksOf(link, links)| (link.clone(), *links)).collect()
}

/// The same, as the library takes it; a link that is named twice is refused.
pub(super) fn link_shapes(of_links: &[LinksOf]) -> Result<BTreeMap<String, LinkShapes>, Failure> {
    let mut shapes = BTreeMap::new();
    for LinksOf(link, Links(of_link)) in of_links {
        if shapes.insert(link.clone(), *of_link).is_some() {
            return Err(Failure::at("--links-of", format!("link {link:?} is named twice")));
        }
    }
    Ok(shapes)
}
