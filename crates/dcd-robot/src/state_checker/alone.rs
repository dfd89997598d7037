//! A state alone: sixteen of its links in the lanes, where a packet has a link in sixteen states.

use super::links::LinkSpheres;
use super::one_link::{LinkPlace, LinkPlaces, OneLink};
use super::rounded_links::{OneState, bits, place_again_alone, splat};
use super::sift::{Sift, near_spheres};
use super::{FAR, SpherePacket};
use dcd_geom::Aabb;
use dcd_simd::{Block, Lanes, Row, WIDTH};
use glam::Vec4;

/// The spheres round what each of up to sixteen links carries, in the world, metres.
#[derive(Clone, Debug)]
pub(super) struct LinkRow {
    centre: Block,
    radius: Row,
    margin: Row,
    /// Those that there are.
    filled: u32,
    /// A box round them, larger by twice the margin of each.
    aabb: Aabb,
}

/// The links of a row that are checked against another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinkPairRow {
    /// The other one, by its place among those with spheres.
    link: u32,
    row: u32,
    /// A bit for each.
    links: u32,
}

impl LinkPairRow {
    /// Of pairs in the order of their second links, then their first: in the same order.
    pub(super) fn of(pairs: &[[u32; 2]]) -> Vec<Self> {
        let mut rows: Vec<Self> = Vec::new();
        for &[a, b] in pairs {
            let (row, bit) = (a / WIDTH as u32, 1 << (a % WIDTH as u32));
            match rows.last_mut() {
                Some(last) if (last.link, last.row) == (b, row) => last.links |= bit,
                _ => rows.push(Self { link: b, row, links: bit }),
            }
        }
        rows
    }
}

impl LinkRow {
    const EMPTY: Self = {
        let none = Row([0.0; WIDTH]);
        let centre = Block([none; 3]);
        Self { centre, radius: none, margin: none, filled: 0, aabb: Aabb::EMPTY }
    };

    /// Fills rows with the links of a state.
    #[inline(always)]
    fn gather(links: &[LinkSpheres], placed: &[OneLink], to: &mut Vec<Self>) {
        let count = links.len().div_ceil(WIDTH);
        if to.len() != count {
            to.resize(count, Self::EMPTY);
        }
        let groups = links.chunks(WIDTH).zip(placed.chunks(WIDTH));
        for (row, (links, placed)) in to.iter_mut().zip(groups) {
            row.fill(links, placed);
        }
    }

    /// Takes sixteen links at most, and finds the box round them that [`around`](super::packed_aabbs::around) finds in lanes.
    #[inline(always)]
    fn fill(&mut self, links: &[LinkSpheres], placed: &[OneLink]) {
        let Self { centre: Block([x, y, z]), radius, margin, filled, aabb } = self;
        let (mut min, mut max) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        let (mut lane, far) = (0, Vec4::splat(FAR));
        let mut is_known = true;
        for (link, placed) in links.iter().zip(placed) {
            let (centre, off) = (placed.centre(), placed.margin());
            let at = lane % WIDTH;
            (x.0[at], y.0[at], z.0[at]) = (centre.x, centre.y, centre.z);
            (radius.0[at], margin.0[at]) = (link.radius, off);
            let (centre, reach) = (centre.extend(0.0), Vec4::splat(link.radius + (off + off)));
            let (low, high) = (centre - reach, centre + reach);
            (min, max) = (min.min(low), max.max(high));
            // Written so that of a NaN nothing is known.
            is_known &= ((-low).cmple(far) & high.cmple(far)).all();
            lane += 1;
        }
        *filled = (1 << lane) - 1;
        let (min, max) = (min.truncate(), max.truncate());
        *aabb = if is_known { Aabb { min, max } } else { Aabb::EVERYTHING };
    }

    #[inline(always)]
    fn spheres<L: Lanes>(&self, l: L) -> SpherePacket<L> {
        let Block([x, y, z]) = &self.centre;
        SpherePacket {
            centre: [l.load(x), l.load(y), l.load(z)],
            outer: l.load(&self.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.load(&self.margin),
        }
    }

    /// One of them in all lanes.
    #[inline(always)]
    fn one<L: Lanes>(&self, l: L, lane: usize) -> SpherePacket<L> {
        SpherePacket {
            centre: splat(l, self.centre.point(lane)),
            outer: l.splat(self.radius.0[lane]),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.splat(self.margin.0[lane]),
        }
    }
}

impl Sift<'_> {
    /// The comparisons of several states, each rounded as there and in the same order, so that the answers are the same.
    #[inline(always)]
    pub(super) fn alone<L: Lanes>(&mut self, l: L, one: &mut OneState, near: &mut Vec<(u32, u32)>) {
        let prepared = self.prepared;
        let OneState { world, own, gathered } = one;
        let links = &*prepared.world_links;
        let slid = self.placed.place_alone(l, links, world);
        LinkRow::gather(links, world, gathered);
        for (number, row) in gathered.iter().enumerate() {
            let spheres = row.spheres(l);
            self.list_near(l, (&spheres, row.filled), &row.aabb, near);
            let any = near.iter().fold(0, |any, &(_, links)| any | links);
            for lane in bits(any) {
                if self.open == 0 {
                    return;
                }
                let link = number * WIDTH + lane;
                self.rows_against(l, (&links[link], world.at(link)), 0, (near, lane));
            }
        }
        let (mut links, mut placed) = (links, &*world);
        if let Some(own_links) = &prepared.own_links {
            place_again_alone(l, own_links, (world, slid), own);
            (links, placed) = (own_links, own);
            LinkRow::gather(links, placed, gathered);
        }
        for &LinkPairRow { link, row, links: wanted } in &prepared.link_pair_rows {
            if self.open == 0 {
                return;
            }
            let (b, row) = (link as usize, row as usize);
            let of_b = gathered[b / WIDTH].one(l, b % WIDTH);
            let met = near_spheres(l, &gathered[row].spheres(l), &of_b) & wanted;
            for lane in bits(met) {
                let of = |link: usize| (&links[link], placed.at(link));
                self.rows_against_each_other(l, of(row * WIDTH + lane), of(b), 0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::packed_aabbs::around;
    use super::*;
    use dcd_simd::{Kernel, Path, dispatch_on};
    use glam::Vec3;

    /// The box round links at these places, as a state alone and as sixteen lanes have it.
    struct BothBoxes<'a>(&'a [LinkSpheres], &'a [Vec3]);

    impl Kernel for BothBoxes<'_> {
        type Output = [Aabb; 2];

        fn run<L: Lanes>(self, l: L) -> [Aabb; 2] {
            let Self(links, places) = self;
            let mut placed = vec![OneLink::default(); links.len()];
            for ((link, placed), at) in links.iter().zip(&mut placed).zip(places) {
                placed.columns = [Vec4::X, Vec4::Y, Vec4::Z, at.extend(0.0)];
                placed.finish::<L>(link, 0.5);
            }
            let mut rows = Vec::new();
            LinkRow::gather(links, &placed, &mut rows);
            [rows[0].aabb, around(l, &rows[0].spheres(l), rows[0].filled)]
        }
    }

    #[test]
    fn the_box_round_links_is_that_of_the_lanes_and_everything_where_one_is_nowhere() {
        let link = |k: usize| LinkSpheres {
            centre: Vec3::new(0.1, -0.2, 0.05 * k as f32),
            radius: 0.3 + 0.1 * k as f32,
            lost: [1e-5, 1e-6],
            ..LinkSpheres::default()
        };
        let place = |k: usize| Vec3::new(1.5, -0.7, 0.3) * (k as f32 * 2.7).sin();
        let ends = [f32::NAN, f32::INFINITY, -2.0 * FAR, 1.5 * FAR];
        for path in Path::ALL.into_iter().filter(|path| path.is_available()) {
            for count in 1..=WIDTH {
                let links: Vec<LinkSpheres> = (0..count).map(link).collect();
                let mut places: Vec<Vec3> = (0..count).map(place).collect();
                let [alone, lanes] = dispatch_on(path, BothBoxes(&links, &places));
                assert_eq!(alone, lanes, "{path:?}, {count} links");
                assert!(alone.max.max_element() < 10.0, "{path:?}, {count} links: {alone:?}");
                for (axis, end) in ends.into_iter().enumerate() {
                    places[axis % count][axis % 3] = end;
                    let both = dispatch_on(path, BothBoxes(&links, &places));
                    assert_eq!(both, [Aabb::EVERYTHING; 2], "{path:?}, {count} links, {end}");
                    places[axis % count] = place(axis % count);
                }
            }
        }
    }

    #[test]
    fn rows_have_the_pairs_that_there_were_in_their_order() {
        let takes = |a: u32, b: u32| !(a * 7 + b * 5).is_multiple_of(3);
        for count in [0, 1, 2, 15, 16, 17, 40] {
            let of_b = |b: u32| (0..b).filter(move |&a| takes(a, b)).map(move |a| [a, b]);
            let pairs: Vec<[u32; 2]> = (0..count).flat_map(of_b).collect();
            let rows = LinkPairRow::of(&pairs);
            let of_row = |row: &LinkPairRow| {
                let &LinkPairRow { link, row, links } = row;
                bits(links).map(move |lane| [row * WIDTH as u32 + lane as u32, link])
            };
            assert!(rows.iter().flat_map(of_row).eq(pairs), "{count} links");
        }
    }
}
