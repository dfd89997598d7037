//! Supports of two polytopes in one kernel (docs/numerics/queries.md, "supports by lanes").

use crate::{Difference, Vertex};
use dcd_geom::glam::DVec3;
use dcd_geom::{Curved, Polytope, Shape, Support, SupportMap};
use dcd_simd::{Kernel, Lanes, dispatch};

pub(crate) type Polytopes<'b> = Difference<'b, f64, Polytope, Polytope>;

/// A support map that may have its vertices in blocks.
pub(crate) trait InBlocks: SupportMap<f64> {
    /// The polytope that it is.
    fn polytope(&self) -> Option<&Polytope>;

    /// The cylinder or cone that it is.
    #[inline(always)]
    fn curved(&self) -> Option<&Curved> {
        None
    }
}

impl InBlocks for Polytope {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        Some(self)
    }
}

impl InBlocks for Shape {
    #[inline(always)]
    fn polytope(&self) -> Option<&Polytope> {
        match self {
            Self::Polytope(polytope) => Some(polytope),
            _ => None,
        }
    }

    #[inline(always)]
    fn curved(&self) -> Option<&Curved> {
        match self {
            Self::Curved(curved) => Some(curved),
            _ => None,
        }
    }
}

/// [`Difference::lowest`], by lanes where that is quicker.
pub(crate) fn lowest<A: InBlocks, B: InBlocks>(
    difference: &Difference<'_, f64, A, B>,
    direction: DVec3,
) -> (Vertex<f64>, f64) {
    let (a, b) = difference.maps();
    if has_blocks(a) || has_blocks(b) {
        dispatch(LowestVertex { difference, direction, near: None })
    } else {
        difference.lowest(direction)
    }
}

fn has_blocks(map: &impl InBlocks) -> bool {
    map.polytope().is_some_and(|polytope| !polytope.vertex_blocks().is_empty())
}

/// One support, compiled once a path for all searches that take it.
struct LowestVertex<'a, 'b, A, B> {
    difference: &'a Difference<'b, f64, A, B>,
    direction: DVec3,
    /// Vertices that may be near the farthest of either.
    near: Option<[u32; 2]>,
}

impl<A: InBlocks, B: InBlocks> Kernel for LowestVertex<'_, '_, A, B> {
    type Output = (Vertex<f64>, f64);

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let Self { difference, direction, near } = self;
        let (a, b) = difference.maps();
        let [in_a, in_b] = difference.to_local(direction);
        let [near_a, near_b] = near.map_or([None; 2], |near| near.map(Some));
        let (a, b) = (farthest(l, a, -in_a, near_a), farthest(l, b, in_b, near_b));
        let vertex = Vertex { w: difference.world(a.point, b.point), a, b };
        (vertex, difference.separation(direction, &vertex))
    }
}

/// Supports of one difference.
pub(crate) struct Exact<'a, 'b, L, A, B> {
    pub(crate) lanes: L,
    pub(crate) difference: &'a Difference<'b, f64, A, B>,
    /// Vertices of A and of B, by their numbers in the blocks: where they are near the farthest, half the work is saved.
    pub(crate) near: Option<[u32; 2]>,
}

impl<L: Lanes, A: InBlocks, B: InBlocks> Exact<'_, '_, L, A, B> {
    /// [`Difference::lowest`], bit for bit. The direction's largest component is 1.
    #[inline(always)]
    pub(crate) fn lowest(&self, direction: DVec3) -> (Vertex<f64>, f64) {
        let &Self { lanes, difference, near } = self;
        lanes.call(LowestVertex { difference, direction, near })
    }
}

/// The farthest vertex, the first among equals. `near` is any vertex, by its number in the blocks.
#[inline(always)]
fn farthest<L: Lanes>(
    l: L,
    map: &impl InBlocks,
    direction: DVec3,
    near: Option<u32>,
) -> Support<f64> {
    match map.polytope() {
        Some(polytope) => polytope.support_in_lanes(l, direction, near),
        None => map.support(direction),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PosedSupport;
    use crate::gjk::unit;
    use crate::motion::tests::Draw;
    use dcd_geom::Pose;
    use dcd_geom::glam::DQuat;
    use dcd_simd::{Path, WIDTH, dispatch_on};

    /// The vertices of a polytope, compared one after the other.
    struct Vertices<'a>(&'a Polytope);

    impl Vertices<'_> {
        fn posed<'a>(&'a self, of: PosedSupport<'a, Polytope>) -> PosedSupport<'a, Self> {
            let PosedSupport { map: _, pose, reach, centre, inner } = of;
            PosedSupport { map: self, pose, reach, centre, inner }
        }
    }

    impl SupportMap<f64> for Vertices<'_> {
        fn support(&self, direction: DVec3) -> Support<f64> {
            let vertices = self.0.vertices();
            let along = |k: &usize| vertices[*k].dot(direction);
            let first = |best, k| if along(&k) > along(&best) { k } else { best };
            let k = (0..vertices.len()).fold(0, first);
            Support { point: vertices[k], feature: k as u32 }
        }
    }

    fn polytope(draw: &mut Draw, k: usize) -> Polytope {
        // Every other one with ties, a third far from its own origin, some without blocks.
        let from = [DVec3::ZERO, DVec3::ZERO, DVec3::splat(1e7)][k % 3];
        let scale = [1.0, 1e-4, 1e4][k / 2 % 3];
        let points = (0..4 + k % 90).map(|_| {
            let point = draw.vector();
            scale * (from + if k.is_multiple_of(2) { (point * 3.0).round() } else { point })
        });
        Polytope::hull(points.collect()).unwrap()
    }

    #[test]
    fn lanes_find_the_vertex_that_all_in_f64_would_and_the_same_one_on_every_path() {
        let seed = std::env::var("DCD_SEED").map_or(5, |seed| seed.parse().expect("a seed"));
        let mut draw = Draw(seed);
        for k in 0..1500 {
            let (a, b) = (polytope(&mut draw, k), polytope(&mut draw, k / 7));
            let turn = DQuat::from_scaled_axis(draw.vector() * f64::from(k as u32 % 4));
            let (pose_a, pose_b) = (
                Pose::new(turn.normalize(), draw.vector()).unwrap(),
                Pose::from_translation(draw.vector()).unwrap(),
            );
            let posed = (PosedSupport::polytope(&a, &pose_a), PosedSupport::polytope(&b, &pose_b));
            let difference = Difference::new(posed.0, posed.1).unwrap();
            let maps = [Vertices(&a), Vertices(&b)];
            let (in_a, in_b) = (maps[0].posed(posed.0), maps[1].posed(posed.1));
            let one_by_one = Difference::new(in_a, in_b).unwrap();
            for j in 0..6 {
                let along = if j == 0 { DVec3::Y } else { draw.vector() };
                let along = if j % 2 == 0 { turn * along.round() } else { along };
                let Some(direction) = unit::<f64>(along.to_array()) else { continue };
                let expected = one_by_one.lowest(direction);
                // Any vertices may be given as near; a block's last number may be past the last vertex.
                let blocks = [a.vertex_blocks().len(), b.vertex_blocks().len()];
                let any = blocks.map(|blocks| (k * 7 + j) as u32 % (blocks * WIDTH).max(1) as u32);
                let found = [expected.0.a.feature, expected.0.b.feature];
                for path in Path::ALL {
                    for near in [None, Some(any), Some(found)] {
                        let kernel = LowestVertex { difference: &difference, direction, near };
                        assert_eq!(dispatch_on(path, kernel), expected, "{seed} {k} {path:?}");
                    }
                }
            }
        }
    }
}
