//! The robot and its world as a certificate states them: what is checked once for all edges.

use super::interval::Interval;
use super::lines::{
    BodyLine, CellLine, FORMAT, JointLine, Meets, MotionLine, PieceLine, PoseLine, ShapeLine,
};
use std::collections::{BTreeMap, BTreeSet};

/// How far RᵀR may be from the identity, entry by entry, and the squared length of an axis from 1. No unit.
const RIGID: f64 = 1e-6;

/// A rotation by rows and a translation, taken as they are.
pub(super) struct Placement {
    pub(super) rows: [[Interval; 3]; 3],
    pub(super) t: [Interval; 3],
    /// At least what the inverse of its rotation stretches a vector by.
    stretch: Interval,
}

pub(super) struct Joint {
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) origin: Placement,
    pub(super) motion: MotionLine,
}

/// A convex piece: the hull of points or of two discs normal to z, with a sphere swept round it.
pub(super) struct Piece {
    pub(super) core: Core,
    pub(super) radius: Interval,
    /// In the body; the body's own frame where there is none.
    pub(super) pose: Option<Placement>,
}

pub(super) enum Core {
    Points(Vec<[f64; 3]>),
    /// Heights and radii.
    Discs([[f64; 2]; 2]),
    /// Three of the points of the surface.
    Triangle([usize; 3]),
}

pub(super) struct Body {
    pub(super) name: String,
    pub(super) link: Option<usize>,
    meets: Meets,
    pub(super) pose: Placement,
    pub(super) pieces: Vec<Piece>,
    /// Of a surface.
    pub(super) points: Vec<[f64; 3]>,
}

pub(super) struct Cell {
    pub(super) links: BTreeMap<String, usize>,
    pub(super) base: Placement,
    pub(super) joints: Vec<Joint>,
    /// For each link the joint that moves it; none of the root.
    pub(super) above: Vec<Option<usize>>,
    /// For each link at least what the inverse of its rotation in the world stretches a vector by.
    pub(super) stretch: Vec<Interval>,
    pub(super) values: usize,
    pub(super) bodies: Vec<Body>,
    /// Pairs of bodies that must be proved apart, the lesser number first.
    pub(super) required: BTreeSet<[usize; 2]>,
}

fn finite(numbers: &[f64], of: &str) -> Result<(), String> {
    match numbers.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(format!("{of}: a number is {x}")),
        None => Ok(()),
    }
}

impl Placement {
    fn new(line: &PoseLine, of: &str) -> Result<Self, String> {
        finite(line.rows.as_flattened(), of)?;
        finite(&line.t, of)?;
        let rows = line.rows.map(|row| row.map(Interval::point));
        let mut off = 0.0f64;
        for i in 0..3 {
            for j in 0..3 {
                let dot = (0..3).fold(Interval::ZERO, |sum, k| sum.add(rows[k][i].mul(rows[k][j])));
                let unit = Interval::point(if i == j { 1.0 } else { 0.0 });
                off = off.max(dot.sub(unit).magnitude());
            }
        }
        // Else it may be a reflection too.
        let [a, b, c] = line.rows;
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        let determinant = a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1);
        if !(off <= RIGID && determinant > 0.5) {
            return Err(format!("{of}: R is no rotation"));
        }
        // The eigenvalues of RᵀR are at most the sum of a row's departures from 1.
        let least = Interval::ONE.sub(Interval::point(3.0).mul(Interval::point(off)));
        let stretch = Interval::ONE.div(least.sqrt());
        Ok(Self { rows, t: line.t.map(Interval::point), stretch })
    }
}

impl Joint {
    fn new(
        line: &JointLine,
        links: &BTreeMap<String, usize>,
        values: usize,
    ) -> Result<Self, String> {
        let of = format!("joint {:?}", line.name);
        let link = |name: &String| {
            links.get(name).copied().ok_or_else(|| format!("{of}: there is no link {name:?}"))
        };
        let last = match line.motion {
            MotionLine::Fixed => 0,
            MotionLine::Turns { axis, value, factor, offset }
            | MotionLine::Slides { axis, value, factor, offset } => {
                finite(&[axis[0], axis[1], axis[2], factor, offset], &of)?;
                let square: f64 = axis.iter().map(|x| x * x).sum();
                if !((square - 1.0).abs() <= RIGID) {
                    return Err(format!("{of}: the axis is not of length 1"));
                }
                value.saturating_add(1)
            }
            MotionLine::Orients { first } => first.saturating_add(4),
        };
        if last > values {
            return Err(format!("{of}: a state has only {values} values"));
        }
        let origin = Placement::new(&line.origin, &of)?;
        Ok(Self {
            parent: link(&line.parent)?,
            child: link(&line.child)?,
            origin,
            motion: line.motion,
        })
    }

    /// At least what the inverses of its rotations stretch a vector by.
    fn stretch(&self) -> Interval {
        let MotionLine::Turns { axis, .. } = self.motion else { return self.origin.stretch };
        // The turn I + K sin θ + K² (1 − cos θ) about an axis of squared length 1 + δ has singular values 1 and, squared,
        // 1 + |a|²(1 − cos θ)²·δ: 4|a|²·|δ| from 1 at most.
        let square =
            axis.iter().fold(Interval::ZERO, |sum, &x| sum.add(Interval::point(x).square()));
        let off = square.sub(Interval::ONE).magnitude();
        let least = Interval::ONE.sub(Interval::point(5.0).mul(Interval::point(off)));
        self.origin.stretch.div(least.sqrt())
    }
}

impl Piece {
    fn new(line: PieceLine, of: &str) -> Result<Self, String> {
        let radius = radius(line.radius, of)?;
        let core = match (line.points, line.discs) {
            (Some(points), None) => {
                finite(points.as_flattened(), of)?;
                if points.is_empty() {
                    return Err(format!("{of}: a piece without points"));
                }
                Core::Points(points)
            }
            (None, Some(discs)) => {
                finite(discs.as_flattened(), of)?;
                if !(discs[0][1] >= 0.0 && discs[1][1] >= 0.0) {
                    return Err(format!("{of}: a disc of negative radius"));
                }
                Core::Discs(discs)
            }
            _ => return Err(format!("{of}: a piece is either points or discs")),
        };
        let pose = line.pose.map(|pose| Placement::new(&pose, of)).transpose()?;
        Ok(Self { core, radius, pose })
    }
}

fn radius(radius: f64, of: &str) -> Result<Interval, String> {
    if radius >= 0.0 && radius.is_finite() {
        Ok(Interval::point(radius))
    } else {
        Err(format!("{of}: a radius of {radius}"))
    }
}

impl Body {
    fn new(line: BodyLine, links: &BTreeMap<String, usize>) -> Result<Self, String> {
        let of = format!("body {:?}", line.name);
        let link = line.link.map(|name| {
            links.get(&name).copied().ok_or_else(|| format!("{of}: there is no link {name:?}"))
        });
        let pose = Placement::new(&line.pose, &of)?;
        let (pieces, points) = match line.shape {
            ShapeLine { pieces: Some(pieces), points: None, triangles: None, radius: None } => {
                let pieces = pieces.into_iter().map(|piece| Piece::new(piece, &of));
                (pieces.collect::<Result<Vec<_>, _>>()?, Vec::new())
            }
            ShapeLine {
                pieces: None,
                points: Some(points),
                triangles: Some(triangles),
                radius: r,
            } => {
                finite(points.as_flattened(), &of)?;
                let radius = radius(r.unwrap_or_default(), &of)?;
                if triangles.as_flattened().iter().any(|&k| k >= points.len()) {
                    return Err(format!("{of}: a triangle of a point that is not there"));
                }
                let piece = |corners| Piece { core: Core::Triangle(corners), radius, pose: None };
                (triangles.into_iter().map(piece).collect(), points)
            }
            _ => return Err(format!("{of}: a shape is either pieces, or points and triangles")),
        };
        if pieces.is_empty() {
            return Err(format!("{of}: a shape of nothing"));
        }
        Ok(Self {
            name: line.name,
            link: link.transpose()?,
            meets: line.meets,
            pose,
            pieces,
            points,
        })
    }

    fn meets(&self, other: &Self) -> bool {
        match self.meets {
            Meets::All => true,
            Meets::Robot => other.link.is_some(),
            Meets::Obstacles => other.link.is_none(),
        }
    }
}

impl Cell {
    pub(super) fn new(line: CellLine) -> Result<Self, String> {
        if line.certificate != FORMAT {
            return Err(format!("a certificate of format {:?}, not {FORMAT:?}", line.certificate));
        }
        let links: BTreeMap<String, usize> = line.links.iter().cloned().zip(0..).collect();
        if links.len() != line.links.len() {
            return Err("two links of one name".to_owned());
        }
        let values = line.values.len();
        let joints = line.joints.iter().map(|joint| Joint::new(joint, &links, values));
        let joints: Vec<Joint> = joints.collect::<Result<_, _>>()?;
        let base = Placement::new(&line.base, "the base")?;
        let bodies = line.bodies.into_iter().map(|body| Body::new(body, &links));
        let bodies: Vec<Body> = bodies.collect::<Result<_, _>>()?;
        let mut above = vec![None; links.len()];
        for (index, joint) in joints.iter().enumerate() {
            if above[joint.child].replace(index).is_some() {
                return Err(format!("link {:?} has two parents", line.links[joint.child]));
            }
        }
        if above.iter().filter(|joint| joint.is_none()).count() > 1 {
            return Err("more than one link has no parent".to_owned());
        }
        let mut cell = Self {
            links,
            base,
            joints,
            above,
            stretch: Vec::new(),
            values,
            bodies,
            required: BTreeSet::new(),
        };
        cell.stretch = cell.stretches()?;
        cell.required = cell.pairs(&line.allowed)?;
        Ok(cell)
    }

    /// The joints from a link up to another, that one's excluded, or to the root: the link's own first. None where that
    /// other link is not on the way.
    pub(super) fn chain(&self, link: usize, up_to: Option<usize>) -> Option<Vec<usize>> {
        let (mut joints, mut at) = (Vec::new(), link);
        loop {
            if Some(at) == up_to {
                return Some(joints);
            }
            match self.above[at] {
                // More joints than there are: a ring.
                Some(_) if joints.len() >= self.joints.len() => return None,
                Some(joint) => {
                    joints.push(joint);
                    at = self.joints[joint].parent;
                }
                None => return up_to.is_none().then_some(joints),
            }
        }
    }

    fn stretches(&self) -> Result<Vec<Interval>, String> {
        let of = |link: usize| {
            let chain = self.chain(link, None).ok_or("the links make no tree")?;
            let all =
                chain.iter().fold(self.base.stretch, |all, &j| all.mul(self.joints[j].stretch()));
            Ok(all)
        };
        (0..self.above.len()).map(of).collect()
    }

    /// All pairs but those of what stands still, of one link, of what need not meet, and of names that may touch.
    fn pairs(&self, allowed: &[[String; 2]]) -> Result<BTreeSet<[usize; 2]>, String> {
        let mut may_touch = BTreeSet::new();
        let names: BTreeSet<&str> = self.bodies.iter().map(|body| body.name.as_str()).collect();
        for [a, b] in allowed {
            if let Some(name) = [a, b].into_iter().find(|name| !names.contains(name.as_str())) {
                return Err(format!("a pair that may touch: there is no body {name:?}"));
            }
            may_touch.insert([a.min(b), a.max(b)]);
        }
        // A body that does not meet obstacles has one of its link that does.
        for body in self.bodies.iter().filter(|body| body.meets != Meets::All) {
            let other = |other: &&Body| other.link == body.link && other.name == body.name;
            let both = [Meets::Robot, Meets::Obstacles];
            let has = both.map(|meets| self.bodies.iter().filter(other).any(|b| b.meets == meets));
            if body.link.is_none() || has != [true; 2] {
                return Err(format!("body {:?} meets only some and has no other half", body.name));
            }
        }
        let mut pairs = BTreeSet::new();
        for (i, a) in self.bodies.iter().enumerate() {
            for (j, b) in self.bodies.iter().enumerate().skip(i + 1) {
                let names = [(&a.name).min(&b.name), (&a.name).max(&b.name)];
                if a.link != b.link && a.meets(b) && b.meets(a) && !may_touch.contains(&names) {
                    pairs.insert([i, j]);
                }
            }
        }
        Ok(pairs)
    }
}
