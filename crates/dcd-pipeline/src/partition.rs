//! Moving and static objects, kept until an object is added or removed.

use dcd_broad::{BroadPhase, IdentifiedAabbs, StaticTree};
use dcd_exec::{Exec, Segments};
use dcd_geom::{Aabb, Motion, Pair, Revision, Scene};

/// The lists of moving and of static objects, and a tree over the static ones.
///
/// A scene of moving objects alone needs none of it: its AABBs go to the broad phase as they are.
#[derive(Debug, Default)]
pub(crate) struct Partition {
    layout: Option<Revision>,
    statics: Option<Revision>,
    /// The slots of the moving objects, ascending.
    movers: Vec<u32>,
    /// Their AABBs.
    boxes: Vec<Aabb>,
    world: StaticTree,
    /// The static objects' slots and AABBs that the tree is over.
    static_aabbs: (Vec<u32>, Vec<Aabb>),
}

/// Which AABBs this step has written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Boxed {
    /// Everyone's.
    All,
    /// The moving objects', and perhaps others' as before.
    Moving,
}

/// Whether every slot holds a moving object.
fn all_move(scene: &Scene) -> bool {
    scene.static_count() == 0 && scene.object_count() == scene.len()
}

impl Partition {
    /// Lets the next [`Partition::build`] begin anew.
    pub(crate) fn forget(&mut self) {
        (self.layout, self.statics) = (None, None);
    }

    /// Whether the static objects and their places in the frame are those of the last
    /// [`Partition::build`], so that what was prepared of them holds.
    pub(crate) fn still_holds(&self, scene: &Scene) -> bool {
        self.layout == Some(scene.layout()) && self.statics == Some(scene.statics())
    }

    /// Builds the broad phase over the moving objects, and the tree over the static ones if any of
    /// their AABBs has changed: an AABB may be another although nobody has moved, since what is prepared
    /// of an object may depend on which shapes the scene has. So the tree is that of the AABBs, whatever
    /// was there before.
    pub(crate) fn build(
        &mut self,
        scene: &Scene,
        (aabbs, boxed): (&[Aabb], Boxed),
        broad: &mut impl BroadPhase,
        exec: Exec,
    ) {
        if self.layout != Some(scene.layout()) {
            list(scene, Motion::Moving, &mut self.movers);
        }
        if boxed == Boxed::All && self.take_statics(scene, aabbs) {
            let (names, boxes) = &self.static_aabbs;
            self.world.build(IdentifiedAabbs { aabbs: boxes, names }, exec);
        }
        (self.layout, self.statics) = (Some(scene.layout()), Some(scene.statics()));
        if all_move(scene) {
            broad.build(aabbs, exec);
        } else {
            self.boxes.clear();
            self.boxes.extend(self.movers.iter().map(|&slot| aabbs[slot as usize]));
            broad.build(&self.boxes, exec);
        }
    }

    /// The slots of the moving objects as the broad phase numbers them; `None` where each has its own number.
    pub(crate) fn mover_slots(&self, scene: &Scene) -> Option<&[u32]> {
        (!all_move(scene)).then_some(&self.movers)
    }

    /// The tree over the static objects, and their slots as it numbers them.
    pub(crate) fn statics(&self) -> (&StaticTree, &[u32]) {
        (&self.world, &self.static_aabbs.0)
    }

    /// Lists the static objects and their AABBs; whether any of it has changed, bit for bit.
    fn take_statics(&mut self, scene: &Scene, aabbs: &[Aabb]) -> bool {
        let (names, boxes) = &mut self.static_aabbs;
        let (known, mut changed) = (names.len(), self.statics != Some(scene.statics()));
        if changed {
            list(scene, Motion::Static, names);
        }
        changed |= names.len() != known;
        boxes.resize(names.len(), Aabb::EMPTY);
        for (old, &slot) in boxes.iter_mut().zip(&*names) {
            let new = aabbs[slot as usize];
            changed |= bits(old) != bits(&new);
            *old = new;
        }
        changed
    }

    /// Lists the candidates among the moving objects, then those of a moving and a static object: the pairs that
    /// the scene's filters and the caller allow.
    pub(crate) fn find(
        &self,
        aabbs: &[Aabb],
        broad: &mut impl BroadPhase,
        search: CandidateSearch<impl Fn(u32, u32) -> bool + Sync>,
    ) {
        let CandidateSearch { scene, may, exec, among, between } = search;
        // Two searches, so that a scene without filters calls none.
        if scene.filters_movers() {
            let keep = |i, j| scene.allows(i, j) && may(i, j);
            self.find_where(
                aabbs,
                broad,
                CandidateSearch { scene, may: keep, exec, among, between },
            );
        } else {
            self.find_where(aabbs, broad, CandidateSearch { scene, may, exec, among, between });
        }
    }

    fn find_where(
        &self,
        aabbs: &[Aabb],
        broad: &mut impl BroadPhase,
        search: CandidateSearch<impl Fn(u32, u32) -> bool + Sync>,
    ) {
        let CandidateSearch { scene, may: keep, exec, among, between } = search;
        if all_move(scene) {
            broad.pairs(aabbs, keep, exec, among);
            between.clear();
            return;
        }
        let slot = |k: u32| self.movers[k as usize];
        broad.pairs(&self.boxes, |i, j| keep(slot(i), slot(j)), exec, among);
        // Slots ascend, so that the smaller stays the smaller.
        among.change_each(exec, |pair| *pair = Pair { i: slot(pair.i), j: slot(pair.j) });
        self.world.pairs(
            IdentifiedAabbs { aabbs: &self.boxes, names: &self.movers },
            keep,
            exec,
            between,
        );
    }
}

/// Bits, since `==` takes −0 for 0 and an order does not.
fn bits(aabb: &Aabb) -> [[u32; 3]; 2] {
    [aabb.min, aabb.max].map(|corner| corner.to_array().map(f32::to_bits))
}

/// The query, and where its pairs are written.
pub(crate) struct CandidateSearch<'a, K> {
    pub(crate) scene: &'a Scene,
    /// Which pairs are wanted.
    pub(crate) may: K,
    pub(crate) exec: Exec<'a>,
    /// Candidates among the moving objects.
    pub(crate) among: &'a mut Segments<Pair>,
    /// Candidates of a moving and a static object.
    pub(crate) between: &'a mut Segments<Pair>,
}

fn list(scene: &Scene, motion: Motion, slots: &mut Vec<u32>) {
    slots.clear();
    slots.extend((0..).take(scene.len()).filter(|&i| scene.motion(i as usize) == Some(motion)));
}
