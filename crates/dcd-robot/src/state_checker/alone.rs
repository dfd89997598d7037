//! A state alone: sixteen of its links in the lanes, where a packet has a link in sixteen states.

use super::SpherePacket;
use super::links::LinkSpheres;
use super::one_link::{LinkPlace, LinkPlaces, OneLink};
use super::packed_aabbs::around;
use super::rounded_links::{OneState, bits, place_again_alone, splat};
use super::sift::{Sift, meeting};
use dcd_simd::{Block, Lanes, Row, WIDTH};

/// The spheres round what each of up to sixteen links carries, in the world, metres.
#[derive(Clone, Debug)]
pub(super) struct LinkRow {
    centre: Block,
    radius: Row,
    margin: Row,
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
    /// Fills rows with the links of a state.
    #[inline(always)]
    fn gather(links: &[LinkSpheres], placed: &[OneLink], to: &mut Vec<Self>) {
        let none = Row([0.0; WIDTH]);
        let empty = Self { centre: Block([none; 3]), radius: none, margin: none, filled: 0 };
        to.resize(links.len().div_ceil(WIDTH), empty);
        for (k, (link, placed)) in links.iter().zip(placed).enumerate() {
            let (row, lane, centre) = (&mut to[k / WIDTH], k % WIDTH, placed.centre());
            let Block([x, y, z]) = &mut row.centre;
            (x.0[lane], y.0[lane], z.0[lane]) = (centre.x, centre.y, centre.z);
            (row.radius.0[lane], row.margin.0[lane]) = (link.radius, placed.margin());
            row.filled = (2 << lane) - 1;
        }
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
            let aabb = around(l, &spheres, row.filled);
            self.list_near(l, (&spheres, row.filled), &aabb, near);
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
            let near = meeting(l, &gathered[row].spheres(l), &of_b).near & wanted;
            for lane in bits(near) {
                let of = |link: usize| (&links[link], placed.at(link));
                self.rows_against_each_other(l, of(row * WIDTH + lane), of(b), 0);
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
