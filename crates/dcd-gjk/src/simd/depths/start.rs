//! Where a search starts: the points of both objects that are farthest along the world's axes.

use super::points::Points;
use super::vectors::{Axis, farthest, vertex};
use dcd_geom::glam::{Vec3, Vec4};
use dcd_simd::{Block, Lanes};

/// The points farthest along x, y, z, −x, −y, −z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extremes {
    pub(super) numbers: [u32; 6],
    /// Where each is, round the object's centre, and a 0: metres.
    pub(super) points: [Vec4; 6],
}

/// Of how many objects the farthest points are remembered. A power of two. No effect on any result. Larger: memory.
/// Smaller: objects that are looked through again.
const REMEMBERED: usize = 512;

/// What is remembered of an object.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    /// The slice, odd for an object of the second frame, and the object's number.
    key: (u32, u32),
    extremes: Extremes,
}

/// The farthest points of objects that recur in one slice.
#[derive(Clone, Debug)]
pub(super) struct Starts {
    /// Twice the number of the slice: poses may change between two.
    slice: u32,
    entries: Box<[Entry; REMEMBERED]>,
}

impl Default for Starts {
    fn default() -> Self {
        Self { slice: 0, entries: Box::new([Entry::default(); REMEMBERED]) }
    }
}

impl Starts {
    /// Forgets all.
    pub(super) fn begin(&mut self) {
        self.slice = self.slice.wrapping_add(2);
        if self.slice == 0 {
            *self = Self { slice: 2, ..Self::default() };
        }
    }

    /// Of an object of the first frame, or of the second of two.
    #[inline(always)]
    pub(super) fn of<L: Lanes>(
        &mut self,
        l: L,
        (object, is_second): (u32, bool),
        points: &Points<'_>,
    ) -> Extremes {
        let key = (self.slice | u32::from(is_second), object);
        let entry = &mut self.entries[object as usize % REMEMBERED];
        if entry.key != key {
            *entry = Entry { key, extremes: extremes(l, points) };
        }
        entry.extremes
    }
}

/// The points farthest along the axes.
// No array is mapped here: what that calls would be compiled for no path.
#[inline(always)]
pub(super) fn extremes<L: Lanes>(l: L, points: &Points<'_>) -> Extremes {
    let mut extremes = Extremes::default();
    for axis in 0..3 {
        let (most, least) = match points {
            Points::Vertices(blocks) => (
                vertex_along(l, blocks, &Axis::Along(axis)),
                vertex_along(l, blocks, &Axis::Against(axis)),
            ),
            Points::Rims(rims, _) => {
                (rims.farthest(Vec3::AXES[axis]), rims.farthest(-Vec3::AXES[axis]))
            }
        };
        for (side, (point, number)) in [(axis, most), (axis + 3, least)] {
            extremes.numbers[side] = number;
            extremes.points[side] = point.extend(0.0);
        }
    }
    extremes
}

/// The vertex farthest along an axis, and its number.
#[inline(always)]
fn vertex_along<L: Lanes>(l: L, blocks: &[Block], axis: &Axis) -> (Vec3, u32) {
    let number = farthest(l, blocks, axis);
    (vertex(blocks, number), number as u32)
}

#[cfg(test)]
mod tests {
    use super::super::surface::Surface;
    use super::*;
    use dcd_simd::{Kernel, Path, Row, WIDTH, dispatch_on};

    struct Find<'a> {
        starts: &'a mut Starts,
        object: (u32, bool),
        blocks: &'a [Block],
    }

    impl Kernel for Find<'_> {
        type Output = Extremes;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Extremes {
            self.starts.of(l, self.object, &Points::Vertices(self.blocks))
        }
    }

    fn paths() -> impl Iterator<Item = Path> {
        Path::ALL.into_iter().filter(|path| path.is_available())
    }

    /// Numbers of a coarse grid, so that many vertices are equally far.
    fn blocks(seed: usize, count: usize) -> Vec<Block> {
        let number = |k: usize| ((k * 2_654_435_761 + seed * 97) >> 7) % 23;
        let row = |first: usize| Row(std::array::from_fn(|k| number(first + k) as f32 - 11.0));
        let block = |k: usize| Block([0, 1, 2].map(|axis| row(48 * k + 16 * axis)));
        (0..count).map(block).collect()
    }

    #[test]
    fn the_farthest_vertices_are_those_of_a_plain_loop_on_every_path() {
        for path in paths() {
            let mut starts = Starts::default();
            for seed in 0..40 {
                let blocks = blocks(seed, 1 + seed % 16);
                starts.begin();
                let find = Find { starts: &mut starts, object: (7, false), blocks: &blocks };
                let found = dispatch_on(path, find);
                let point =
                    |number: u32| blocks[number as usize / WIDTH].point(number as usize % WIDTH);
                for (k, &number) in found.numbers.iter().enumerate() {
                    assert_eq!(found.points[k], point(number).extend(0.0));
                    let along = |p: Vec3| if k < 3 { p[k] } else { -p[k - 3] };
                    let all = blocks.iter().flat_map(|b| (0..WIDTH).map(|lane| b.point(lane)));
                    let most = all.map(along).fold(f32::NEG_INFINITY, f32::max);
                    assert_eq!(along(point(number)), most, "{path:?} {seed} {k}");
                    let as_far = (0..).take(WIDTH * blocks.len());
                    let as_far = as_far.filter(|&number| along(point(number)) == most);
                    let first = as_far.min_by_key(|&number| (number as usize % WIDTH, number));
                    assert_eq!(first, Some(number), "{path:?} {seed} {k}");
                }
            }
        }
    }

    #[test]
    fn what_is_remembered_is_of_the_slice_the_frame_and_the_object() {
        let (one, other) = (blocks(1, 3), blocks(2, 3));
        let mut starts = Starts::default();
        let mut of = |is_new: bool, object, blocks: &[Block]| {
            if is_new {
                starts.begin();
            }
            dispatch_on(Path::best(), Find { starts: &mut starts, object, blocks })
        };
        let (of_one, of_other) = (of(true, (7, false), &one), of(true, (7, false), &other));
        assert_ne!(of_one, of_other);
        assert_eq!(of(false, (7, true), &one), of_one);
        assert_eq!(of(false, (7 + REMEMBERED as u32, true), &other), of_other);
        assert_eq!(of(false, (7, true), &one), of_one);
        // Kept within a slice, without a look at the vertices.
        assert_eq!(of(false, (7, true), &other), of_one);
    }

    /// The distance of the nearest face of an octahedron; `None` where it is refused.
    struct Nearest([Vec3; 6]);

    impl Kernel for Nearest {
        type Output = Option<f32>;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Option<f32> {
            let mut surface = Surface::default();
            let corners = self.0.map(|at| at.extend(0.0));
            surface.start_round(l, &corners, 1e-6)?;
            assert_eq!(surface.doubtful(l), 0);
            Some(surface.distance(surface.nearest(l)))
        }
    }

    #[test]
    fn a_convex_octahedron_is_a_start_and_no_other() {
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        for path in paths() {
            let found = dispatch_on(path, Nearest([x, y, z, -x, -y, -z])).unwrap();
            assert!((found - 1.0 / 3f32.sqrt()).abs() < 1e-6, "{path:?} {found}");
            // The corner at x is behind the plane of its neighbours.
            let dented = [0.1 * x, y + x, z + x, -x, x - y, x - z];
            assert_eq!(dispatch_on(path, Nearest(dented)), None);
            // Two corners are one vertex.
            assert_eq!(dispatch_on(path, Nearest([x, x, z, -x, -y, -z])), None);
        }
    }
}
