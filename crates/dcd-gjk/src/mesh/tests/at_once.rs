//! What a cuboid's farthest corner tells of a leaf's triangles.

use super::*;
use crate::mesh::body::{Body, Proved};
use crate::mesh::relative_pose::RelativePose;
use crate::mesh::side::Side;
use dcd_geom::Triangles;
use dcd_simd::{Kernel, Lanes, dispatch_on};

/// How many triangles fill a leaf.
const LEAF: usize = 16;

struct AtOnce<'a> {
    body: &'a Body,
    leaf: &'a Triangles,
}

impl Kernel for AtOnce<'_> {
    type Output = Proved;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Proved {
        self.body.decide_at_once(l, (self.leaf, (1 << LEAF) - 1))
    }
}

#[test]
fn a_cuboids_farthest_corner_tells_nothing_but_the_truth() {
    let seed = std::env::var("DCD_SEED").map_or(611, |seed| seed.parse().expect("a seed"));
    let mut draw = Draw(seed);
    let (mut touching, mut found, mut apart, mut first, mut met) = (0, 0, 0, 0, 0);
    for round in 0..900usize {
        let scale = [1.0, 1e-3, 1e3][round % 3];
        let ground = draw.mesh(LEAF, scale);
        let ground = if round % 5 == 4 { ground.swept(0.02 * scale).unwrap() } else { ground };
        let half = (draw.point(0.4).abs() + 0.02) * scale;
        let half = if round % 7 == 6 { DVec3::new(half.x, half.y, 0.0) } else { half };
        let cuboid = Shape::cuboid(half).unwrap();
        let body = if round % 11 == 10 { cuboid.swept(0.1 * scale).unwrap() } else { cuboid };
        let gap = [0.0, 1e-7, -1e-7, 2e-6, -2e-6, 1e-4, -1e-4, -0.02, -0.05][round / 3 % 9] * scale;
        let Shape::Mesh(mesh) = &ground else { panic!("no mesh") };
        let pose = over_a_triangle(&mut draw, mesh, &body, gap);
        let a = PosedShape { shape: &ground, pose: &Pose::IDENTITY };
        let b = PosedShape { shape: &body, pose: &pose };
        let due = brute_force(a, b);
        let is_due = |lane: usize| due.contains(&[mesh.tree().below()[0].0[lane], 0]);
        let sides = [Side::of(a), Side::of(b)];
        let sides = [&sides[0], &sides[1]];
        let relative = RelativePose::of(sides[0], sides[1]).unwrap();
        let body = &Body::of(&relative, sides, &mut Vec::new()).unwrap();
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            let proved = dispatch_on(path, AtOnce { body, leaf: &mesh.leaves()[0] });
            for lane in 0..LEAF {
                let what = format!("seed {seed}, round {round}, lane {lane}, {path:?}");
                let is_proved = |set: u32| set >> lane & 1 != 0;
                assert!(is_due(lane) || !is_proved(proved.touching), "{what}");
                assert!(!is_due(lane) || !is_proved(proved.apart), "{what}");
                touching += usize::from(is_due(lane));
                found += usize::from(is_proved(proved.touching));
                apart += usize::from(is_proved(proved.apart));
            }
            met += usize::from(!due.is_empty());
            first += usize::from(proved.touching != 0);
        }
    }
    assert!(
        8 * found > touching && 6 * first > met && apart > 2 * touching,
        "{found} of {touching}, {first} of {met}, {apart}"
    );
}
