//! Where a mesh file is that a URDF or a scene names.

use super::OpenedFiles;
use crate::bytes::{PACKAGE_BYTES, read_file};
use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::path::{Path, PathBuf};

/// Folders nested deeper than this below a root are not searched for packages.
const DEEPEST: usize = 4;

/// More folders than this below a root are not searched for packages.
const MAX_FOLDERS: usize = 10_000;

/// Where mesh files are looked for.
///
/// | name | file |
/// | --- | --- |
/// | `package://NAME/FILE`, `model://NAME/FILE` | `FILE` in the package NAME: as [`Self::with_package`] says, and nowhere else; else below a root ([`Self::with_roots`]); else beside or above the naming file |
/// | `file:///FILE`, `/FILE` | `/FILE` |
/// | `file://FILE`, `FILE` | from the naming file's folder, or from one above it |
///
/// A folder is the package NAME if its `package.xml` says so, or, where it has none, if it is called so.
/// Where no package has the file, `FILE` and `NAME/FILE` are looked for beside or above the naming file.
/// The first that exists is taken. `%20` and its like are decoded in NAME, and tried as they are and
/// decoded in `FILE`, which is taken from the package's folder also where it begins with a slash.
#[derive(Clone, Debug)]
pub struct MeshPaths {
    folder: PathBuf,
    packages: Vec<(String, PathBuf)>,
    roots: Vec<PathBuf>,
    opened: OpenedFiles,
}

/// A mesh that is in none of the places where it could be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshNotFound {
    /// Its name.
    pub name: String,
    /// Where it was looked for, in order; empty for a name that says no place.
    pub looked_in: Vec<PathBuf>,
}

impl MeshPaths {
    /// Paths for the names in a file of this folder, without packages or roots.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        // The parent of a bare file name is empty: the current folder.
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let (packages, roots) = (Vec::new(), Vec::new());
        Self { folder: folder.to_path_buf(), packages, roots, opened: OpenedFiles::default() }
    }

    /// The files that were opened through these paths and their clones: each `package.xml`, and what
    /// others add.
    #[must_use]
    pub fn opened(&self) -> &OpenedFiles {
        &self.opened
    }

    /// The package of that name is this folder, and no other. The last said of a name counts.
    #[must_use]
    pub fn with_package(mut self, name: &str, folder: impl Into<PathBuf>) -> Self {
        self.packages.push((name.to_owned(), folder.into()));
        self
    }

    /// Packages are also looked for in these folders and below them.
    #[must_use]
    pub fn with_roots(mut self, roots: impl IntoIterator<Item = PathBuf>) -> Self {
        self.roots.extend(roots.into_iter().filter(|root| !root.as_os_str().is_empty()));
        self
    }

    /// [`Self::with_roots`] of the environment variable `ROS_PACKAGE_PATH`.
    #[must_use]
    pub fn with_environment(self) -> Self {
        let roots = std::env::var_os("ROS_PACKAGE_PATH").unwrap_or_default();
        self.with_roots(std::env::split_paths(&roots))
    }

    /// The file that a name means.
    ///
    /// # Errors
    /// There is none; a scheme other than `package`, `model` and `file`.
    pub fn resolve(&self, name: &str) -> Result<PathBuf, MeshNotFound> {
        let mut search = PackageSearch { looked_in: Vec::new() };
        let found = match name.split_once("://") {
            Some(("package" | "model", rest)) => self.in_package(rest, &mut search),
            Some(("file", rest)) => self.plain(rest, &mut search),
            None => self.plain(name, &mut search),
            Some(_) => None,
        };
        found.ok_or_else(|| MeshNotFound { name: name.to_owned(), looked_in: search.looked_in })
    }

    /// The folder and those above it. A relative one is made absolute, so that all are seen.
    fn above(&self) -> Vec<PathBuf> {
        let absolute = std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone());
        absolute.ancestors().map(Path::to_path_buf).collect()
    }

    fn plain(&self, name: &str, search: &mut PackageSearch) -> Option<PathBuf> {
        if Path::new(name).is_absolute() {
            return search.file(Path::new("/"), name);
        }
        self.above().iter().find_map(|above| search.file(above, name))
    }

    fn in_package(&self, rest: &str, search: &mut PackageSearch) -> Option<PathBuf> {
        let (package, file) = rest.split_once('/')?;
        let package = percent_decoded(package);
        // A slash at its front, once decoded, is of no folder beside.
        let package = package.trim_start_matches('/');
        if let Some((_, folder)) = self.packages.iter().rev().find(|(name, _)| name == package) {
            return search.file(folder, file);
        }
        let below_roots = || self.roots.iter().flat_map(|root| self.packages_below(root, package));
        if let Some(found) = below_roots().find_map(|folder| search.file(&folder, file)) {
            return Some(found);
        }
        let above = self.above();
        let mut packages = above.iter().flat_map(|folder| self.packages_beside(folder, package));
        let found = packages.find_map(|folder| search.file(&folder, file));
        let plain = || above.iter().flat_map(|folder| [folder.clone(), folder.join(package)]);
        found.or_else(|| plain().find_map(|folder| search.file(&folder, file)))
    }

    /// `folder` and those in it that are the package: one called so first.
    fn packages_beside(&self, folder: &Path, package: &str) -> Vec<PathBuf> {
        let called = folder.join(package);
        let inside = subfolders(folder).into_iter().filter(|inside| *inside != called);
        let all = [called.clone(), folder.to_path_buf()].into_iter().chain(inside);
        all.filter(|folder| is_package(folder, self.package_name(folder).as_deref(), package))
            .collect()
    }

    /// The folders below a root, itself among them, that are the package, nearest first. There are no
    /// packages inside of packages.
    fn packages_below(&self, root: &Path, package: &str) -> Vec<PathBuf> {
        let mut found = Vec::new();
        let mut ahead = VecDeque::from([(root.to_path_buf(), 0)]);
        let mut seen = 0;
        while let Some((folder, depth)) = ahead.pop_front() {
            seen += 1;
            let name = self.package_name(&folder);
            if is_package(&folder, name.as_deref(), package) {
                found.push(folder.clone());
            }
            if name.is_none() && depth < DEEPEST && seen + ahead.len() < MAX_FOLDERS {
                ahead.extend(subfolders(&folder).into_iter().map(|folder| (folder, depth + 1)));
            }
        }
        found
    }

    /// The name in a folder's `package.xml`, if it has one.
    fn package_name(&self, folder: &Path) -> Option<String> {
        let path = folder.join("package.xml");
        let bytes = read_file(&path, PACKAGE_BYTES).ok()?;
        self.opened.add(&path);
        let document = roxmltree::Document::parse(std::str::from_utf8(&bytes).ok()?).ok()?;
        let name = document.root_element().children().find(|child| child.has_tag_name("name"))?;
        Some(name.text()?.trim().to_owned())
    }
}

/// A search and the places where it has been.
struct PackageSearch {
    looked_in: Vec<PathBuf>,
}

impl PackageSearch {
    /// The file of that name from a folder, if it is there. Slashes before the name do not lead out of the folder.
    fn file(&mut self, folder: &Path, name: &str) -> Option<PathBuf> {
        let from_folder = |name: &str| folder.join(name.trim_start_matches('/'));
        let place = from_folder(name);
        if place.is_file() {
            return Some(place);
        }
        let decoded = from_folder(&percent_decoded(name));
        if decoded.is_file() {
            return Some(decoded);
        }
        if !self.looked_in.contains(&place) {
            self.looked_in.push(place);
        }
        None
    }
}

/// Whether a folder is the package, when its `package.xml` says this name.
fn is_package(folder: &Path, said: Option<&str>, package: &str) -> bool {
    said.map_or_else(|| folder.file_name() == Some(package.as_ref()), |name| name == package)
}

/// The folders in a folder, by name; none where it cannot be read.
fn subfolders(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
}

/// The text with each `%` and two hexadecimal digits as the byte that they mean.
pub(super) fn percent_decoded(text: &str) -> String {
    let digit = |byte: u8| char::from(byte).to_digit(16).map(|value| value as u8);
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let escaped = match (first, after) {
            (b'%', &[high, low, ..]) => digit(high).zip(digit(low)),
            _ => None,
        };
        bytes.push(escaped.map_or(first, |(high, low)| high << 4 | low));
        rest = if escaped.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).unwrap_or_else(|_| text.to_owned())
}

impl fmt::Display for MeshNotFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.looked_in.is_empty() {
            return write!(
                f,
                "mesh {:?} names no file: package://NAME/FILE, model://NAME/FILE, file://FILE and \
                 paths do",
                self.name
            );
        }
        write!(f, "mesh {:?} is not found; looked for", self.name)?;
        for (k, place) in self.looked_in.iter().enumerate() {
            write!(f, "{} {}", if k == 0 { "" } else { "," }, crate::shown(place))?;
        }
        if self.name.starts_with("package://") || self.name.starts_with("model://") {
            write!(f, " (--package NAME=DIR or ROS_PACKAGE_PATH say where a package is)")?;
        }
        Ok(())
    }
}

impl std::error::Error for MeshNotFound {}

#[cfg(test)]
mod tests;
