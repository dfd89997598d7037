//! What one source says about pairs.

use std::collections::{BTreeMap, HashMap, HashSet};

/// Pairs, bodies and defaults of one file, or of a robot's own build.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layer {
    /// In the order of their names.
    pairs: BTreeMap<[String; 2], bool>,
    matrix: Matrix,
    /// Links, or carried objects, of one number are one rigid body.
    bodies: HashMap<String, usize>,
    /// The body of what each link carries.
    carried: HashMap<String, usize>,
    /// Whether all names are of links: an SRDF knows nothing of obstacles.
    is_of_links: bool,
    /// Whether a name may touch whatever nothing else is said of.
    defaults: BTreeMap<String, bool>,
}

/// Names, and for each two of them whether they may touch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Matrix {
    indices: HashMap<String, usize>,
    names: Vec<String>,
    /// Row by row.
    values: Vec<bool>,
}

impl Matrix {
    /// The rows are as many and as long as there are names, which differ.
    pub(crate) fn new(names: Vec<String>, rows: &[Vec<bool>]) -> Self {
        let indices = names.iter().cloned().zip(0..).collect();
        Self { indices, names, values: rows.concat() }
    }

    fn says(&self, a: &str, b: &str) -> Option<bool> {
        let (row, column) = (self.indices.get(a)?, self.indices.get(b)?);
        self.values.get(row * self.names.len() + column).copied()
    }

    fn pairs(&self) -> impl Iterator<Item = ([&str; 2], bool)> {
        self.names.iter().enumerate().flat_map(move |(row, a)| {
            let later = self.names[row..].iter().zip(&self.values[row * self.names.len() + row..]);
            later.map(move |(b, &may)| ([a.as_str(), b.as_str()], may))
        })
    }
}

impl Layer {
    /// Of names that are those of links, whatever else has them.
    pub(crate) fn of_links() -> Self {
        Self { is_of_links: true, ..Self::default() }
    }

    pub(super) fn is_of_links(&self) -> bool {
        self.is_of_links
    }

    /// Takes over the pairs and defaults of another file.
    pub(super) fn merge(&mut self, other: Self) {
        self.pairs.extend(other.pairs);
        self.defaults.extend(other.defaults);
    }

    /// Forgets, of a layer of links, names that are no links.
    pub(super) fn keep_links(&mut self, links: &HashSet<&str>) {
        if self.is_of_links {
            self.pairs.retain(|pair, _| pair.iter().all(|name| links.contains(name.as_str())));
            self.defaults.retain(|name, _| links.contains(name.as_str()));
        }
    }

    /// Whether something that the link carries is tied here.
    pub(super) fn carries_by(&self, link: &str) -> bool {
        self.carried.contains_key(link)
    }

    /// Ties an object to what else its link carries, and allows it to touch the link.
    pub(crate) fn carry(&mut self, object: &str, link: &str) {
        let numbers = self.bodies.values().chain(self.carried.values());
        let next = || numbers.max().map_or(0, |last| last + 1);
        let body = self.carried.get(link).copied().unwrap_or_else(next);
        self.carried.insert(link.to_owned(), body);
        self.tie(object, body);
        self.set(object, link, true);
    }

    pub(crate) fn set(&mut self, a: &str, b: &str, may: bool) {
        let (first, second) = if a <= b { (a, b) } else { (b, a) };
        self.pairs.insert([first.to_owned(), second.to_owned()], may);
    }

    /// Forgets the pairs of a name that may touch, and its body.
    pub(super) fn forget(&mut self, name: &str) {
        self.untie(name);
        self.pairs.retain(|pair, may| !*may || pair.iter().all(|own| own != name));
    }

    pub(crate) fn set_default(&mut self, name: &str, may: bool) {
        self.defaults.insert(name.to_owned(), may);
    }

    pub(crate) fn set_matrix(&mut self, matrix: Matrix) {
        self.matrix = matrix;
    }

    /// Puts a link in a body.
    pub(crate) fn tie(&mut self, link: &str, body: usize) {
        self.bodies.insert(link.to_owned(), body);
    }

    /// Takes a link out of its body.
    pub(super) fn untie(&mut self, link: &str) {
        self.bodies.remove(link);
    }

    /// What it says of a pair; none where it does not speak of it. What names both comes before what
    /// names one.
    pub(super) fn says(&self, a: &str, b: &str) -> Option<bool> {
        let (first, second) = if a <= b { (a, b) } else { (b, a) };
        let pair = || self.pairs.get(&[first.to_owned(), second.to_owned()]).copied();
        let tied = || self.bodies.get(a).filter(|body| self.bodies.get(b) == Some(body));
        let named = if self.pairs.is_empty() { None } else { pair() };
        named.or_else(|| self.matrix.says(first, second)).or_else(|| tied().map(|_| true)).or_else(
            || match (self.defaults.get(a), self.defaults.get(b)) {
                // As MoveIt has it: of two defaults the stricter.
                (Some(&a), Some(&b)) => Some(a && b),
                (one, other) => one.or(other).copied(),
            },
        )
    }

    pub(super) fn has_matrix(&self) -> bool {
        !self.matrix.names.is_empty()
    }

    /// Every pair that is named, with what is said of it.
    pub(crate) fn named(&self) -> impl Iterator<Item = ([&str; 2], bool)> {
        let listed = self.pairs.iter().map(|([a, b], &may)| ([a.as_str(), b.as_str()], may));
        listed.chain(self.matrix.pairs())
    }

    /// The names that may touch all that nothing else is said of.
    pub(crate) fn open(&self) -> impl Iterator<Item = &str> {
        self.defaults.iter().filter(|(_, may)| **may).map(|(name, _)| name.as_str())
    }

    /// The names that by default may not touch.
    pub(crate) fn closed(&self) -> impl Iterator<Item = &str> {
        self.defaults.iter().filter(|(_, may)| !**may).map(|(name, _)| name.as_str())
    }

    /// The body of a link.
    pub(crate) fn body(&self, link: &str) -> Option<usize> {
        self.bodies.get(link).copied()
    }

    /// Every name that it speaks of, perhaps more than once.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let listed = self.pairs.keys().flatten().map(String::as_str);
        let all = listed.chain(self.matrix.names.iter().map(String::as_str));
        all.chain(self.defaults.keys().map(String::as_str))
    }

    /// The names of links that are tied to others.
    pub(crate) fn tied(&self) -> impl Iterator<Item = &str> {
        self.bodies.keys().map(String::as_str)
    }

    pub(super) fn is_empty(&self) -> bool {
        let tied = self.bodies.len();
        self.open().next().is_none() && tied == 0 && self.named().all(|(_, may)| !may)
    }
}

#[cfg(test)]
mod tests {
    use super::super::AllowedPairs;
    use super::*;

    #[test]
    fn what_is_said_later_counts_and_a_pair_before_a_body_before_a_default() {
        let mut layer = Layer::default();
        for link in ["a", "b", "c"] {
            layer.tie(link, 7);
        }
        layer.set("b", "a", false);
        layer.set_default("d", true);
        layer.set_default("e", false);
        let mut allowed = AllowedPairs::default();
        allowed.push(layer);
        let may = |allowed: &AllowedPairs, a, b| {
            assert_eq!(allowed.contains(a, b), allowed.contains(b, a));
            allowed.contains(a, b)
        };
        assert!(!may(&allowed, "a", "b") && may(&allowed, "a", "c"));
        assert!(may(&allowed, "d", "a") && !may(&allowed, "d", "e") && !may(&allowed, "e", "a"));
        let mut later = Layer::default();
        let names = ["a", "b", "d"].map(str::to_owned).to_vec();
        let rows = [[false, true, false], [true, false, false], [false; 3]].map(|row| row.to_vec());
        later.set_matrix(Matrix::new(names, &rows));
        allowed.push(later);
        assert!(may(&allowed, "a", "b") && !may(&allowed, "d", "a") && may(&allowed, "d", "c"));
        assert_eq!(allowed.len(), 1);
    }
}
