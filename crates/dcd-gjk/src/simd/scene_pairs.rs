//! Pairs of which more is read than the lanes keep: the shapes and poses of the scene itself.

use super::cores::Core;
use super::frame::{BOX, FramePair, SPHERE, STRAIGHT_CORE, SimdFrame};
use crate::PosedShape;
use dcd_geom::{Pair, Scene, Shape};
use dcd_simd::{prefetch, prefetch_few};
use std::slice;

/// Pairs, and where their objects are.
#[derive(Clone, Copy)]
pub(super) struct ScenePairs<'a> {
    pub(super) frames: FramePair<'a>,
    pub(super) scenes: [&'a Scene; 2],
    pub(super) pairs: &'a [Pair],
}

/// Before how many other pairs the memory of a pair is prefetched: where its parts are, then what is there, step by step.
/// No effect on any result. Larger: what leaves the nearest caches before it is read. Smaller: arithmetic that waits.
const FARTHER: usize = 9;
/// See [`FARTHER`].
const FAR: usize = 6;
/// See [`FARTHER`].
const NEAR: usize = 3;

/// How many cache lines the blocks and the vertices of an object mostly take: hulls of thirty vertices. No effect on any result.
/// Larger: lines that are prefetched again. Smaller: loops whose end is not predicted.
const BLOCKS: usize = 6;
/// See [`BLOCKS`].
const VERTICES: usize = 12;

/// Scenes of at most this many shapes have them in the second cache: nothing of them is prefetched. No effect on any result. Larger:
/// shapes that are waited for. Smaller: hints, a twentieth of the time that depths take in a pile of 32 hulls.
const FEW_SHAPES: usize = 128;

impl<'a> ScenePairs<'a> {
    /// Whether the shapes are so few that to prefetch what is of them costs more than it hides.
    pub(super) fn have_few_shapes(&self) -> bool {
        self.scenes.iter().all(|scene| scene.shapes().len() <= FEW_SHAPES)
    }

    /// Two objects, or two parts as their compounds have placed them.
    #[inline(always)]
    pub(super) fn posed(&self, pair: Pair) -> [PosedShape<'a>; 2] {
        let ([a, b], FramePair { a: of_a, b: of_b }) = (self.scenes, self.frames);
        [posed(of_a, a, pair.i), posed(of_b, b, pair.j)]
    }

    /// The cores of the two.
    #[inline(always)]
    pub(super) fn cores(&self, pair: Pair) -> [&'a Core; 2] {
        let ([a, b], FramePair { a: of_a, b: of_b }) = (self.scenes, self.frames);
        [of_a.core_of(a, pair.i), of_b.core_of(b, pair.j)]
    }

    /// The numbers of two parts in their compounds.
    #[inline(always)]
    pub(super) fn part_numbers(&self, records: Pair) -> [u32; 2] {
        let FramePair { a, b } = self.frames;
        let number =
            |frame: &SimdFrame, record| frame.owner_of(record).map_or(0, |(_, number)| number);
        [number(a, records.i), number(b, records.j)]
    }

    /// Two parts by their records: see [`part`].
    pub(super) fn parts(&self, records: Pair) -> [(u32, PosedShape<'a>); 2] {
        let ([a, b], FramePair { a: of_a, b: of_b }) = (self.scenes, self.frames);
        [part(of_a, a, records.i), part(of_b, b, records.j)]
    }

    /// The vertices of two polytopes by their places in the blocks, the last of which is filled up with the last vertex.
    #[inline(always)]
    pub(super) fn vertices(&self, pair: Pair, [in_a, in_b]: [u32; 2]) -> Option<[u32; 2]> {
        let [a, b] = self.posed(pair);
        Some([vertex(a, in_a)?, vertex(b, in_b)?])
    }

    /// Prefetches where the shapes are of the pairs behind one of that number, and then what is there.
    #[inline(always)]
    pub(super) fn look_ahead_to_shapes(&self, number: usize) {
        let Self { frames: FramePair { a, b }, scenes: [of_a, of_b], pairs } = *self;
        if let Some(pair) = pairs.get(number + FARTHER) {
            prefetch_places(a, of_a, pair.i);
            prefetch_places(b, of_b, pair.j);
        }
        if let Some(pair) = pairs.get(number + FAR) {
            prefetch_polytope(of_a, pair.i);
            prefetch_polytope(of_b, pair.j);
        }
    }

    /// Prefetches the poses of the pair far behind one of that number, where no more is read of it than these and what a
    /// near cache holds.
    #[inline(always)]
    pub(super) fn look_ahead_to_poses(&self, number: usize) {
        let Self { frames, scenes: [of_a, of_b], pairs } = *self;
        if let Some(pair) = pairs.get(number + FAR)
            && !frames.are_near()
        {
            prefetch(slice::from_ref(&of_a.poses()[pair.i as usize]));
            prefetch(slice::from_ref(&of_b.poses()[pair.j as usize]));
        }
    }

    /// Prefetches what the pairs behind one of that number read: the faces of polytopes too, where `facets` says so.
    #[inline(always)]
    pub(super) fn look_ahead(&self, number: usize, facets: bool) {
        self.look_ahead_to_shapes(number);
        let Self { frames: FramePair { a, b }, scenes: [of_a, of_b], pairs } = *self;
        if let Some(pair) = pairs.get(number + NEAR) {
            // An object that the pair before has too is there already.
            let before = &pairs[number + NEAR - 1];
            if pair.i != before.i {
                prefetch_shown(a, of_a, pair.i, facets);
            }
            if pair.j != before.j {
                prefetch_shown(b, of_b, pair.j, facets);
            }
        }
    }

    /// The same, where no more is read of polytopes than their kind and the first vertices: spheres, capsules and cuboids.
    #[inline(always)]
    pub(super) fn look_ahead_to_ends(&self, number: usize) {
        self.look_ahead_to_shapes(number);
        let Some(pair) = self.pairs.get(number + NEAR) else { return };
        let [of_a, of_b] = self.scenes;
        prefetch_first(of_a, pair.i);
        prefetch_first(of_b, pair.j);
    }

    /// The same, of pairs that are measured one by one: a hull's planes, vertices and, where `facets` says so, faces are read
    /// beside a sphere, of others their ends.
    #[inline(always)]
    pub(super) fn look_ahead_to_measured(&self, number: usize, facets: bool) {
        self.look_ahead_to_shapes(number);
        let Self { frames: FramePair { a, b }, scenes: [of_a, of_b], pairs } = *self;
        let Some(pair) = pairs.get(number + NEAR) else { return };
        let (marks_a, marks_b) = (a.record(pair.i).marks, b.record(pair.j).marks);
        let is_other = |marks: u8| marks & (SPHERE | STRAIGHT_CORE | BOX) == 0;
        for (scene, object, marks, beside) in
            [(of_a, pair.i, marks_a, marks_b), (of_b, pair.j, marks_b, marks_a)]
        {
            if is_other(marks) && beside & SPHERE != 0 {
                prefetch_planes(scene, object, facets);
            } else {
                prefetch_first(scene, object);
            }
        }
    }

    /// Prefetches parts of a pair's compounds. Reads where they are: what waits for that is behind it.
    pub(super) fn look_ahead_to_compounds(
        &self,
        pair: Pair,
        parts: impl Iterator<Item = [u32; 2]>,
    ) {
        let of_parts = |side: PosedShape<'a>| match side.shape {
            Shape::Compound(compound) => compound.parts(),
            _ => &[],
        };
        let [of_a, of_b] = self.posed(pair).map(of_parts);
        for [j, k] in parts.take(PARTS) {
            prefetch(of_a.get(j as usize..=j as usize).unwrap_or_default());
            prefetch(of_b.get(k as usize..=k as usize).unwrap_or_default());
        }
    }

    /// Prefetches what the measure of a pair's parts reads of meshes.
    #[inline(always)]
    pub(super) fn look_ahead_to_parts(&self, pair: Pair, parts: &[[u32; 2]]) {
        let [of_a, of_b] = self.scenes;
        prefetch_triangles(of_a, pair.i, parts.iter().map(|part| part[0]));
        prefetch_triangles(of_b, pair.j, parts.iter().map(|part| part[1]));
    }
}

#[inline(always)]
fn posed<'a>(frame: &'a SimdFrame, scene: &'a Scene, record: u32) -> PosedShape<'a> {
    if (record as usize) < scene.len() {
        PosedShape::of(scene, record)
    } else {
        part(frame, scene, record).1
    }
}

/// A part by its record: its number in its compound, and the part as the compound has placed it; of an object's own record the
/// object, its only part.
#[inline(never)]
pub(super) fn part<'a>(frame: &SimdFrame, scene: &'a Scene, record: u32) -> (u32, PosedShape<'a>) {
    let Some((object, number)) = frame.owner_of(record) else {
        return (0, PosedShape::of(scene, record));
    };
    let whole = PosedShape::of(scene, object);
    let Shape::Compound(compound) = whole.shape else { return (0, whole) };
    (number, PosedShape { shape: compound.parts()[number as usize].placed(), ..whole })
}

/// The shape of an object; `None` of a part, of which nothing is prefetched.
#[inline(always)]
fn shape_of(scene: &Scene, object: u32) -> Option<&Shape> {
    let shape = *scene.shape_of().get(object as usize)?;
    Some(&scene.shapes()[shape as usize])
}

/// See [`ScenePairs::vertices`].
#[inline(always)]
fn vertex(side: PosedShape<'_>, place: u32) -> Option<u32> {
    let polytope = side.shape.as_polytope()?;
    Some(place.min((polytope.vertices().len() as u32).checked_sub(1)?))
}

/// How many triangles of a mesh are prefetched for a pair. No effect on any result.
const TRIANGLES: usize = 8;

/// Prefetches the corners of an object's triangles, if it is a mesh. Reads which they are: what waits for that is behind it.
#[inline(always)]
fn prefetch_triangles(scene: &Scene, object: u32, triangles: impl Iterator<Item = u32>) {
    let Shape::Mesh(mesh) = scene.shape(object as usize) else { return };
    for triangle in triangles.take(TRIANGLES) {
        if let Some(corners) = mesh.triangles().get(triangle as usize) {
            for &corner in corners {
                prefetch(slice::from_ref(&mesh.vertices()[corner as usize]));
            }
        }
    }
}

/// How many pairs of parts are prefetched for a pair. No effect on any result.
const PARTS: usize = 8;

/// Prefetches an object's pose, its core, and where its polytope is.
#[inline(always)]
fn prefetch_places(frame: &SimdFrame, scene: &Scene, object: u32) {
    let Some(&shape) = scene.shape_of().get(object as usize) else { return };
    let shape = shape as usize;
    prefetch(slice::from_ref(&scene.shapes()[shape]));
    prefetch(slice::from_ref(&frame.cores().cores()[shape]));
    prefetch(slice::from_ref(&scene.poses()[object as usize]));
}

/// Prefetches an object's polytope: where its vertices and faces are.
#[inline(always)]
fn prefetch_polytope(scene: &Scene, object: u32) {
    if let Some(Shape::Polytope(polytope)) = shape_of(scene, object) {
        prefetch(slice::from_ref(&**polytope));
    }
}

/// Prefetches an object's vertices, and its faces where `facets` says so.
#[inline(always)]
fn prefetch_shown(frame: &SimdFrame, scene: &Scene, object: u32, facets: bool) {
    prefetch_vertices(frame, scene, object);
    if facets {
        prefetch_facets(scene, object);
    }
}

/// Prefetches an object's vertices.
#[inline(always)]
fn prefetch_vertices(frame: &SimdFrame, scene: &Scene, object: u32) {
    prefetch_few::<BLOCKS, _>(frame.blocks_of(frame.record(object)));
    if let Some(Shape::Polytope(polytope)) = shape_of(scene, object) {
        prefetch_few::<VERTICES, _>(polytope.vertices());
    }
}

/// Prefetches an object's planes and vertices, and its faces where `facets` says so.
#[inline(always)]
fn prefetch_planes(scene: &Scene, object: u32, facets: bool) {
    if let Some(Shape::Polytope(polytope)) = shape_of(scene, object) {
        polytope.prefetch_planes();
        prefetch_few::<VERTICES, _>(polytope.vertices());
        if facets {
            polytope.prefetch_facets();
        }
    }
}

/// Prefetches an object's first vertex.
#[inline(always)]
fn prefetch_first(scene: &Scene, object: u32) {
    if let Some(Shape::Polytope(polytope)) = shape_of(scene, object)
        && let Some(vertex) = polytope.vertices().first()
    {
        prefetch(slice::from_ref(vertex));
    }
}

/// Prefetches the faces of an object.
#[inline(always)]
fn prefetch_facets(scene: &Scene, object: u32) {
    if let Some(Shape::Polytope(polytope)) = shape_of(scene, object) {
        polytope.prefetch_facets();
    }
}
