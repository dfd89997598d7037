//! Many scenes and requests, as MotionBenchMaker packs them.

use super::archive::{Bounds, each_file};
use super::{PlanningScene, Request, RobotError};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

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
/// An archive that cannot be read, holds no problem, or unpacks to more than [`LARGEST_ENTRY`] bytes a
/// file or [`LARGEST_ARCHIVE`] in all; a scene without its request or a request without its scene, or two
/// of one name; one in no folder, or a link of such a name; what is wrong in one of them, by its path in the archive.
///
/// [`LARGEST_ENTRY`]: super::LARGEST_ENTRY
/// [`LARGEST_ARCHIVE`]: super::LARGEST_ARCHIVE
pub fn read_problems(archive: &Path) -> Result<Vec<Problem>, RobotError> {
    let file = File::open(archive).map_err(RobotError::io(archive))?;
    problems_in(BufReader::new(file), archive)
}

/// [`read_problems`] from any bytes; `archive` is what messages call them.
///
/// # Errors
/// Those of [`read_problems`].
pub fn problems_in(packed: impl Read, archive: &Path) -> Result<Vec<Problem>, RobotError> {
    let mut halves: BTreeMap<(String, String), Halves> = BTreeMap::new();
    let wanted = |path: &Path| kind_of(path).is_some();
    each_file(packed, Bounds::default(), wanted, |path, text| {
        let Some((key, kind)) = kind_of(path) else { return Ok(()) };
        let inside = |error: RobotError| Stop::Robot(error.inside(archive.join(path)));
        if key.0.is_empty() {
            let (user, why) = (dcd_io::shown(path), "it is in no folder".to_owned());
            return Err(Stop::Robot(RobotError::Refused { user, why }.inside(archive)));
        }
        let slot = halves.entry(key).or_default();
        let twice = match kind {
            Kind::Scene => slot.scene.replace(PlanningScene::read(text).map_err(inside)?).is_some(),
            Kind::Request => slot.request.replace(Request::read(text).map_err(inside)?).is_some(),
        };
        if twice {
            let name = dcd_io::shown(path);
            return Err(inside(RobotError::Twice { what: "file", name }));
        }
        Ok(())
    })
    .map_err(|stop| match stop {
        Stop::Io(error) => RobotError::io(archive)(error),
        Stop::Robot(error) => error,
    })?;
    if halves.is_empty() {
        return Err(RobotError::Syntax {
            what: "archive of problems",
            place: archive.to_path_buf(),
            error: "it holds no sceneNUMBER.yaml and requestNUMBER.yaml in a folder".to_owned(),
        });
    }
    let mut problems = Vec::with_capacity(halves.len());
    for ((set, number), Halves { scene, request }) in halves {
        match (scene, request) {
            (Some(scene), Some(request)) => {
                problems.push(Problem { set, number, scene, request });
            }
            (scene, _) => {
                let what = if scene.is_some() { "request" } else { "scene" };
                let user = dcd_io::shown(archive);
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

/// The set and number of a file that belongs to a problem, by its path. The set of what is in no folder is empty.
fn kind_of(path: &Path) -> Option<((String, String), Kind)> {
    let set = path.parent()?.file_name().unwrap_or_default().to_str()?;
    let stem = path.file_name()?.to_str()?.strip_suffix(".yaml")?;
    let (kind, number) = match (stem.strip_prefix("scene"), stem.strip_prefix("request")) {
        (Some(number), _) => (Kind::Scene, number),
        (_, Some(number)) => (Kind::Request, number),
        _ => return None,
    };
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| ((set.to_owned(), number.to_owned()), kind))
}

/// What ends the reading of an archive.
enum Stop {
    Io(std::io::Error),
    Robot(RobotError),
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_and_requests_are_distinguished_by_their_names() {
        let kind = |path: &str| kind_of(Path::new(path));
        assert!(matches!(
            kind("problems/cage/scene0012.yaml"),
            Some(((set, number), Kind::Scene)) if set == "cage" && number == "0012"
        ));
        assert!(matches!(kind("cage/request1.yaml"), Some((_, Kind::Request))));
        assert!(matches!(kind("./scene1.yaml"), Some(((set, _), Kind::Scene)) if set.is_empty()));
        for other in ["scene.yaml", "cage/scene.yaml", "cage/scene1.txt", "cage/config.yaml"] {
            assert!(kind(other).is_none(), "{other}");
        }
    }

    /// An archive of these files.
    fn archive(files: &[(&str, &str)]) -> Vec<u8> {
        let mut tar = tar::Builder::new(Vec::new());
        for (name, text) in files {
            let mut header = tar::Header::new_gnu();
            header.set_size(text.len() as u64);
            tar.append_data(&mut header, name, text.as_bytes()).unwrap();
        }
        let tar = tar.into_inner().unwrap();
        let mut packed = Vec::new();
        let mut encoder = bzip2::read::BzEncoder::new(&tar[..], bzip2::Compression::fast());
        encoder.read_to_end(&mut packed).unwrap();
        packed
    }

    fn refusal(files: &[(&str, &str)]) -> String {
        problems_in(&archive(files)[..], Path::new("x.tar.bz2")).unwrap_err().to_string()
    }

    const SCENE: &str = "world: {collision_objects: [{id: can, primitives: [{type: sphere, \
        dimensions: [1]}], primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]}]}";
    const REQUEST: &str = "start_state: {joint_state: {name: [], position: []}}";

    #[test]
    fn an_archive_without_problems_is_refused() {
        for files in [&[][..], &[("readme.txt", "no scene")], &[("a/scene.yaml", SCENE)]] {
            let refused = refusal(files);
            assert!(refused.starts_with("x.tar.bz2: no archive of problems"), "{refused}");
        }
    }

    #[test]
    fn a_problem_needs_its_scene_and_its_request_once() {
        let (scene, request) = (("a/scene1.yaml", SCENE), ("a/request1.yaml", REQUEST));
        let both = archive(&[request, scene]);
        assert_eq!(problems_in(&both[..], Path::new("x")).unwrap().len(), 1);
        assert!(refusal(&[scene]).contains("no request \"a/1\""));
        assert!(refusal(&[request]).contains("no scene \"a/1\""));
        assert!(refusal(&[scene, request, scene]).contains("two of file \"a/scene1.yaml\""));
        let plain = refusal(&[scene, request, ("request1.yaml", REQUEST)]);
        assert_eq!(plain, "x.tar.bz2: request1.yaml: it is in no folder");
    }

    #[test]
    fn an_archive_that_is_none_is_refused_with_its_path() {
        let refused = read_problems(Path::new("Cargo.toml")).unwrap_err();
        assert!(refused.to_string().starts_with("Cargo.toml: "), "{refused}");
    }
}
