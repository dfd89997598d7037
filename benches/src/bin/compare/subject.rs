//! Which scenes are compared.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use dcd_benches::Effort;
use dcd_geom::Scene;
use dcd_io::load_hull_scene;
use dcd_scenes::SceneSpec;

/// A scene to be made.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Subject {
    /// By name, number of objects and seed.
    Named(SceneSpec),
    /// A raw hull scene.
    File(PathBuf),
}

/// Objects of the scenes that are compared at several sizes.
const PAPER_SIZES: [usize; 4] = [10, 100, 1_000, 10_000];
const SPARSE_SIZES: [usize; 3] = [10_000, 100_000, 1_000_000];
/// No scene of a quick run over all is larger.
const QUICK_SIZE: usize = 1_000;

/// What stands for every named scene.
pub(crate) const ALL: &str = "all";

impl Subject {
    /// A scene's name, else a file's path.
    pub(crate) fn parse(scene: &str, objects: Option<usize>, seed: u64) -> Result<Self> {
        let path = Path::new(scene);
        match SceneSpec::parse(scene) {
            Ok(spec) => {
                let objects = objects.unwrap_or(spec.objects);
                Ok(Self::Named(spec.with_objects(objects).with_seed(seed)))
            }
            Err(_) if path.is_file() && objects.is_some() => {
                bail!("{scene} has a number of objects of its own: --n does not go with a file")
            }
            Err(_) if path.is_file() => Ok(Self::File(path.to_owned())),
            Err(unknown) => Err(unknown).context("neither a file nor a scene"),
        }
    }

    /// Its name, or its path.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Named(spec) => spec.name().to_owned(),
            Self::File(path) => path.display().to_string(),
        }
    }

    /// How many objects a named scene has.
    pub(crate) fn objects(&self) -> Option<usize> {
        match self {
            Self::Named(spec) => Some(spec.objects),
            Self::File(_) => None,
        }
    }

    /// The seed of a drawn scene.
    pub(crate) fn seed(&self) -> Option<u64> {
        match self {
            Self::Named(spec) => Some(spec.seed),
            Self::File(_) => None,
        }
    }

    /// Its key, unique within a run.
    pub(crate) fn key(&self) -> String {
        match self {
            Self::Named(spec) => format!("{}/N={}", spec.name(), spec.objects),
            Self::File(path) => path.display().to_string(),
        }
    }

    /// Draws or reads it.
    pub(crate) fn scene(&self) -> Result<Scene> {
        Ok(match self {
            Self::Named(spec) => dcd_benches::draw(spec)?,
            Self::File(path) => {
                // Its message names the path and the cause; its sources would name them again.
                let raw = load_hull_scene(path).map_err(|error| anyhow!("{error}"))?;
                raw.into_scene().with_context(|| path.display().to_string())?
            }
        })
    }
}

/// Every named scene, in each of its sizes.
pub(crate) fn all(seed: u64, effort: Effort) -> Vec<Subject> {
    let mut subjects = Vec::new();
    for spec in SceneSpec::all() {
        let mut sizes = match spec.name() {
            "paper" => PAPER_SIZES.to_vec(),
            "sparse" => SPARSE_SIZES.to_vec(),
            _ => vec![spec.objects],
        };
        if effort == Effort::Quick {
            sizes.iter_mut().for_each(|size| *size = QUICK_SIZE.min(*size));
            sizes.dedup();
        }
        let sized = |size| Subject::Named(spec.with_objects(size).with_seed(seed));
        subjects.extend(sizes.into_iter().map(sized));
    }
    subjects
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_means_every_named_scene_each_size_once() {
        for effort in [Effort::Quick, Effort::Full] {
            let keys: Vec<String> = all(7, effort).iter().map(Subject::key).collect();
            for spec in SceneSpec::all() {
                let of_spec = format!("{}/", spec.name());
                assert!(keys.iter().any(|key| key.starts_with(&of_spec)), "{of_spec}");
            }
            let mut unique = keys.clone();
            unique.sort();
            unique.dedup();
            assert_eq!(unique.len(), keys.len());
        }
        let full: Vec<String> = all(7, Effort::Full).iter().map(Subject::key).collect();
        for size in ["paper/N=10", "paper/N=10000", "sparse/N=1000000", "identical/N=500"] {
            assert!(full.iter().any(|key| key == size), "{size}");
        }
    }

    #[test]
    fn a_named_scene_takes_number_and_seed() -> Result<()> {
        let Subject::Named(spec) = Subject::parse("sparse", Some(123), 9)? else {
            bail!("a name is no file");
        };
        assert_eq!((spec.name(), spec.objects, spec.seed), ("sparse", 123, 9));
        Ok(())
    }

    #[test]
    fn what_is_neither_name_nor_file_is_refused_with_the_names_there_are() {
        let refused = format!("{:#}", Subject::parse("papier", None, 0).unwrap_err());
        assert!(refused.contains("papier") && refused.contains("clustered"), "{refused}");
    }

    #[test]
    fn a_number_does_not_go_with_a_file() {
        // Any file will do, and this one is there.
        let here = std::env::current_exe().unwrap();
        let here = here.to_string_lossy();
        assert!(Subject::parse(&here, Some(3), 0).is_err());
        assert!(matches!(Subject::parse(&here, None, 0), Ok(Subject::File(_))));
    }
}
