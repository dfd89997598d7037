//! Yes or no, by every method that sees one pair at a time.

use crate::Input;
use dcd_geom::{Polytope, Pose};
use dcd_gjk::certified::{self, overlap_exactly};
use dcd_gjk::{Difference, PosedSupport, Verdict, gjk};

/// Two placed polytopes.
pub(crate) type Pair = [(Polytope, Pose); 2];

pub(crate) fn pair(input: &mut Input<'_>) -> Option<Pair> {
    let (a, pose_a) = (input.polytope()?, input.pose()?);
    let (b, pose_b) = (input.polytope()?, input.pose()?);
    // Of the odd ones, turned alike: what is stacked in a frame of its own.
    let turn = if input.byte().unwrap_or(0) % 2 == 1 { pose_a } else { pose_b };
    let pose_b = Pose::from_matrix(*turn.rotation(), pose_b.translation()).ok()?;
    Some([(a, pose_a), (b, pose_b)])
}

pub(crate) fn body((shape, pose): &(Polytope, Pose)) -> PosedSupport<'_, Polytope> {
    PosedSupport::polytope(shape, pose)
}

/// The certified solver is never undecided and agrees with its last method, in either order; f32 and
/// f64 alone never contradict it.
pub fn overlap(bytes: &[u8]) {
    let Some(pair) = pair(&mut Input(bytes)) else { return };
    let [a, b] = pair.each_ref().map(body);
    let touches = overlap_exactly(a, b);
    let truth = if touches { Verdict::Touching(()) } else { Verdict::Apart };
    assert_eq!(overlap_exactly(b, a), touches, "the last method, seen from b");
    let (verdict, method) = certified::overlap(a, b);
    assert_eq!(verdict, truth, "the certified solver, at {method:?}");
    assert_eq!(certified::overlap(b, a), (verdict, method), "the certified solver, seen from b");
    let in_f64 = Difference::<f64, _, _>::new(a, b).map(|difference| gjk::overlap(&difference));
    let in_f32 = Difference::<f32, _, _>::new(a, b).map(|difference| gjk::overlap(&difference));
    for verdict in [in_f64, in_f32].into_iter().flatten() {
        assert!(verdict == truth || matches!(verdict, Verdict::Undecided(_)), "{verdict:?}");
    }
}
