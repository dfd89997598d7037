//! Many scenes and requests, as MotionBenchMaker packs them.

use super::{PlanningScene, Request, RobotError};
use bzip2::read::BzDecoder;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

/// A scene and a request that belong together.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The folder in the archive: what kind of scene it is.
    pub set: String,
    /// The number that both files' names end in.
    pub number: String,
    /// `sceneNUMBER.yaml`.
    pub scene: PlanningScene,
    /// `requestNUMBER.yaml`.
    pub request: Request,
}

/// Reads every pair of `sceneNUMBER.yaml` and `requestNUMBER.yaml` in a folder of an archive
/// (tar, packed by bzip2), in the order of their folders and numbers.
///
/// # Errors
/// An archive that cannot be read, or without a problem; a scene without its request or a request without its scene; what
/// is wrong in one of them, by its path in the archive.
pub fn read_problems(archive: &Path) -> Result<Vec<Problem>, RobotError> {
    let texts = unpack(archive).map_err(RobotError::io(archive))?;
    let mut halves: BTreeMap<(String, String), Halves> = BTreeMap::new();
    for (path, text) in texts {
        let Some((key, kind)) = kind_of(&path) else { continue };
        let slot = halves.entry(key).or_default();
        let inside = |error: RobotError| error.inside(archive.join(&path));
        match kind {
            Kind::Scene => slot.scene = Some(PlanningScene::read(&text).map_err(inside)?),
            Kind::Request => slot.request = Some(Request::read(&text).map_err(inside)?),
        }
    }
    if halves.is_empty() {
        let (user, why) = (archive.display().to_string(), "there is no problem in it".to_owned());
        return Err(RobotError::Refused { user, why });
    }
    let mut problems = Vec::with_capacity(halves.len());
    for ((set, number), Halves { scene, request }) in halves {
        match (scene, request) {
            (Some(scene), Some(request)) => {
                problems.push(Problem { set, number, scene, request });
            }
            (scene, _) => {
                let what = if scene.is_some() { "request" } else { "scene" };
                let user = archive.display().to_string();
                return Err(RobotError::Unknown { what, name: format!("{set}/{number}"), user });
            }
        }
    }
    Ok(problems)
}

#[derive(Default)]
struct Halves {
    scene: Option<PlanningScene>,
    request: Option<Request>,
}

enum Kind {
    Scene,
    Request,
}

/// The set and number of a file that belongs to a problem, by its path.
fn kind_of(path: &Path) -> Option<((String, String), Kind)> {
    let set = path.parent()?.file_name()?.to_str()?;
    let stem = path.file_name()?.to_str()?.strip_suffix(".yaml")?;
    let (kind, number) = match (stem.strip_prefix("scene"), stem.strip_prefix("request")) {
        (Some(number), _) => (Kind::Scene, number),
        (_, Some(number)) => (Kind::Request, number),
        _ => return None,
    };
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| ((set.to_owned(), number.to_owned()), kind))
}

/// The archive's files as texts.
fn unpack(archive: &Path) -> std::io::Result<Vec<(PathBuf, String)>> {
    let file = BufReader::new(File::open(archive)?);
    let mut files = Vec::new();
    for entry in tar::Archive::new(BzDecoder::new(file)).entries()? {
        let mut entry = entry?;
        if entry.header().entry_type().is_file() {
            let path = entry.path()?.into_owned();
            let mut text = String::new();
            entry.read_to_string(&mut text)?;
            files.push((path, text));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_and_requests_are_told_by_their_names() {
        let kind = |path: &str| kind_of(Path::new(path));
        assert!(matches!(
            kind("problems/cage/scene0012.yaml"),
            Some(((set, number), Kind::Scene)) if set == "cage" && number == "0012"
        ));
        assert!(matches!(kind("cage/request1.yaml"), Some((_, Kind::Request))));
        for other in ["scene1.yaml", "cage/scene.yaml", "cage/scene1.txt", "cage/config.yaml"] {
            assert!(kind(other).is_none(), "{other}");
        }
    }

    #[test]
    fn an_archive_that_is_none_is_refused_with_its_path() {
        let refused = read_problems(Path::new("Cargo.toml")).unwrap_err();
        assert!(refused.to_string().starts_with("Cargo.toml: "), "{refused}");
    }
}
