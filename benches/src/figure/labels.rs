//! Where the names of points stand, so that none hides a point or another name.

/// A rectangle of pixels, its edges included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
}

impl Area {
    /// The square round a point.
    pub(super) fn round((x, y): (i32, i32), half: i32) -> Self {
        Self { left: x - half, right: x + half, top: y - half, bottom: y + half }
    }

    /// The least rectangle round both.
    pub(super) fn joined(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }

    fn meets(&self, other: &Self) -> bool {
        self.left <= other.right
            && other.left <= self.right
            && self.top <= other.bottom
            && other.top <= self.bottom
    }

    fn holds(&self, other: &Self) -> bool {
        self.left <= other.left
            && other.right <= self.right
            && self.top <= other.top
            && other.bottom <= self.bottom
    }
}

/// Where a name stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The upper left corner of the text.
    pub(super) corner: (i32, i32),
    /// The middle of the text's nearest side, where a line from its point ends.
    pub(super) anchor: (i32, i32),
    /// Where that line begins, if the name stands too far away to be understood without one.
    pub(super) leader: Option<(i32, i32)>,
}

/// Names placed one after the other, each as near to its points as is free.
#[derive(Debug)]
pub(super) struct Labels {
    within: Area,
    taken: Vec<Area>,
}

/// Steps from a point outwards, in pixels, and from which on a line leads to the name.
const GAP: i32 = 9;
const STEP: i32 = 9;
const STEPS: i32 = 30;
const NEAR: i32 = 2;

impl Labels {
    pub(super) fn within(within: Area) -> Self {
        Self { within, taken: Vec::new() }
    }

    /// No name stands there.
    pub(super) fn keep_clear(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// The free place nearest to one of the points, for a text of that width and height; the first point where none
    /// is free.
    pub(super) fn place(&mut self, points: [(i32, i32); 2], size: (i32, i32)) -> Place {
        let candidates =
            (0..STEPS).flat_map(|step| points.into_iter().map(move |point| (step, point)));
        let mut candidates = candidates
            .flat_map(|(step, point)| around(step).map(move |towards| (step, point, towards)));
        let free = candidates.find_map(|(step, point, towards)| {
            let (area, anchor) = text_at(point, towards, size);
            let is_free =
                self.within.holds(&area) && !self.taken.iter().any(|taken| taken.meets(&area));
            is_free.then_some((area, anchor, (step > NEAR).then_some(point)))
        });
        let (area, anchor, leader) = free.unwrap_or_else(|| {
            let (area, anchor) = text_at(points[0], (GAP, 0), size);
            (area, anchor, None)
        });
        self.taken.push(area);
        Place { corner: (area.left, area.top), anchor, leader }
    }
}

/// Right, left, above, below and between, that many steps away.
fn around(step: i32) -> [(i32, i32); 8] {
    let far = GAP + STEP * step;
    let skew = far * 7 / 10;
    [
        (far, 0),
        (-far, 0),
        (0, -far),
        (0, far),
        (skew, -skew),
        (-skew, -skew),
        (skew, skew),
        (-skew, skew),
    ]
}

/// The text's area and its side that faces the point.
fn text_at(
    (x, y): (i32, i32),
    (dx, dy): (i32, i32),
    (width, height): (i32, i32),
) -> (Area, (i32, i32)) {
    let left = match dx {
        0 => x - width / 2,
        1.. => x + dx,
        _ => x + dx - width,
    };
    let top = match (dx, dy) {
        (0, ..0) => y + dy - height,
        (0, _) => y + dy,
        _ => y + dy - height / 2,
    };
    let anchor = match dx {
        0 => (x, if dy < 0 { top + height } else { top }),
        1.. => (left, top + height / 2),
        _ => (left + width, top + height / 2),
    };
    (Area { left, right: left + width, top, bottom: top + height }, anchor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_crowded_points_meet_no_point_and_no_other_name() {
        let mut labels = Labels::within(Area { left: 0, right: 700, top: 0, bottom: 400 });
        let points: Vec<_> = (0..9).map(|k| (300 + 3 * k, 200 + 2 * (k % 3))).collect();
        points.iter().for_each(|&point| labels.keep_clear(Area::round(point, 5)));
        for &point in &points {
            labels.place([point, point], (90, 14));
        }
        let all = &labels.taken;
        for (k, one) in all.iter().enumerate().skip(points.len()) {
            assert!(labels.within.holds(one));
            assert!(all[..k].iter().all(|other| !other.meets(one)), "{k}");
        }
    }

    #[test]
    fn a_lonely_name_stands_right_of_its_point_without_a_line() {
        let mut labels = Labels::within(Area { left: 0, right: 700, top: 0, bottom: 400 });
        let place = labels.place([(100, 100), (100, 200)], (50, 14));
        assert_eq!((place.corner, place.leader), ((109, 93), None));
    }
}
