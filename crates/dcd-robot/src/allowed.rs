//! Pairs of links that may touch.

use super::{Robot, RobotError};
use std::collections::BTreeSet;
use std::path::Path;

/// Pairs of names, of links or obstacles, that may touch: no contact of theirs is told.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AllowedPairs(BTreeSet<[String; 2]>);

impl AllowedPairs {
    /// Reads the `disable_collisions` of an SRDF file, whatever their reason.
    ///
    /// # Errors
    /// A file that cannot be read or is no XML; a `disable_collisions` without `link1` or `link2`.
    pub fn load(srdf: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(srdf).map_err(RobotError::io(srdf))?;
        let refused =
            |error: String| RobotError::Syntax { what: "SRDF", place: srdf.to_path_buf(), error };
        Self::read(&text).map_err(refused)
    }

    fn read(text: &str) -> Result<Self, String> {
        let document = roxmltree::Document::parse(text).map_err(|error| error.to_string())?;
        let root = document.root_element();
        if !root.has_tag_name("robot") {
            return Err(format!("the root is {:?}, not \"robot\"", root.tag_name().name()));
        }
        let mut allowed = Self::default();
        for pair in root.descendants().filter(|node| node.has_tag_name("disable_collisions")) {
            let link = |name| {
                pair.attribute(name).ok_or_else(|| {
                    let place = document.text_pos_at(pair.range().start);
                    format!("disable_collisions at {place} has no {name}")
                })
            };
            allowed.allow(link("link1")?, link("link2")?);
        }
        Ok(allowed)
    }

    /// Links that touch by how they are built, for a robot without SRDF: those that a joint joins,
    /// links without a shape between them passed over, and those that no joint moves against each
    /// other.
    pub fn adjacent(robot: &Robot) -> Self {
        let mut allowed = Self::default();
        let (body, parent) = robot.bodies_and_parents();
        let name = |link: usize| robot.links()[link].name.as_str();
        for a in 0..robot.links().len() {
            if let Some(b) = parent[a] {
                allowed.allow(name(a), name(b));
            }
            for b in (a + 1)..robot.links().len() {
                if body[a] == body[b] {
                    allowed.allow(name(a), name(b));
                }
            }
        }
        allowed
    }

    /// Allows a pair, in either order.
    pub fn allow(&mut self, a: &str, b: &str) {
        self.0.insert(ordered(a, b));
    }

    /// Allows all pairs of the other set too.
    pub fn extend(&mut self, other: &Self) {
        self.0.extend(other.0.iter().cloned());
    }

    /// Whether the pair may touch, in either order.
    pub fn contains(&self, a: &str, b: &str) -> bool {
        self.0.contains(&ordered(a, b))
    }

    /// How many pairs may touch.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether none may.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn ordered(a: &str, b: &str) -> [String; 2] {
    let (first, second) = if a <= b { (a, b) } else { (b, a) };
    [first.to_owned(), second.to_owned()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disabled_pairs_are_read_in_both_orders() {
        let text = r#"<robot name="r">
            <group name="g"><link name="a"/></group>
            <disable_collisions link1="b" link2="a" reason="Adjacent"/>
            <disable_collisions link1="a" link2="c"/></robot>"#;
        let allowed = AllowedPairs::read(text).unwrap();
        assert_eq!(allowed.len(), 2);
        assert!(allowed.contains("a", "b") && allowed.contains("b", "a"));
        assert!(allowed.contains("c", "a") && !allowed.contains("b", "c"));
    }

    #[test]
    fn what_is_no_srdf_is_refused_with_its_place() {
        let refused = |text: &str| AllowedPairs::read(text).unwrap_err();
        let lacking = refused("<robot>\n  <disable_collisions link1=\"a\"/>\n</robot>");
        assert_eq!(lacking, "disable_collisions at 2:3 has no link2");
        assert!(AllowedPairs::read("<robot").is_err());
        assert!(refused("<scene/>").contains("\"scene\""));
        assert!(matches!(
            AllowedPairs::load(Path::new("no/such.srdf")),
            Err(RobotError::Io { path, .. }) if path == Path::new("no/such.srdf")
        ));
    }
}
