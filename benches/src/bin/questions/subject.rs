//! The scenes of a report.

use anyhow::Result;
use dcd_benches::{FallingPile, Options, draw};
use dcd_geom::Scene;
use dcd_scenes::SceneSpec;

use crate::contest::Kind;
use crate::scattered::Scattered;

/// The seeded scenes, each with its objects in full and with --quick: those whose shapes Parry has too.
const SCENES: [(&str, usize, usize); 11] = [
    ("paper", 3000, 150),
    ("sparse", 10_000, 400),
    ("boxes", 10_000, 400),
    ("cuboids", 10_000, 400),
    ("spheres", 10_000, 1000),
    ("mixed", 10_000, 400),
    ("plates", 5000, 200),
    ("needles", 5000, 200),
    ("clustered", 5000, 200),
    ("game-hulls", 5000, 200),
    ("bricks", 4000, 200),
];

/// Hulls that have come to rest on a slab and on each other.
const PILE: (&str, usize, usize) = ("pile", 2000, 100);

/// Of every kind of [`Scattered`].
const SCATTERED: (&str, usize, usize) = ("", 2000, 100);

/// A mesh under so many bodies.
const TERRAIN: (&str, usize, usize) = ("terrain", 2000, 200);

/// How long a pile falls, frames: three seconds.
const FALLING: usize = 180;

/// A scene, by what draws it.
pub(crate) enum Subject {
    Seeded(SceneSpec),
    Pile { hulls: usize, seed: u64 },
    Terrain { bodies: usize, seed: u64 },
    Scattered { of: Scattered, objects: usize, seed: u64 },
}

impl Subject {
    /// All, and a sentence for each that cannot be had.
    pub(crate) fn all(options: &Options) -> (Vec<Self>, Vec<String>) {
        let (mut found, mut absent) = (Vec::new(), Vec::new());
        for sized in SCENES {
            let spec = Self::seeded(sized.0, objects(sized, options), options.seed);
            // For one object, a scene says at once whether its files are there.
            match spec.and_then(|spec| spec.with_objects(1).raw().map(|_| spec)) {
                Ok(spec) => found.push(Self::Seeded(spec)),
                Err(error) => absent.push(format!("`{}` is left out: {error}", sized.0)),
            }
        }
        let seed = options.seed;
        found.push(Self::Pile { hulls: objects(PILE, options), seed });
        found.push(Self::Terrain { bodies: objects(TERRAIN, options), seed });
        let objects = objects(SCATTERED, options);
        found.extend(Scattered::ALL.map(|of| Self::Scattered { of, objects, seed }));
        (found, absent)
    }

    /// The one of that name, with that many objects or its usual number.
    pub(crate) fn named(name: &str, count: Option<usize>, options: &Options) -> Result<Self> {
        let seed = options.seed;
        let or_usual = |sized| count.unwrap_or(objects(sized, options));
        if let Some(of) = Scattered::ALL.into_iter().find(|of| of.name() == name) {
            return Ok(Self::Scattered { of, objects: or_usual(SCATTERED), seed });
        }
        Ok(match name {
            _ if name == PILE.0 => Self::Pile { hulls: or_usual(PILE), seed },
            _ if name == TERRAIN.0 => Self::Terrain { bodies: or_usual(TERRAIN), seed },
            _ => {
                let usual = SceneSpec::parse(name)?.objects;
                Self::Seeded(Self::seeded(name, count.unwrap_or(usual), seed)?)
            }
        })
    }

    fn seeded(name: &str, objects: usize, seed: u64) -> Result<SceneSpec, dcd_scenes::SpecError> {
        Ok(SceneSpec::parse(name)?.with_objects(objects).with_seed(seed))
    }

    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Seeded(spec) => spec.name(),
            Self::Pile { .. } => PILE.0,
            Self::Terrain { .. } => TERRAIN.0,
            Self::Scattered { of, .. } => of.name(),
        }
    }

    /// What it is measured under.
    pub(crate) fn key(&self) -> String {
        let objects = match self {
            Self::Seeded(spec) => spec.objects,
            Self::Pile { hulls, .. } => *hulls,
            Self::Terrain { bodies, .. } => *bodies,
            Self::Scattered { objects, .. } => *objects,
        };
        format!("{}/N={objects}", self.name())
    }

    /// What is asked of it.
    pub(crate) fn kinds(&self) -> &'static [Kind] {
        match self {
            Self::Terrain { .. } => &Kind::TOUCHING,
            _ => &Kind::ALL,
        }
    }

    pub(crate) fn scene(&self) -> Result<Scene> {
        Ok(match *self {
            Self::Seeded(spec) => draw(&spec)?,
            Self::Pile { hulls, seed } => FallingPile::after(FALLING, hulls, seed)?.scene().clone(),
            Self::Terrain { bodies, seed } => dcd_scenes::terrain(bodies, seed)?,
            Self::Scattered { of, objects, seed } => of.scene(objects, seed)?,
        })
    }
}

fn objects((_, full, quick): (&str, usize, usize), options: &Options) -> usize {
    if options.quick { quick } else { full }
}
