//! Shapes of every kind between neighbouring floats, at the certified precisions.

use std::ops::Range;

use anyhow::{Context, Result};
use dcd_benches::{Cell, Column, Table};
use dcd_gjk::{PosedShape, Verdict, certified};
use dcd_scenes::conformance::{ShapeFamily, ShapePair, shape_flip};
use serde::{Deserialize, Serialize};

use crate::adversary::Account;
use crate::precision::Precision;
use crate::subject::Subject;

/// Who answers for every kind of shape and promises to be right.
const PRECISIONS: [Precision; 2] = [Precision::Lanes, Precision::Certified];

/// What was said of each family.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Families {
    /// Lines along which the pair never stopped touching, never touched, or cannot be judged.
    pub(crate) without_end: u64,
    /// In the order of [`ShapeFamily::ALL`].
    each: [Family; ShapeFamily::ALL.len()],
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Family {
    answers: u64,
    /// In the order of [`PRECISIONS`].
    said: [Account; PRECISIONS.len()],
}

impl Families {
    pub(crate) fn answers(&self) -> u64 {
        self.each.iter().map(|family| family.answers).sum()
    }

    /// Answers that break the promise: wrong ones, and undecided ones of shapes with an exact method.
    pub(crate) fn failures(&self) -> u64 {
        let failures = |(family, each): (ShapeFamily, &Family)| -> u64 {
            let of = |said: &Account| {
                let open = if family == ShapeFamily::Curved { 0 } else { said.undecided };
                said.wrong_yes + said.wrong_no + open
            };
            each.said.iter().map(of).sum()
        };
        ShapeFamily::ALL.into_iter().zip(&self.each).map(failures).sum()
    }
}

/// By the certified method; of cylinders and cones, which have none, by the judge.
fn touches(pair: &ShapePair) -> Option<bool> {
    if pair.is_curved() {
        return judge(pair);
    }
    let a = PosedShape { shape: &pair.a, pose: &pair.pose_a };
    let b = PosedShape { shape: &pair.b, pose: &pair.pose_b };
    Some(certified::overlap_of(a, b).0 == Verdict::Touching(()))
}

fn judge(pair: &ShapePair) -> Option<bool> {
    dcd_judge::shapes_touch((&pair.a, &pair.pose_a), (&pair.b, &pair.pose_b))
}

/// Both neighbours at each flip, judged.
pub(crate) fn judged(seed: u64, flips: Range<u64>) -> Result<Families> {
    let mut families = Families::default();
    let (mut pairs, mut of, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    for k in flips {
        let Some(flip) = shape_flip(seed, k, &touches) else {
            families.without_end += 1;
            continue;
        };
        for pair in flip {
            truth.push(judge(&pair).with_context(|| format!("flip {k} is not judged"))?);
            of.push(ShapeFamily::of(k));
            pairs.push(pair);
        }
    }
    let subject = Subject::of_shapes("shapes", &pairs, truth)?;
    for (family, each) in ShapeFamily::ALL.into_iter().zip(&mut families.each) {
        let keep = |k: u32| of[k as usize] == family;
        each.answers = of.iter().filter(|&&of| of == family).count() as u64;
        each.said = PRECISIONS.map(|precision| Account::take(precision, &subject, keep));
    }
    Ok(families)
}

pub(crate) fn table<'f>(units: impl Iterator<Item = &'f Families> + Clone) -> Result<Table> {
    let counts = ["answers", "wrong yes", "wrong no", "undecided"].map(Column::new);
    let columns = ["shapes", "precision"].map(Column::new).into_iter().chain(counts);
    let title = "Shapes of every kind at neighbouring floats";
    let mut table = Table::new("adversary-kinds", title, columns);
    for (k, family) in ShapeFamily::ALL.into_iter().enumerate() {
        for (index, precision) in PRECISIONS.into_iter().enumerate() {
            let mut said = Account::default();
            units.clone().for_each(|unit| said.add(unit.each[k].said[index]));
            let answers: u64 = units.clone().map(|unit| unit.each[k].answers).sum();
            let counts = [answers, said.wrong_yes, said.wrong_no, said.undecided].map(Cell::from);
            let names = [family.name(), precision.name()].map(Cell::from);
            table.push(names.into_iter().chain(counts))?;
        }
    }
    Ok(table)
}
