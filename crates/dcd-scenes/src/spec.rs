//! Scenes by name.

use crate::recipe::{BOX, Body, Recipe, SPHERE, Spread};
use crate::{BuildError, GameHulls, GameSize, RawScene, RawShare, ReadError, data, load_clouds};
use dcd_geom::Scene;
use dcd_io::run::{self, Run};
use glam::DVec3;
use std::fmt;
use std::ops::Range;

/// A seeded scene: which, of how many objects, from which seed.
///
/// The same on every machine. With the same seed, a scene of fewer objects has the same shapes and
/// rotations as the first of a larger one; the same translations too, in `paper`, `clustered`,
/// `bricks` and `identical`, else the same up to the scale that keeps the density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSpec {
    name: &'static str,
    family: Family,
    /// How many objects.
    pub objects: usize,
    /// The seed. `bricks` has nothing random in it.
    pub seed: u64,
}

/// Where the objects come from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Family {
    /// Drawn from the seed alone.
    Drawn(Recipe),
    /// Hulls of a game's clouds, read from a file.
    GameHulls(GameHulls),
}

impl SceneSpec {
    /// The scene of the paper's measurements: hulls of 50 to 99 points in the unit cube, in a cube
    /// of half-width 3 whatever their number. 10,000 objects.
    pub fn paper() -> Self {
        let spread = Spread::Fixed(3.0);
        Self::new("paper", Recipe::Scattered { body: Body::PAPER, spread }, 10_000)
    }

    /// The paper's hulls with about 4 candidates an object, 3 from 100,000 on. 10,000 objects.
    pub fn sparse() -> Self {
        let spread = Spread::Dense(&[(10_000, 12.0), (100_000, 30.0), (1_000_000, 65.0)]);
        Self::new("sparse", Recipe::Scattered { body: Body::PAPER, spread }, 10_000)
    }

    /// The paper's hulls stretched 0.2 × 0.2 × 4. 10,000 objects.
    pub fn needles() -> Self {
        Self::stretched("needles", DVec3::new(0.2, 0.2, 4.0))
    }

    /// The paper's hulls stretched 2 × 2 × 0.05. 10,000 objects.
    pub fn plates() -> Self {
        Self::stretched("plates", DVec3::new(2.0, 2.0, 0.05))
    }

    /// Cuboids with edges uniform in 0.3 … 1.5. 20,000 objects.
    pub fn boxes() -> Self {
        let spread = Spread::Dense(&[(20_000, 13.0)]);
        Self::new("boxes", Recipe::Scattered { body: BOX, spread }, 20_000)
    }

    /// Spheres of radius 0.25 … 0.5 with about 3 candidates each. 100,000 objects.
    pub fn spheres() -> Self {
        let spread = Spread::Dense(&[(100_000, 20.0)]);
        Self::new("spheres", Recipe::Scattered { body: SPHERE, spread }, 100_000)
    }

    /// The cuboids of [`SceneSpec::boxes`], turned alike but sparser: about 4 candidates each.
    /// 100,000 objects.
    pub fn cuboids() -> Self {
        let recipe = Recipe::Scattered { body: BOX, spread: CUBOIDS };
        Self::new("cuboids", recipe, 100_000)
    }

    /// The same, each as the hull of its eight corners: what a closed form is measured against.
    /// 100,000 objects.
    pub fn cuboids_as_hulls() -> Self {
        let body = Body::BoxAsHull { low: 0.3, high: 1.5 };
        let recipe = Recipe::Scattered { body, spread: CUBOIDS };
        Self::new("cuboids-as-hulls", recipe, 100_000)
    }

    /// A quarter each of spheres, cuboids, capsules and the paper's hulls, with about 3 candidates
    /// each. 100,000 objects.
    pub fn mixed() -> Self {
        let spread = Spread::Dense(&[(100_000, 27.0)]);
        Self::new("mixed", Recipe::Scattered { body: Body::Mixed, spread }, 100_000)
    }

    /// The paper's hulls at sizes 10^u, u uniform in −2 … 0.7, and as object 0 one slab of
    /// 48 × 48 × 0.5 through the middle. 10,000 objects, the slab among them.
    pub fn big_and_small() -> Self {
        let body = Body::Sized { low: -2.0, high: 0.7, slab: DVec3::new(48.0, 48.0, 0.5) };
        Self::new("big-and-small", Recipe::Scattered { body, spread: TWELVE }, 10_000)
    }

    /// The paper's hulls in clusters of 100 of half-width 1.5, the clusters' middles in a cube of
    /// half-width 30. 10,000 objects.
    pub fn clustered() -> Self {
        let spread = Spread::Clusters { cluster: 1.5, whole: 30.0 };
        Self::new("clustered", Recipe::Scattered { body: Body::PAPER, spread }, 10_000)
    }

    /// The clouds of `data/hulls`, which must be there. 10,000 objects.
    pub fn game_hulls(game: GameHulls) -> Self {
        let name = match game.size {
            GameSize::Unit => "game-hulls",
            GameSize::True => "game-hulls-true",
        };
        Self { name, family: Family::GameHulls(game), objects: 10_000, seed: 1 }
    }

    /// Unit cubes, aligned, in layers of 20 × 20 at this pitch, metres. 8,000 objects.
    pub fn bricks(pitch: f64) -> Self {
        Self::new("bricks", Recipe::Bricks { pitch }, 8_000)
    }

    /// The paper's first hull, all at one place. 500 objects.
    pub fn identical() -> Self {
        Self::new("identical", Recipe::Identical, 500)
    }

    /// Every scene with a name, at its usual number of objects and seed 1.
    pub fn all() -> Vec<Self> {
        let game = |size| Self::game_hulls(GameHulls { size, candidates: 4.0 });
        vec![
            Self::paper(),
            Self::sparse(),
            Self::needles(),
            Self::plates(),
            Self::boxes(),
            Self::spheres(),
            Self::cuboids(),
            Self::cuboids_as_hulls(),
            Self::mixed(),
            Self::big_and_small(),
            Self::clustered(),
            game(GameSize::Unit),
            game(GameSize::True),
            Self::bricks(1.0),
            Self { name: "bricks-overlapping", ..Self::bricks(1.0 - 1e-3) },
            Self { name: "bricks-apart", ..Self::bricks(1.0 + 1e-9) },
            Self::identical(),
        ]
    }

    /// The scene of that name among [`SceneSpec::all`].
    ///
    /// # Errors
    /// There is none; the error lists those that there are.
    pub fn parse(name: &str) -> Result<Self, SpecError> {
        let found = Self::all().into_iter().find(|spec| spec.name == name);
        found.ok_or_else(|| SpecError::Unknown { name: name.to_owned() })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Another number of objects.
    pub fn with_objects(self, objects: usize) -> Self {
        Self { objects, ..self }
    }

    /// Another seed.
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// How many bytes a step of the scene takes at least, its pairs not counted: so that a number of
    /// objects that no memory holds is refused before allocation.
    pub fn least_bytes(&self) -> f64 {
        let an_object = match self.family {
            Family::GameHulls(_) => 400.0,
            Family::Drawn(recipe) => recipe.least_bytes(),
        };
        an_object * self.objects as f64
    }

    /// Draws the shapes and poses. Costs some ten microseconds a hull.
    ///
    /// # Errors
    /// More objects than a u32 counts; a density or pitch that is not positive and finite; files
    /// that are needed and absent or broken.
    pub fn raw(&self) -> Result<RawScene, SpecError> {
        self.raw_by(&run::in_order)
    }

    /// [`SceneSpec::raw`], the same by any [`Run`]: a task draws an object.
    ///
    /// # Errors
    /// Those of [`SceneSpec::raw`].
    pub fn raw_by(&self, run: &Run<'_>) -> Result<RawScene, SpecError> {
        self.share_by(0..self.objects, run).map(|share| share.scene)
    }

    /// Draws some of the objects and the shapes that they have, the same as in the whole. Of clouds, which are
    /// spread by all their sizes, all are drawn and the others dropped.
    ///
    /// # Errors
    /// Those of [`SceneSpec::raw`].
    pub fn share_by(&self, range: Range<usize>, run: &Run<'_>) -> Result<RawShare, SpecError> {
        if u32::try_from(self.objects).is_err() {
            return Err(SpecError::TooManyObjects { objects: self.objects });
        }
        let range = range.start.min(self.objects)..range.end.min(self.objects);
        match self.family {
            Family::GameHulls(game) => {
                check_positive("number of candidates", game.candidates)?;
                let path = data::file("hulls/convex_hulls.bin").ok_or(SpecError::NoData)?;
                let clouds = load_clouds(&path).map_err(SpecError::Read)?;
                Ok(game.share_by(&clouds, range, (self.objects, self.seed), run))
            }
            Family::Drawn(recipe) => {
                if let Recipe::Bricks { pitch } = recipe {
                    check_positive("pitch", pitch)?;
                }
                Ok(recipe.share(range, (self.objects, self.seed), run))
            }
        }
    }

    /// Draws the scene and checks it.
    ///
    /// # Errors
    /// Those of [`SceneSpec::raw`], and a scene out of range.
    pub fn scene(&self) -> Result<Scene, SpecError> {
        self.scene_by(&run::in_order)
    }

    /// [`SceneSpec::scene`], the same by any [`Run`], which is given the hulls first and then the
    /// shapes.
    ///
    /// # Errors
    /// Those of [`SceneSpec::scene`].
    pub fn scene_by(&self, run: &Run<'_>) -> Result<Scene, SpecError> {
        self.raw_by(run)?.into_scene_by(run).map_err(SpecError::Build)
    }

    fn new(name: &'static str, recipe: Recipe, objects: usize) -> Self {
        Self { name, family: Family::Drawn(recipe), objects, seed: 1 }
    }

    fn stretched(name: &'static str, stretch: DVec3) -> Self {
        let body = Body::Hull { stretch };
        Self::new(name, Recipe::Scattered { body, spread: TWELVE }, 10_000)
    }
}

/// 10,000 objects in a cube of half-width 12.
const TWELVE: Spread = Spread::Dense(&[(10_000, 12.0)]);
/// 100,000 cuboids in a cube of half-width 31.
const CUBOIDS: Spread = Spread::Dense(&[(100_000, 31.0)]);

fn check_positive(what: &'static str, value: f64) -> Result<(), SpecError> {
    // Written so that NaN is refused.
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(SpecError::Parameter { what, value })
    }
}

/// Why a seeded scene could not be made.
#[derive(Debug)]
#[non_exhaustive]
pub enum SpecError {
    /// No scene has that name.
    Unknown {
        /// The requested name.
        name: String,
    },
    /// More objects than a u32 counts.
    TooManyObjects {
        /// How many.
        objects: usize,
    },
    /// A parameter is not positive and finite.
    Parameter {
        /// Which: "pitch", "number of candidates".
        what: &'static str,
        /// What was given.
        value: f64,
    },
    /// The scene is made from files, and there is no data folder (see [`data::folder`]).
    NoData,
    /// A file that the scene is made from could not be read.
    Read(ReadError),
    /// The material makes no scene.
    Build(BuildError),
}

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown { name } => {
                write!(f, "no scene is named {name:?}; there are")?;
                SceneSpec::all().iter().try_for_each(|spec| write!(f, " {}", spec.name))
            }
            Self::TooManyObjects { objects } => {
                write!(f, "{objects} objects are more than a u32 counts")
            }
            Self::Parameter { what, value } => {
                write!(f, "the {what} is {value:e}, not positive and finite")
            }
            Self::NoData => write!(
                f,
                "the scene needs hulls/convex_hulls.bin in the data folder, which is absent; \
                 DCD_DATA names the folder"
            ),
            Self::Read(error) => error.fmt(f),
            Self::Build(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SpecError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_parse_back() {
        let all = SceneSpec::all();
        for spec in &all {
            assert_eq!(SceneSpec::parse(spec.name()).unwrap(), *spec);
        }
        let mut names: Vec<_> = all.iter().map(SceneSpec::name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }

    #[test]
    fn shares_are_the_whole() {
        for spec in SceneSpec::all() {
            if spec.name.starts_with("game") && data::folder().is_none() {
                eprintln!("skipped: {}, since there is no data folder", spec.name);
                continue;
            }
            let spec = spec.with_objects(70);
            let whole = spec.raw().unwrap();
            let mut placed = Vec::new();
            for range in [0..0, 0..13, 13..69, 69..100] {
                let share = spec.share_by(range, &run::in_order).unwrap();
                assert_eq!(share.first, placed.len());
                assert_eq!(share.shape_names.len(), share.scene.shapes.len());
                for (name, shape) in share.shape_names.iter().zip(&share.scene.shapes) {
                    assert_eq!(*shape, whole.shapes[*name as usize]);
                }
                placed.extend(share.scene.objects.iter().map(|object| crate::RawObject {
                    shape: share.shape_names[object.shape as usize] as u32,
                    ..*object
                }));
            }
            assert_eq!(placed, whole.objects, "{}", spec.name);
        }
    }

    #[test]
    fn an_unknown_name_is_refused_with_those_there_are() {
        let refused = SceneSpec::parse("papier").unwrap_err().to_string();
        assert!(refused.contains("\"papier\"") && refused.contains("big-and-small"), "{refused}");
    }

    #[test]
    fn a_count_past_u32_is_refused_before_anything_is_made() {
        let refused = SceneSpec::paper().with_objects(u32::MAX as usize + 1).raw().unwrap_err();
        assert!(matches!(refused, SpecError::TooManyObjects { objects: 0x1_0000_0000 }));
    }

    #[test]
    fn a_bad_pitch_or_density_is_refused_with_its_value() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let pitch = SceneSpec::bricks(value).raw().unwrap_err();
            assert!(matches!(pitch, SpecError::Parameter { what: "pitch", .. }));
            let game = GameHulls { size: GameSize::True, candidates: value };
            let density = SceneSpec::game_hulls(game).raw().unwrap_err();
            assert!(matches!(density, SpecError::Parameter { .. }));
        }
    }

    #[test]
    fn zero_objects_and_one_are_legal() {
        for spec in SceneSpec::all().iter().filter(|s| !s.name.starts_with("game")) {
            assert_eq!(spec.with_objects(0).scene().unwrap().len(), 0);
            assert_eq!(spec.with_objects(1).scene().unwrap().len(), 1);
        }
    }
}
