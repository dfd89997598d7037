//! Pairs from a seed.

use super::PosedShape;
use dcd_geom::glam::{DMat3, DQuat, DVec3};
use dcd_geom::{Polytope, Pose};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Draw(pub u64);

impl Draw {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// In 0..n.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// In [−1, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Multiples of ½ in [−1, 1]³.
    pub fn lattice(&mut self) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.below(5) as f64 / 2.0 - 1.0))
    }

    pub fn rotation(&mut self) -> DQuat {
        loop {
            let q = DQuat::from_xyzw(self.unit(), self.unit(), self.unit(), self.unit());
            if (0.1..1.0).contains(&q.length_squared()) {
                return q.normalize();
            }
        }
    }

    /// One of the rotations that carry the lattice to itself.
    fn quarter_turns(&mut self) -> DMat3 {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let first = self.below(3) as usize;
        let second = (first + 1 + self.below(2) as usize) % 3;
        let sign = |bit: u64| if bit == 0 { 1.0 } else { -1.0 };
        let x = axes[first] * sign(self.below(2));
        let y = axes[second] * sign(self.below(2));
        DMat3::from_cols(x, y, x.cross(y))
    }
}

/// Hulls of lattice points in lattice places: faces, edges and corners that touch exactly, flat
/// and collinear hulls, points, duplicates.
pub fn lattice(draw: &mut Draw, most: u64) -> [PosedShape; 2] {
    [(); 2].map(|()| {
        let count = 1 + draw.below(most);
        let vertices = (0..count).map(|_| draw.lattice()).collect();
        let pose = Pose::from_matrix(draw.quarter_turns(), draw.lattice()).unwrap();
        PosedShape::hull(vertices, pose)
    })
}

/// Hulls of any points, stretched by up to 2⁻²⁰ along axes of their own, turned any way.
pub fn random(draw: &mut Draw, most: u64) -> [PosedShape; 2] {
    [(); 2].map(|()| {
        let count = 1 + draw.below(most);
        let thin = 2f64.powi(-(draw.below(21) as i32));
        let stretch = match draw.below(4) {
            0 => DVec3::new(1.0, 1.0, thin),
            1 => DVec3::new(1.0, thin, thin),
            2 => DVec3::new(1.0, thin, 0.0),
            _ => DVec3::ONE,
        };
        let vertices = (0..count).map(|_| draw.vector() * stretch).collect();
        PosedShape::hull(vertices, Pose::new(draw.rotation(), draw.vector() * 0.5).unwrap())
    })
}

/// A box and a box, aligned but for a rotation that both share.
pub fn aligned(draw: &mut Draw) -> [PosedShape; 2] {
    let rotation = if draw.below(2) == 0 { DQuat::IDENTITY } else { draw.rotation() };
    [(); 2].map(|()| {
        let half = (draw.lattice().abs() + 0.5) * 0.25;
        let shape = Polytope::cuboid(half).unwrap();
        PosedShape { shape, pose: Pose::new(rotation, rotation * draw.lattice()).unwrap() }
    })
}

/// B moved along a line until the exact answer flips between neighbouring floats: the pair that
/// touches, and the pair that does not. `None` where the line never leaves A.
pub fn bisected(
    [a, b]: &[PosedShape; 2],
    direction: DVec3,
    touches: impl Fn(&PosedShape, &PosedShape) -> bool,
) -> Option<[[PosedShape; 2]; 2]> {
    let from = a.pose.translation();
    let at = |x: f64| [a.clone(), b.moved_to(from + direction * x)];
    let touching = |x: f64| {
        let [a, b] = at(x);
        touches(&a, &b)
    };
    let (mut inside, mut outside) = (0.0f64, 1024.0f64);
    if !touching(inside) || touching(outside) {
        return None;
    }
    loop {
        let middle = inside + (outside - inside) / 2.0;
        if middle <= inside || middle >= outside {
            return Some([at(inside), at(outside)]);
        }
        if touching(middle) { inside = middle } else { outside = middle }
    }
}
