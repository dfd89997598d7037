//! A state alone, or one of few: sixteen of its links in the lanes, where a packet has a link in sixteen states.

use super::SpherePacket;
use super::links::LinkSpheres;
use super::obstacle_tree::NearObstacles;
use super::one_link::LinkPlaces;
use super::packed_aabbs::around;
use super::rounded_links::{LinkSphereRow, OneRounded, bits, of_block, splat};
use super::sift::{Sift, near_spheres};
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// The spheres round what each of up to sixteen links carries, in the links' frames, metres.
#[derive(Clone, Debug)]
pub(super) struct LinkRow {
    pub(super) centre: Block,
    radius: Row,
    /// [`LinkSpheres::lost`].
    pub(super) lost: [Row; 2],
    /// Those that there are.
    filled: u32,
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
        Self { centre: Block([none; 3]), radius: none, lost: [none; 2], filled: 0 }
    };

    /// All links, sixteen to a row.
    pub(super) fn of(links: &[LinkSpheres]) -> Vec<Self> {
        links.chunks(WIDTH).map(Self::of_few).collect()
    }

    fn of_few(links: &[LinkSpheres]) -> Self {
        let mut row = Self::EMPTY;
        for (lane, link) in links.iter().enumerate() {
            for (axis, centre) in link.centre.to_array().into_iter().enumerate() {
                row.centre.0[axis].0[lane] = centre;
            }
            row.radius.0[lane] = link.radius;
            for (row, lost) in row.lost.iter_mut().zip(link.lost) {
                row.0[lane] = lost;
            }
            row.filled |= 1 << lane;
        }
        row
    }

    #[inline(always)]
    fn spheres<L: Lanes>(&self, l: L, placed: &LinkSphereRow) -> SpherePacket<L> {
        SpherePacket {
            centre: of_block(l, &placed.centre),
            outer: l.load(&self.radius),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.load(&placed.margin),
        }
    }

    /// One of them in all lanes.
    #[inline(always)]
    fn one<L: Lanes>(&self, l: L, placed: &LinkSphereRow, lane: usize) -> SpherePacket<L> {
        SpherePacket {
            centre: splat(l, placed.centre.point(lane)),
            outer: l.splat(self.radius.0[lane]),
            inner: l.splat(f32::NEG_INFINITY),
            margin: l.splat(placed.margin.0[lane]),
        }
    }
}

impl Sift<'_> {
    /// The comparisons of several states for one of them, which has been placed, each rounded as there and in the same order,
    /// so that the answers are the same.
    #[inline(always)]
    pub(super) fn alone<L: Lanes>(
        &mut self,
        l: L,
        (state, slid): (usize, f32),
        one: &mut OneRounded,
        near: &mut NearObstacles,
    ) {
        let prepared = self.prepared;
        let (mut links, mut rows) = (&*prepared.world_links, &*prepared.world_rows);
        let world = one.world();
        for (number, (row, placed)) in rows.iter().zip(world.spheres).enumerate() {
            let spheres = row.spheres(l, placed);
            let aabb = around(l, &spheres, row.filled);
            self.list_near(l, (&spheres, row.filled), &aabb, near);
            let any = near.listed.iter().fold(0, |any, &(_, links)| any | links);
            for lane in bits(any) {
                if self.open == 0 {
                    return;
                }
                let link = number * WIDTH + lane;
                self.rows_against(l, (&links[link], world.at(link)), state, (&near.listed, lane));
            }
        }
        if let Some(own_links) = &prepared.own_links {
            one.place_own(l, &prepared.own_rows, slid);
            (links, rows) = (own_links, &prepared.own_rows);
        }
        let placed = if prepared.own_links.is_some() { one.own() } else { one.world() };
        let spheres = placed.spheres;
        for &LinkPairRow { link, row, links: wanted } in &prepared.link_pair_rows {
            if self.open == 0 {
                return;
            }
            let (b, row) = (link as usize, row as usize);
            let of_b = rows[b / WIDTH].one(l, &spheres[b / WIDTH], b % WIDTH);
            let met = near_spheres(l, &rows[row].spheres(l, &spheres[row]), &of_b) & wanted;
            for lane in bits(met) {
                let of = |link: usize| (&links[link], placed.at(link));
                self.rows_against_each_other(l, of(row * WIDTH + lane), of(b), state);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
