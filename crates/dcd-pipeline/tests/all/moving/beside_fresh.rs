//! Pipelines that have seen a whole course, each beside one that has seen nothing.

use super::course::{Course, Source};
use dcd_broad::{SweepAndPrune, TreePairs};
use dcd_bvh::PaperTree;
use dcd_geom::{Pair, Scene};
use dcd_gjk::{Coherent, Contact, Depths, Method, NarrowPhase, Overlap, ThenMeasure, Within};
use dcd_pipeline::{BroadPhase, Par, Pipeline, Step, WideTree};
use std::fmt::Debug;

/// What a narrow phase that remembers may say beyond a fresh one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Knows {
    /// Nothing.
    AsMuch,
    /// Pairs of curved shapes that no fresh step decides: it may have seen them farther apart.
    More,
}

/// What came of a course.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) steps: usize,
    /// How many contacts there were, and how many candidates of a static object.
    pub(crate) contacts: usize,
    pub(crate) between: usize,
    /// How many answers came from earlier steps.
    pub(crate) remembered: u64,
}

/// The pipelines that remember. All but the first two miss some steps, so that what they remember is
/// of other moments.
struct Kept {
    overlap: Pipeline<WideTree, Overlap>,
    coherent: Pipeline<WideTree, Coherent>,
    within: Pipeline<WideTree, Within>,
    within_coherent: Pipeline<WideTree, Within<Coherent>>,
    depths: Pipeline<WideTree, ThenMeasure<Depths, Coherent>>,
    swept: Pipeline<SweepAndPrune, Coherent>,
    walked: Pipeline<TreePairs<PaperTree>, Overlap>,
}

/// Metres: as much as objects walk in some steps.
const MARGIN: f64 = 0.05;

impl Kept {
    fn new() -> Option<Self> {
        Some(Self {
            overlap: Pipeline::default(),
            coherent: Pipeline::with(WideTree::default(), Coherent::default()),
            within: Pipeline::with(WideTree::default(), Within::margin(MARGIN).ok()?),
            within_coherent: Pipeline::with(WideTree::default(), within_coherent()?),
            depths: Pipeline::with(WideTree::default(), depths()?),
            swept: Pipeline::with(SweepAndPrune::default(), Coherent::default()),
            walked: Pipeline::with(TreePairs::default(), Overlap::default()),
        })
    }

    /// One step of those that `which` has a bit of.
    fn step(&mut self, scene: &Scene, which: u8, seen: &mut Seen) -> Option<()> {
        use Knows::{AsMuch, More};
        let overlap = same(&mut self.overlap, Overlap::default(), scene, AsMuch);
        seen.contacts += overlap.contacts;
        seen.between += overlap.between;
        seen.remembered += same(&mut self.coherent, Overlap::default(), scene, More).remembered;
        if which & 3 == 0 {
            same(&mut self.within, Within::margin(MARGIN).ok()?, scene, AsMuch);
        }
        if which & 12 == 0 {
            same(&mut self.within_coherent, Within::margin(MARGIN).ok()?, scene, More);
        }
        if which & 0x70 == 0 {
            same(&mut self.depths, ThenMeasure::new(Depths).ok()?, scene, More);
        }
        if which & 0xc0 == 0 {
            same(&mut self.swept, Overlap::default(), scene, More);
        }
        if which & 0x81 == 0 {
            same(&mut self.walked, Overlap::default(), scene, AsMuch);
        }
        Some(())
    }
}

fn within_coherent() -> Option<Within<Coherent>> {
    Within::by(Coherent::default(), MARGIN).ok()
}

fn depths() -> Option<ThenMeasure<Depths, Coherent>> {
    ThenMeasure::after(Coherent::default(), Depths).ok()
}

/// Runs a course to its end, or for so many steps.
///
/// # Panics
/// A pipeline that has seen earlier steps reports anything else than one that has not: other AABBs,
/// other candidates, other contacts, or the same in another order.
pub(crate) fn run(source: &mut impl Source, steps: usize) -> Seen {
    let mut seen = Seen::default();
    let (Some(mut course), Some(mut kept)) = (Course::new(source), Kept::new()) else {
        return seen;
    };
    for _ in 0..steps {
        let Some(which) = course.byte() else { break };
        if kept.step(course.scene(), which, &mut seen).is_none() {
            break;
        }
        seen.steps += 1;
        if course.advance().is_none() {
            break;
        }
    }
    seen
}

/// A step of a pipeline that has seen others beside the first step of a new one, in which another
/// narrow phase may stand that remembers nothing.
fn same<B, N, M>(kept: &mut Pipeline<B, N>, fresh: M, scene: &Scene, knows: Knows) -> Seen
where
    B: BroadPhase + Default,
    N: NarrowPhase,
    M: NarrowPhase<Answer = N::Answer>,
    N::Answer: PartialEq + Debug,
{
    let name = std::any::type_name::<N>();
    let mut fresh = Pipeline::with(B::default(), fresh);
    let (reported, due) = (kept.step(scene, Par::Serial), fresh.step(scene, Par::Serial));
    let bits = |step: &Step<'_, N::Answer>| -> Vec<[u32; 6]> {
        let corners = |b: &dcd_geom::Aabb| [b.min.to_array(), b.max.to_array()].concat();
        let boxes = step.aabbs().iter().map(|b| corners(b).iter().map(|x| x.to_bits()).collect());
        boxes.map(|bits: Vec<u32>| std::array::from_fn(|k| bits[k])).collect()
    };
    assert_eq!(bits(&reported), bits(&due), "{name}: boxes");
    let candidates: Vec<Pair> = due.candidates().collect();
    assert_eq!(
        reported.candidates().collect::<Vec<_>>(),
        candidates,
        "{name}: candidates, in order"
    );
    let undecided = |step: &Step<'_, N::Answer>| -> Vec<Pair> {
        step.report().undecided().iter().map(|left| left.pair).collect()
    };
    let (left, open) = (undecided(&reported), undecided(&due));
    match knows {
        Knows::AsMuch => assert_eq!(left, open, "{name}: undecided"),
        Knows::More => assert!(left.iter().all(|pair| open.contains(pair)), "{name}: undecided"),
    }
    let decided = |contact: &Contact<N::Answer>| !open.contains(&contact.pair);
    let contacts: Vec<_> = reported.answers().filter(decided).collect();
    assert_eq!(contacts, due.answers().collect::<Vec<_>>(), "{name}: contacts, in order");
    let fixed = |i: u32| scene.motion(i as usize) == Some(dcd_geom::Motion::Static);
    Seen {
        steps: 1,
        contacts: contacts.len(),
        between: candidates.iter().filter(|pair| fixed(pair.i) || fixed(pair.j)).count(),
        remembered: reported.report().resolved(Method::Remembered),
    }
}
