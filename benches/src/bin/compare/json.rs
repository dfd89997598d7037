//! What was compared as JSON, an object for each scene and number of threads.

use dcd_gjk::Method;
use serde_json::{Map, Value, json};

use crate::judge::Account;
use crate::race::{Beside, Comparison, Race};
use crate::rivals::PARTS;

/// One JSON object for each number of threads.
pub(crate) fn objects(comparison: &Comparison) -> Vec<Value> {
    let object = |&threads: &usize| {
        let judged = &comparison.judged;
        let race = comparison.races.iter().find(|race| race.threads == threads);
        let wrong = |account: &Account| json!({ "false_contacts": account.false_contacts, "missed": account.missed });
        json!({
            "scene": comparison.scene,
            "objects": comparison.objects,
            "seed": comparison.seed,
            "threads": threads,
            "query": comparison.query,
            "candidates": {
                "ours": judged.ours.candidates,
                "parry_f32": judged.parry_f32.candidates,
                "parry_f64": judged.parry_f64.candidates,
            },
            "contacts": judged.contacts,
            "digest": comparison.digest,
            "wrong": {
                "ours": wrong(&judged.ours),
                "parry_f32": wrong(&judged.parry_f32),
                "parry_f64": wrong(&judged.parry_f64),
            },
            "undecided": {
                "ours": judged.ours.undecided,
                "parry_f32": judged.parry_f32.undecided,
                "parry_f64": judged.parry_f64.undecided,
            },
            "refused": {
                "parry_f32": judged.parry_f32.refused,
                "parry_f64": judged.parry_f64.refused,
            },
            "settled_exactly": judged.judged_exactly,
            "differences": judged.differences,
            "rounds": race.map(|race| race.rounds),
            "ratio": race.map(|race| by_part(race, |beside| json!(beside.ratio))),
            "ms": race.map(|race| by_part(race, |beside| json!({
                "ours": beside.ours, "parry": beside.rival,
            }))),
            "ratio_range": race.map(|race| by_part(race, |beside| json!([beside.least, beside.most]))),
            "settled": decided(comparison),
            "brute_force": race.and_then(|race| race.brute_force),
            "every_pair": race.and_then(|race| race.every_pair),
            "narrower": race.map(|race| &race.narrower),
        })
    };
    comparison.threads.iter().map(object).collect()
}

/// How many candidates each method decided, under its name.
fn decided(comparison: &Comparison) -> Map<String, Value> {
    let methods = Method::ALL.iter().map(|method| format!("{method:?}"));
    methods.zip(&comparison.decided).map(|(method, &count)| (method, json!(count))).collect()
}

/// A value for each stage, under its name.
fn by_part(race: &Race, value: impl Fn(&Beside) -> Value) -> Map<String, Value> {
    PARTS
        .into_iter()
        .zip(&race.parts)
        .map(|(part, beside)| (part.to_owned(), value(beside)))
        .collect()
}
