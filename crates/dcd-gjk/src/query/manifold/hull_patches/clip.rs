//! The corners of what a face has in common with another or an edge: each found by itself, without a branch.

use super::super::clip::SHARP;
use super::rows::{HullOutlines, Packet, Slots, Vector, abs, dot, load, min, mix, store, sum};
use super::{CORNER, SURFACE, VERTEX};
use dcd_simd::Lanes;

/// How far beside a side, or above the surface, a corner may be that counts as on it, relative to the size. Rounding takes 7e-15
/// (docs/numerics/proofs.md, "manifolds"). Larger: points beside their faces, by that over [`SHARP`] where sides meet. Smaller:
/// corners that rounding loses.
const SLACK: f64 = 1e-13;

/// No corner.
const NONE: f64 = f64::NEG_INFINITY;

/// A line in the plane: how far inside a place is, times the length of the side, is x times the first and y times the second
/// and the third.
type Line<L> = Vector<L>;

/// The plane square to the normal, and the height along it.
struct View<L: Lanes> {
    x: Vector<L>,
    y: Vector<L>,
    normal: Vector<L>,
}

impl<L: Lanes> View<L> {
    /// As `DVec3::any_orthonormal_pair` has it.
    #[inline(always)]
    fn along(l: L, normal: Vector<L>) -> Self {
        let [x, y, z] = normal;
        let (zero, one, less) = (l.splat_d(0.0), l.splat_d(1.0), l.splat_d(-1.0));
        let sign = l.select_lt_d(z, zero, less, one);
        let a = l.div_d(less, l.add_d(sign, z));
        let b = l.mul_d(l.mul_d(x, y), a);
        let signed = l.mul_d(sign, x);
        let along_x =
            [l.add_d(one, l.mul_d(l.mul_d(signed, x), a)), l.mul_d(sign, b), l.sub_d(zero, signed)];
        let along_y = [b, l.add_d(sign, l.mul_d(l.mul_d(y, y), a)), l.sub_d(zero, y)];
        Self { x: along_x, y: along_y, normal }
    }

    #[inline(always)]
    fn of(&self, l: L, v: Vector<L>) -> Vector<L> {
        [dot(l, self.x, v), dot(l, self.y, v), dot(l, self.normal, v)]
    }

    /// Makes of all that an outline has in its own frame what is seen, from that place on.
    #[inline(always)]
    fn turn(&self, l: L, outline: &mut HullOutlines, place: Vector<L>) {
        let [p, q, r] = &outline.turn;
        let turn = [self.of(l, load(l, p)), self.of(l, load(l, q)), self.of(l, load(l, r))];
        store(l, mix(l, turn, load(l, &outline.normal)), &mut outline.normal);
        for corner in &mut outline.corners[..outline.most] {
            store(l, sum(l, mix(l, turn, load(l, corner)), place), corner);
        }
        let last = &mut outline.last;
        store(l, sum(l, mix(l, turn, load(l, last)), place), last);
    }
}

/// The height of a face's plane: x times the first and y times the second and the third.
#[inline(always)]
fn plane<L: Lanes>(l: L, outline: &HullOutlines) -> Vector<L> {
    let ([x, y, z], base) = (load(l, &outline.normal), load(l, &outline.corners[0]));
    let down = l.div_d(l.splat_d(-1.0), z);
    let slope = [l.mul_d(x, down), l.mul_d(y, down)];
    let there = l.add_d(l.mul_d(slope[0], base[0]), l.mul_d(slope[1], base[1]));
    [slope[0], slope[1], l.sub_d(base[2], there)]
}

/// The place that is that share of the way from one on.
#[inline(always)]
fn on_way<L: Lanes>(l: L, from: Vector<L>, way: Vector<L>, share: L::D) -> Vector<L> {
    [
        l.add_d(from[0], l.mul_d(way[0], share)),
        l.add_d(from[1], l.mul_d(way[1], share)),
        l.add_d(from[2], l.mul_d(way[2], share)),
    ]
}

/// The value of a line or plane at a place.
#[inline(always)]
fn at<L: Lanes>(l: L, line: Line<L>, x: L::D, y: L::D) -> L::D {
    l.add_d(l.add_d(l.mul_d(line[0], x), l.mul_d(line[1], y)), line[2])
}

/// The number behind one, of those round so many.
#[inline(always)]
fn after(k: usize, most: usize) -> usize {
    if k + 1 < most { k + 1 } else { 0 }
}

impl HullOutlines {
    /// Finds the lines of its sides, inside to the left of them for a sense of 1, and to the right for −1; which of the
    /// pairs have a sharp corner, a bit each.
    #[inline(always)]
    fn find_lines<L: Lanes>(&mut self, l: L, sense: f64, slack: L::D) -> u32 {
        let (zero, sense) = (l.splat_d(0.0), l.splat_d(sense));
        let sharp = l.splat_d(SHARP * SHARP);
        let count = l.load_d(&self.count);
        let mut from = load(l, &self.corners[0]);
        let last = load(l, &self.last);
        let mut before = [l.sub_d(from[0], last[0]), l.sub_d(from[1], last[1])];
        let mut worst = l.splat_d(1.0);
        for k in 0..self.most {
            let to = load(l, &self.corners[after(k, self.most)]);
            let [x, y] = [l.sub_d(to[0], from[0]), l.sub_d(to[1], from[1])];
            let [a, b] = [l.mul_d(l.sub_d(zero, y), sense), l.mul_d(x, sense)];
            let there = l.add_d(l.mul_d(a, from[0]), l.mul_d(b, from[1]));
            let length = l.add_d(abs(l, x), abs(l, y));
            let line = [a, b, l.sub_d(l.mul_d(slack, length), there)];
            store(l, line, &mut self.lines[k]);
            let turn = l.sub_d(l.mul_d(before[0], y), l.mul_d(before[1], x));
            let squares = l.mul_d(square(l, before), square(l, [x, y]));
            // Written so that NaN is sharp.
            let above = l.sub_d(l.mul_d(turn, turn), l.mul_d(sharp, squares));
            let above = l.select_lt_d(zero, above, above, l.splat_d(-1.0));
            let above = l.select_lt_d(l.splat_d(k as f64), count, above, worst);
            worst = min(l, worst, above);
            (before, from) = ([x, y], to);
        }
        // A face has a corner at least; of an edge nothing is sharp.
        l.lt_d(worst, zero) & l.lt_d(l.splat_d(2.5), count)
    }
}

#[inline(always)]
fn square<L: Lanes>(l: L, [x, y]: [L::D; 2]) -> L::D {
    l.add_d(l.mul_d(x, x), l.mul_d(y, y))
}

/// From where on to where an edge is inside of all lines, as parts of its length, and which line it is.
struct Run<L: Lanes> {
    range: [L::D; 2],
    by: [L::D; 2],
}

impl<L: Lanes> Run<L> {
    #[inline(always)]
    fn whole(l: L) -> Self {
        let vertex = l.splat_d(VERTEX);
        Self { range: [l.splat_d(0.0), l.splat_d(1.0)], by: [vertex, vertex] }
    }

    /// Cuts it by a line of that number, of which the values at both ends are known.
    #[inline(always)]
    fn cut(&mut self, l: L, here: L::D, there: L::D, number: f64) {
        let (zero, number) = (l.splat_d(0.0), l.splat_d(number));
        let share = l.div_d(here, l.sub_d(here, there));
        // Outside at both ends: it comes in after it has gone out.
        let comes = l.select_lt_d(there, zero, l.splat_d(2.0), share);
        let comes = l.select_lt_d(here, zero, comes, zero);
        let goes = l.select_lt_d(here, zero, l.splat_d(-1.0), share);
        let goes = l.select_lt_d(there, zero, goes, l.splat_d(1.0));
        let [start, end] = self.range;
        self.by[0] = l.select_lt_d(start, comes, number, self.by[0]);
        self.range[0] = l.select_lt_d(start, comes, comes, start);
        self.by[1] = l.select_lt_d(goes, end, number, self.by[1]);
        self.range[1] = l.select_lt_d(goes, end, goes, end);
    }
}

impl Slots {
    #[inline(always)]
    fn write<L: Lanes>(&mut self, l: L, slot: usize, [x, y, depth]: Vector<L>, by: L::D) {
        let slot = &mut self.0[slot];
        l.store_d(x, &mut slot.x);
        l.store_d(y, &mut slot.y);
        l.store_d(depth, &mut slot.depth);
        l.store_d(by, &mut slot.by);
    }
}

impl Packet {
    /// Finds the corners of the patches, and the four of each that stand for all.
    #[inline(always)]
    pub(super) fn find<L: Lanes>(&mut self, l: L) {
        let zero = l.splat_d(0.0);
        let view = View::along(l, load(l, &self.normal));
        view.turn(l, &mut self.clips, [zero; 3]);
        let apart = view.of(l, load(l, &self.apart));
        view.turn(l, &mut self.clipped, apart);
        let slack = l.mul_d(l.splat_d(SLACK), l.load_d(&self.size));
        let sharp = self.clips.find_lines(l, 1.0, slack);
        // Seen from the face that clips, the other goes round clockwise.
        self.sharp = sharp | self.clipped.find_lines(l, -1.0, slack);
        let height = plane(l, &self.clips);
        self.clip_edges(l, height, slack);
        let mut slots = 2 * self.clipped.most;
        if self.clipped.most > 2 {
            self.add_sides(l, height, slack);
            slots += 2 * self.clips.most;
        }
        let near = l.mul_d(l.splat_d(super::super::SAME), l.load_d(&self.size));
        self.kept.choose(l, &self.slots, slots, near);
        for rows in &mut self.kept.offsets {
            let [x, y, _] = load(l, rows);
            let up = at(l, height, x, y);
            store(l, mix(l, [view.x, view.y, view.normal], [x, y, up]), rows);
        }
    }

    /// Where the edges of what is clipped come in and go out of the face that clips and of what is under it.
    #[inline(always)]
    fn clip_edges<L: Lanes>(&mut self, l: L, height: Vector<L>, slack: L::D) {
        let Self { clips, clipped, values, slots, radius, .. } = self;
        let (none, zero, one) = (l.splat_d(NONE), l.splat_d(0.0), l.splat_d(1.0));
        let radius = l.load_d(radius);
        for (corner, depth) in clipped.corners[..clipped.most].iter().zip(&mut clipped.depths) {
            let [x, y, z] = load(l, corner);
            l.store_d(l.add_d(l.sub_d(at(l, height, x, y), z), radius), depth);
        }
        let count = l.load_d(&clipped.count);
        // An edge goes one way alone: back it has the same corners again.
        let edges = l.select_lt_d(count, l.splat_d(2.5), one, count);
        let [x, y, _] = load(l, &clipped.corners[0]);
        for (line, value) in clips.lines[..clips.most].iter().zip(&mut *values) {
            l.store_d(at(l, load(l, line), x, y), value);
        }
        for j in 0..clipped.most {
            let next = after(j, clipped.most);
            let ([x, y, _], [to_x, to_y, _]) =
                (load(l, &clipped.corners[j]), load(l, &clipped.corners[next]));
            let (depth, to_depth) = (l.load_d(&clipped.depths[j]), l.load_d(&clipped.depths[next]));
            let mut run = Run::whole(l);
            let lines = &clips.lines[..clips.most];
            for (k, (line, value)) in lines.iter().zip(&mut *values).enumerate() {
                let (here, there) = (l.load_d(value), at(l, load(l, line), to_x, to_y));
                run.cut(l, here, there, k as f64);
                l.store_d(there, value);
            }
            run.cut(l, l.add_d(depth, slack), l.add_d(to_depth, slack), SURFACE);
            let Run { range: [start, end], by } = run;
            let way = [l.sub_d(to_x, x), l.sub_d(to_y, y), l.sub_d(to_depth, depth)];
            let number = l.splat_d(j as f64);
            // Where an edge begins inside is a corner, be there an edge or not.
            let mut entry = on_way(l, [x, y, depth], way, start);
            let limit = l.select_lt_d(zero, start, edges, count);
            entry[2] = l.select_lt_d(number, limit, entry[2], none);
            entry[2] = l.select_lt_d(end, start, none, entry[2]);
            slots.write(l, 2 * j, entry, by[0]);
            let mut exit = on_way(l, [x, y, depth], way, end);
            exit[2] = l.select_lt_d(number, edges, exit[2], none);
            exit[2] = l.select_lt_d(end, one, exit[2], none);
            exit[2] = l.select_lt_d(end, start, none, exit[2]);
            slots.write(l, 2 * j + 1, exit, by[1]);
        }
    }

    /// The corners of the face that clips over the other face, and where its sides meet the surface there.
    #[inline(always)]
    fn add_sides<L: Lanes>(&mut self, l: L, height: Vector<L>, slack: L::D) {
        let Self { clips, clipped, values, slots, radius, .. } = self;
        let (none, zero, one) = (l.splat_d(NONE), l.splat_d(0.0), l.splat_d(1.0));
        let (radius, other) = (l.load_d(radius), plane(l, clipped));
        for (corner, depth) in clips.corners[..clips.most].iter().zip(&mut clips.depths) {
            let [x, y, _] = load(l, corner);
            let between = l.sub_d(at(l, height, x, y), at(l, other, x, y));
            l.store_d(l.add_d(between, radius), depth);
        }
        let count = l.load_d(&clips.count);
        let is_face = l.sub_d(l.load_d(&clipped.count), l.splat_d(2.5));
        let [x, y, _] = load(l, &clips.corners[0]);
        for (line, value) in clipped.lines[..clipped.most].iter().zip(&mut *values) {
            l.store_d(at(l, load(l, line), x, y), value);
        }
        for k in 0..clips.most {
            let next = after(k, clips.most);
            let ([x, y, _], [to_x, to_y, _]) =
                (load(l, &clips.corners[k]), load(l, &clips.corners[next]));
            let (depth, to_depth) = (l.load_d(&clips.depths[k]), l.load_d(&clips.depths[next]));
            let (over, to_over) = (l.add_d(depth, slack), l.add_d(to_depth, slack));
            let share = l.div_d(over, l.sub_d(over, to_over));
            // How far inside the corner is, and where its side meets the surface.
            let (mut of_corner, mut of_crossing) = (min(l, is_face, over), is_face);
            for (line, value) in clipped.lines[..clipped.most].iter().zip(&mut *values) {
                let (here, there) = (l.load_d(value), at(l, load(l, line), to_x, to_y));
                of_corner = min(l, of_corner, here);
                let crossing = l.add_d(here, l.mul_d(l.sub_d(there, here), share));
                of_crossing = min(l, of_crossing, crossing);
                l.store_d(there, value);
            }
            let number = l.splat_d(k as f64);
            let first = 2 * (clipped.most + k);
            let used = l.select_lt_d(number, count, depth, none);
            let used = l.select_lt_d(of_corner, zero, none, used);
            slots.write(l, first, [x, y, used], l.splat_d(CORNER + k as f64));
            let (low, high) = (l.splat_d(-1.0), one);
            let crosses = l.select_lt_d(
                over,
                zero,
                l.select_lt_d(to_over, zero, low, high),
                l.select_lt_d(to_over, zero, high, low),
            );
            let way = [l.sub_d(to_x, x), l.sub_d(to_y, y), l.sub_d(to_depth, depth)];
            let mut crossing = on_way(l, [x, y, depth], way, share);
            crossing[2] = l.select_lt_d(number, count, crossing[2], none);
            let inside = min(l, of_crossing, crosses);
            crossing[2] = l.select_lt_d(inside, zero, none, crossing[2]);
            slots.write(l, first + 1, crossing, number);
        }
    }
}
