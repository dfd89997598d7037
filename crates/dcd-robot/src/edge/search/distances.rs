//! What the distance of a pair proves in the interval round where the robot is.

use super::EdgeSearch;
use dcd_gjk::PosedShape;
use dcd_gjk::distance::{DistanceResult, distance, in_f64};

impl EdgeSearch<'_> {
    /// [`is_proved_by_distance`](Self::is_proved_by_distance) where a mesh's hull proves the pair apart, or will do so on a
    /// shorter interval; `None` where the mesh itself is needed.
    fn is_proved_by_hulls(&mut self, pair: u32, carried: Option<glam::DMat3>) -> Option<bool> {
        let edge_pair = self.pairs[pair as usize];
        let hulls =
            edge_pair.objects.map(|object| self.checker.volumes[object as usize].hull.as_ref());
        if hulls.iter().all(Option::is_none) {
            return None;
        }
        let [a, b] = [0, 1].map(|k| {
            let posed = self.posed(edge_pair.objects[k]);
            PosedShape { shape: hulls[k].unwrap_or(posed.shape), ..posed }
        });
        let DistanceResult::Apart(found) = in_f64(a, b) else { return None };
        self.keep(pair, carried, found.normal);
        let lost = self.slack(&edge_pair) + self.off(&edge_pair);
        let along = self.along(&edge_pair, found.normal);
        let proved = found.lower() - self.moved(&edge_pair) - lost;
        let proved = along.map_or(proved, |gaps| proved.max(gaps.proved));
        if self.suffices(proved) {
            return Some(self.note(proved));
        }
        // The mesh is no nearer: a gap that suffices at the middle does so on a shorter interval.
        self.suffices(found.lower() - lost).then_some(false)
    }

    pub(super) fn is_proved_by_distance(
        &mut self,
        pair: u32,
        carried: Option<glam::DMat3>,
    ) -> bool {
        let edge_pair = self.pairs[pair as usize];
        if let Some(is_proved) = self.is_proved_by_hulls(pair, carried) {
            return is_proved;
        }
        let [a, b] = edge_pair.objects.map(|object| self.posed(object));
        let mut found = in_f64(a, b);
        if !matches!(found, DistanceResult::Apart(_)) {
            found = distance(a, b).0;
        }
        let found = match found {
            DistanceResult::Apart(found) => found,
            // Proved, at the poses that the robot's placing gives.
            DistanceResult::Touching => {
                self.hit = Some((self.at.t, edge_pair.objects));
                return false;
            }
            _ => return false,
        };
        self.keep(pair, carried, found.normal);
        let off = self.off(&edge_pair);
        self.nearest = self.nearest.min(found.upper() + off);
        let mut proved = found.lower() - (self.moved(&edge_pair) + self.slack(&edge_pair) + off);
        if !self.suffices(proved) {
            let along = self.along(&edge_pair, found.normal);
            proved = along.map_or(proved, |gaps| proved.max(gaps.proved));
        }
        // Proved, and by as much as a clearance needs.
        let enough = proved > 0.0 && (self.suffices(proved) || proved >= 0.5 * found.lower());
        if enough { self.note(proved) } else { false }
    }
}
