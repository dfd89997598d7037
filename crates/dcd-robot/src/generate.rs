//! Which pairs of links may touch, found from the robot itself, as MoveIt's setup assistant does; but what never
//! touches is proved where that can be.
//!
//! Samples find which pairs touch always and which sometimes. For the others a branch and bound over the
//! joints between the two links, within their limits, finds a state in which they touch, or proves that
//! there is none: at the middle of a box of joint values the distance is known with its bound, and no
//! point of a link comes nearer than the motion bounds of [`edge`](crate::EdgeChecker) allow. What that leaves
//! open is searched downhill from many states.

mod branch;
mod samples;
#[cfg(test)]
mod tests;

use super::bounds::ALLOWED_PAIRS;
use super::scan::bounded;
use super::{AllowedPairs, Robot, RobotError};
use branch::{Joints, Outcome};
use samples::Ranges;
use std::fmt::Write;

/// How the pairs of a robot are searched.
///
/// ```
/// use dcd_robot::{PairReason, PairSearch, Robot, write_srdf};
/// use std::path::Path;
/// let guide = Path::new("../../docs/guide/arm"); // the guide's arm and its shelf
/// let robot = Robot::load(&guide.join("arm_description/urdf/arm.urdf"))?;
/// let pairs = PairSearch::default().run(&robot)?;
/// let neighbours = pairs.iter().filter(|pair| pair.reason == PairReason::Adjacent);
/// assert_eq!(neighbours.count(), 6); // one each joint
/// let srdf = write_srdf("arm", &pairs);
/// assert!(srdf.contains("disable_collisions"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PairSearch {
    /// How many states are drawn. More: fewer pairs that touch in few states are taken for pairs that
    /// never do.
    pub samples: usize,
    /// What they are drawn from: the same pairs for the same seed.
    pub seed: u64,
    /// How many boxes of joint values may be looked at for each pair before it counts as unproved.
    pub nodes: usize,
}

impl Default for PairSearch {
    fn default() -> Self {
        Self { samples: 10_000, seed: 0, nodes: 4096 }
    }
}

/// Two links that may touch, or never do, and so need no check.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LinkPair {
    /// The links' names, in their order.
    pub links: [String; 2],
    /// Why.
    pub reason: PairReason,
}

/// Why a pair of links needs no check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairReason {
    /// A joint joins them, links without a shape passed over.
    Adjacent,
    /// They touch in every sample, of which there is one at least, and at rest.
    Always,
    /// They touch where all joints are 0 (or at the limit nearest to it), but not always: a fault of the
    /// model, for a robot at rest should be free.
    Default,
    /// They touch nowhere within the limits.
    Never {
        /// Whether that is proved; else no sample and no searched state touches.
        proved: bool,
    },
}

impl PairReason {
    /// As an SRDF has it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Adjacent => "Adjacent",
            Self::Always => "Always",
            Self::Default => "Default",
            Self::Never { .. } => "Never",
        }
    }
}

impl PairSearch {
    /// The pairs of links that need no check, in the order of their names. Adjacent ones apart, none of links between which a joint
    /// slides without limits: what they do far away no sample shows.
    ///
    /// # Errors
    /// A joint whose least value is above its largest; a state within the limits for which a part is out
    /// of range; more pairs of links with shapes than [`ALLOWED_PAIRS`].
    pub fn run(&self, robot: &Robot) -> Result<Vec<LinkPair>, RobotError> {
        let ranges = Ranges::of(robot)?;
        let (_, parents) = robot.bodies_and_parents();
        let mut parts = vec![Vec::new(); robot.links().len()];
        for (index, part) in robot.parts().iter().enumerate() {
            parts[part.link].push(index);
        }
        let with_shapes: Vec<usize> = (0..parts.len()).filter(|&k| !parts[k].is_empty()).collect();
        let count = with_shapes.len();
        bounded("pairs of links", count * count.saturating_sub(1) / 2, ALLOWED_PAIRS)?;
        let joints = Joints::of(robot, &ranges);
        let (mut found, mut open) = (Vec::new(), Vec::new());
        for (k, &a) in with_shapes.iter().enumerate() {
            for &b in &with_shapes[k + 1..] {
                if parents[a] == Some(b) || parents[b] == Some(a) {
                    found.push(([a, b], PairReason::Adjacent));
                } else if !ranges.are_endless(&joints.values_between([a, b])) {
                    open.push([a, b]);
                }
            }
        }
        let sampled = samples::of(robot, &ranges, &parts, open, (self.samples, self.seed))?;
        found.extend(sampled.reasons);
        for pair in sampled.apart {
            match joints.search(pair, &parts, (self.nodes, self.seed))? {
                Outcome::Free => found.push((pair, PairReason::Never { proved: true })),
                Outcome::Open => found.push((pair, PairReason::Never { proved: false })),
                Outcome::Touches => {}
            }
        }
        let mut pairs: Vec<LinkPair> = found
            .into_iter()
            .map(|(links, reason)| {
                let mut links = links.map(|link| robot.links()[link].name.clone());
                links.sort();
                LinkPair { links, reason }
            })
            .collect();
        pairs.sort();
        Ok(pairs)
    }
}

impl AllowedPairs {
    /// Those pairs, whatever their reason.
    pub fn from_pairs<'a>(pairs: impl IntoIterator<Item = &'a LinkPair>) -> Self {
        let mut allowed = Self::default();
        for LinkPair { links: [a, b], .. } in pairs {
            allowed.allow(a, b);
        }
        allowed
    }
}

/// The pairs as an SRDF of that robot, which [`Srdf::read`](super::Srdf::read) and MoveIt read:
/// `disable_collisions` with their reasons, those of `Never` with `proved`.
pub fn write_srdf(robot: &str, pairs: &[LinkPair]) -> String {
    let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", escaped(robot));
    for LinkPair { links, reason } in pairs {
        let [a, b] = links.each_ref().map(|name| escaped(name));
        let reason_name = reason.as_str();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason_name}\""
        );
        if let PairReason::Never { proved } = reason {
            let _ = write!(text, " proved=\"{proved}\"");
        }
        text.push_str("/>\n");
    }
    text + "</robot>\n"
}

/// A name as the value of an attribute.
fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '"' => text.push_str("&quot;"),
            // A reader would make a space of them.
            '\t' | '\n' | '\r' => {
                let _ = write!(text, "&#{};", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text
}
