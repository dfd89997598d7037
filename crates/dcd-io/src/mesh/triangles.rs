//! A triangle mesh as a file has it, whichever format that is.

use super::{MeshError, OpenedFiles, collada, gltf, obj, stl};
use crate::bytes::{MESH_BYTES, read_file};
use crate::{RawMesh, read_ply};
use glam::DVec3;
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// The triangles of a mesh file, metres.
///
/// Each triangle of the file is there, also one that is degenerate or occurs twice. Each vertex is
/// the corner of a triangle, but for OBJ and PLY, of which all vertices are kept: OBJ's that no face
/// names stand behind the others.
///
/// ```
/// use dcd_io::{MeshFormat, MeshOptions, TriangleMesh};
/// let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let mesh = TriangleMesh::read(obj, MeshFormat::Obj, &MeshOptions::default())?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// let cut = TriangleMesh::read(&obj[..30], MeshFormat::Obj, &MeshOptions::default());
/// assert!(cut.is_err()); // no triangle is left
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Where the vertices are, metres; all finite.
    pub vertices: Vec<DVec3>,
    /// Three indices into `vertices` each, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// What a user should know of how the file was read.
    pub warnings: Vec<MeshWarning>,
}

/// What a user should know of how a file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshWarning {
    /// The file's up axis is not z, so that [`UpAxis::Ros`] and [`UpAxis::File`] differ.
    UpAxis {
        /// The file's axis as it names it, or as its format has it.
        axis: &'static str,
        /// What was done.
        taken: UpAxis,
    },
    /// Points and lines, which are no surface, were passed over.
    Lines {
        /// How many elements of the file hold them.
        count: usize,
    },
    /// Lines of numbers alone, which are no statement of the format, were passed over.
    Numbers {
        /// How many.
        count: usize,
        /// The first one, counted from 1.
        first: usize,
    },
    /// Bytes behind the last triangle, too few for another, were passed over.
    Behind {
        /// How many.
        bytes: usize,
    },
    /// Animations were not played: nodes are where they stand without them.
    Animations {
        /// How many.
        count: usize,
    },
    /// Extensions that the file uses and does not require were passed over, but for those of looks.
    Extensions {
        /// Their names.
        names: Vec<String>,
    },
}

/// Which way is up in a mesh, where the file says so (COLLADA and glTF).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// As MoveIt and RViz have it: coordinates as they stand in the file, whatever it says of its
    /// up axis.
    #[default]
    Ros,
    /// As the file says: its up axis is turned to z (y, the default of both formats, by
    /// (x, y, z) to (x, −z, y)).
    File,
}

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// STL, text or binary.
    Stl,
    /// COLLADA 1.4 or 1.5.
    Collada,
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, JSON or binary.
    Gltf,
    /// Binary PLY.
    Ply,
}

/// How to read a mesh.
#[derive(Clone, Debug, Default)]
pub struct MeshOptions {
    /// Which way is up.
    pub up_axis: UpAxis,
    /// The folder of other files that the mesh names (a glTF's buffers); without it they are
    /// refused.
    pub folder: Option<PathBuf>,
    /// To which they are added when they are opened.
    pub opened: OpenedFiles,
}

impl MeshFormat {
    /// The format that a file's name says, in letters of either case.
    ///
    /// # Errors
    /// An ending that no format has.
    pub fn of(path: &Path) -> Result<Self, MeshError> {
        let ending =
            path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase());
        match ending.as_str() {
            "stl" | "stlb" => Ok(Self::Stl),
            "dae" => Ok(Self::Collada),
            "obj" => Ok(Self::Obj),
            "gltf" | "glb" => Ok(Self::Gltf),
            "ply" => Ok(Self::Ply),
            _ => Err(MeshError::UnknownFormat { ending }),
        }
    }
}

impl TriangleMesh {
    /// Reads a mesh from a file's bytes.
    ///
    /// # Errors
    /// What breaks the format's rules; what is not supported and could hide geometry; a number that
    /// is not finite; no triangle.
    pub fn read(
        bytes: &[u8],
        format: MeshFormat,
        options: &MeshOptions,
    ) -> Result<Self, MeshError> {
        let mesh = match format {
            MeshFormat::Stl => stl::read(bytes)?,
            MeshFormat::Collada => collada::read(bytes, options.up_axis)?,
            MeshFormat::Obj => obj::read(bytes)?,
            MeshFormat::Gltf => gltf::read(bytes, options)?,
            MeshFormat::Ply => read_ply(bytes).map_err(MeshError::Read)?.into(),
        };
        if mesh.triangles.is_empty() {
            return Err(MeshError::Empty { format });
        }
        if let Some(index) = mesh.vertices.iter().position(|vertex| !vertex.is_finite()) {
            let vertex = mesh.vertices[index];
            let value = vertex.to_array().into_iter().find(|x| !x.is_finite()).unwrap_or(f64::NAN);
            let what = "vertex";
            return Err(MeshError::Read(crate::ReadError::NotFinite { what, index, value }));
        }
        Ok(mesh)
    }

    /// Reads a mesh file of the format that its name says.
    ///
    /// # Errors
    /// Those of [`Self::read`] and [`MeshFormat::of`], and those of reading the file, which has at
    /// most 2 GiB, all with its path.
    pub fn load(path: &Path, up_axis: UpAxis) -> Result<Self, MeshError> {
        Self::load_with(path, up_axis, &OpenedFiles::default())
    }

    /// [`Self::load`], which adds the file and those that it names to a list.
    ///
    /// # Errors
    /// Those of [`Self::load`].
    pub fn load_with(
        path: &Path,
        up_axis: UpAxis,
        opened: &OpenedFiles,
    ) -> Result<Self, MeshError> {
        let format = MeshFormat::of(path).map_err(|error| error.inside(path))?;
        let bytes = read_file(path, MESH_BYTES).map_err(MeshError::io(path))?;
        opened.add(path);
        let folder = path.parent().map(Path::to_path_buf);
        let options = MeshOptions { up_axis, folder, opened: opened.clone() };
        Self::read(&bytes, format, &options).map_err(|error| error.inside(path))
    }

    /// Drops the vertices that are no triangle's corner; the others keep their order.
    pub(super) fn drop_loose_vertices(&mut self) {
        let mut new = vec![u32::MAX; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&corner| new[corner as usize] = 0);
        let mut kept = 0;
        for (old, new) in new.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
            *new = kept;
            self.vertices[kept as usize] = self.vertices[old];
            kept += 1;
        }
        self.vertices.truncate(kept as usize);
        self.triangles.iter_mut().flatten().for_each(|corner| *corner = new[*corner as usize]);
    }

    /// The triangles, each coordinate times that of the scale. Where the scale mirrors, the triangles'
    /// corners change their order, so that what was the front stays the front.
    #[must_use]
    pub fn scaled(mut self, scale: DVec3) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
        let mirrors = scale.to_array().iter().filter(|&&factor| factor < 0.0).count() % 2 == 1;
        if mirrors {
            self.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        self
    }
}

impl From<RawMesh> for TriangleMesh {
    fn from(mesh: RawMesh) -> Self {
        Self { vertices: mesh.vertices, triangles: mesh.faces, warnings: Vec::new() }
    }
}

impl From<TriangleMesh> for RawMesh {
    fn from(mesh: TriangleMesh) -> Self {
        Self { vertices: mesh.vertices, faces: mesh.triangles }
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stl => "STL",
            Self::Collada => "COLLADA",
            Self::Obj => "OBJ",
            Self::Gltf => "glTF",
            Self::Ply => "PLY",
        })
    }
}

impl fmt::Display for MeshWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UpAxis { axis, taken: UpAxis::Ros } => write!(
                f,
                "the file says that {axis} is up; its coordinates are taken as they are, as MoveIt \
                 and RViz take them (--up-axis file would turn them)"
            ),
            Self::UpAxis { axis, taken: UpAxis::File } => write!(
                f,
                "the file says that {axis} is up; its coordinates are turned to z up, which MoveIt \
                 and RViz do not (--up-axis ros)"
            ),
            Self::Lines { count } => {
                write!(f, "{count} elements with points or lines are passed over")
            }
            Self::Numbers { count, first } => {
                write!(f, "{count} lines of numbers alone are passed over (first: line {first})")
            }
            Self::Behind { bytes } => {
                write!(f, "{bytes} bytes behind the last triangle are passed over")
            }
            Self::Animations { count } => {
                write!(f, "{count} animations are not played; nodes are taken as they stand")
            }
            Self::Extensions { names } => {
                write!(f, "what extensions say is passed over: {}", names.join(", "))
            }
        }
    }
}

/// More triangles than this are refused, as vertices are, where a file's instances could multiply
/// what it holds: some hundred megabytes, and far below what a u32 counts.
pub(super) const MAX_TRIANGLES: usize = 1 << 22;

/// A mesh that grows by instances of others.
#[derive(Default)]
pub(super) struct Assembly {
    pub(super) mesh: TriangleMesh,
}

impl Assembly {
    /// Adds a mesh's vertices, moved, and its triangles, whose corners change their order if the
    /// motion `mirrors`; `false` if there would be too many.
    #[must_use]
    pub(super) fn add(&mut self, part: &TriangleMesh, to_whole: glam::DAffine3) -> bool {
        let whole = &mut self.mesh;
        let free = MAX_TRIANGLES - whole.triangles.len().min(MAX_TRIANGLES);
        // Vertices are counted too: a part may have some that no triangle names.
        let vertices = whole.vertices.len() + part.vertices.len();
        if part.triangles.len() > free || vertices > 3 * MAX_TRIANGLES {
            return false;
        }
        let first = whole.vertices.len() as u32;
        let mirrors = to_whole.matrix3.determinant() < 0.0;
        whole.vertices.extend(part.vertices.iter().map(|&v| to_whole.transform_point3(v)));
        whole.triangles.extend(part.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| corner + first);
            if mirrors { [a, c, b] } else { [a, b, c] }
        }));
        true
    }
}

/// A mesh that grows triangle by triangle; corners with the same coordinates, bit for bit (but for
/// the sign of zero), are one vertex.
#[derive(Default)]
pub(super) struct Welder {
    known: HashMap<[u64; 3], u32>,
    pub(super) mesh: TriangleMesh,
}

impl Welder {
    pub(super) fn with_capacity(triangles: usize) -> Self {
        let mut welder = Self::default();
        welder.mesh.triangles.reserve_exact(triangles);
        // A closed surface has half as many vertices as triangles.
        welder.known.reserve(triangles / 2);
        welder
    }

    /// Adds a triangle; `false` if there are more vertices than a u32 counts.
    #[must_use]
    pub(super) fn triangle(&mut self, corners: [DVec3; 3]) -> bool {
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            // Adding zero makes minus zero zero.
            let corner = corner + DVec3::ZERO;
            let Ok(next) = u32::try_from(self.mesh.vertices.len()) else { return false };
            let bits = corner.to_array().map(f64::to_bits);
            *index = *self.known.entry(bits).or_insert(next);
            if *index == next {
                self.mesh.vertices.push(corner);
            }
        }
        self.mesh.triangles.push(triangle);
        true
    }
}

/// The polygon's fan from its first corner; nothing where there are fewer than three.
pub(super) fn fan(polygon: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let first = polygon.first().copied().unwrap_or(0);
    polygon.windows(2).skip(1).map(move |pair| [first, pair[0], pair[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TriangleMesh {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        TriangleMesh { vertices, triangles: vec![[0, 1, 2]], warnings: Vec::new() }
    }

    fn normal(mesh: &TriangleMesh) -> DVec3 {
        let [a, b, c] = mesh.triangles[0].map(|corner| mesh.vertices[corner as usize]);
        (b - a).cross(c - a)
    }

    #[test]
    fn a_scale_that_mirrors_keeps_the_front_in_front() {
        // Mirrored along z, what looked up looks down; along x or y, up stays up.
        for (scale, z) in [
            (DVec3::new(2.0, 3.0, 4.0), 6.0),
            (DVec3::new(-2.0, 3.0, 4.0), 6.0),
            (DVec3::new(2.0, 3.0, -4.0), -6.0),
            (DVec3::new(-2.0, -3.0, 4.0), 6.0),
            (DVec3::new(-2.0, -3.0, -4.0), -6.0),
        ] {
            let scaled = triangle().scaled(scale);
            assert_eq!(normal(&scaled), DVec3::new(0.0, 0.0, z), "{scale}");
            assert_eq!(scaled.vertices[1], DVec3::X * scale.x);
        }
    }

    #[test]
    fn a_part_that_is_mirrored_keeps_its_front_too() {
        let mut whole = Assembly::default();
        let mirror = glam::DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(whole.add(&triangle(), mirror));
        assert_eq!(normal(&whole.mesh), DVec3::Z);
    }

    #[test]
    fn the_name_says_the_format_in_letters_of_either_case() {
        for (name, format) in [
            ("a.stl", MeshFormat::Stl),
            ("a/b.STL", MeshFormat::Stl),
            ("a.b.DAE", MeshFormat::Collada),
            ("a.Obj", MeshFormat::Obj),
            ("a.gltf", MeshFormat::Gltf),
            ("a.glb", MeshFormat::Gltf),
            ("a.ply", MeshFormat::Ply),
        ] {
            assert_eq!(MeshFormat::of(Path::new(name)).unwrap(), format);
        }
        for name in ["a", "a.step", "stl", "a.zae"] {
            let error = MeshFormat::of(Path::new(name)).unwrap_err();
            assert!(matches!(error, MeshError::UnknownFormat { .. }), "{error}");
        }
    }

    #[test]
    fn a_file_that_is_not_there_or_wrong_is_named() {
        let gone = TriangleMesh::load(Path::new("no/such.stl"), UpAxis::Ros).unwrap_err();
        assert!(gone.to_string().starts_with("no/such.stl: "), "{gone}");
        let unknown = TriangleMesh::load(Path::new("some.step"), UpAxis::Ros).unwrap_err();
        assert!(unknown.to_string().starts_with("some.step: "), "{unknown}");
    }

    #[test]
    fn a_file_without_a_triangle_is_refused() {
        for (text, format) in
            [("solid a\nendsolid a\n", MeshFormat::Stl), ("v 0 0 0\n", MeshFormat::Obj)]
        {
            let error = TriangleMesh::read(text.as_bytes(), format, &MeshOptions::default());
            assert!(matches!(error, Err(MeshError::Empty { .. })), "{format}");
        }
    }

    #[test]
    fn vertices_that_no_triangle_names_are_dropped_in_order() {
        let mut mesh = TriangleMesh {
            vertices: (0..6).map(|k| DVec3::splat(k.into())).collect(),
            triangles: vec![[5, 1, 3], [3, 1, 1]],
            warnings: Vec::new(),
        };
        mesh.drop_loose_vertices();
        assert_eq!(mesh.vertices, [1.0, 3.0, 5.0].map(DVec3::splat));
        assert_eq!(mesh.triangles, [[2, 0, 1], [1, 0, 0]]);
    }
}
