//! The triangles of a geometry.

use super::super::triangles::{MAX_TRIANGLES, fan};
use super::super::{MeshError, MeshWarning, TriangleMesh};
use super::xml::{Ids, attribute, check_count, children, count, indices, numbers, own, refused};
use glam::DVec3;
use roxmltree::Node;
use std::collections::HashMap;

/// Reads a geometry's mesh, in the frame and unit of the file.
pub(super) fn read<'a>(geometry: Node<'a, 'a>, ids: &Ids<'a>) -> Result<TriangleMesh, MeshError> {
    let mut surface =
        Surface { ids, sources: HashMap::new(), mesh: TriangleMesh::default(), lines: 0 };
    for kind in children(geometry) {
        match kind.tag_name().name() {
            "mesh" => {
                for part in children(kind) {
                    match part.tag_name().name() {
                        "source" | "vertices" | "extra" => {}
                        "lines" | "linestrips" => surface.lines += 1,
                        _ => surface.add(part)?,
                    }
                }
            }
            "asset" | "extra" => {}
            // convex_mesh, spline, brep, and what is unknown.
            _ => return Err(refused(kind, "geometry other than a <mesh> is not supported")),
        }
    }
    let Surface { mut mesh, lines, .. } = surface;
    mesh.drop_loose_vertices();
    if lines > 0 {
        mesh.warnings.push(MeshWarning::Lines { count: lines });
    }
    Ok(mesh)
}

/// The triangles that were read so far.
struct Surface<'a, 'i> {
    ids: &'i Ids<'a>,
    /// For each source of positions that was read: where its points begin among the vertices, and
    /// how many there are.
    sources: HashMap<roxmltree::NodeId, (u32, usize)>,
    mesh: TriangleMesh,
    /// Elements that hold points or lines.
    lines: usize,
}

impl<'a> Surface<'a, '_> {
    /// Adds the triangles of an element that lists some.
    fn add(&mut self, part: Node<'a, 'a>) -> Result<(), MeshError> {
        let kind = part.tag_name().name();
        if !["triangles", "polylist", "polygons", "tristrips", "trifans"].contains(&kind) {
            return Err(refused(part, "an unknown element in a mesh"));
        }
        if let Some(hole) = own(part, "ph").next() {
            return Err(refused(hole, "polygons with holes are not supported"));
        }
        let is_known = |name: &str| {
            ["input", "p", "extra"].contains(&name) || (name, kind) == ("vcount", "polylist")
        };
        if let Some(other) = children(part).find(|child| !is_known(child.tag_name().name())) {
            return Err(refused(other, format!("an unknown element in <{kind}>")));
        }
        if let Some(second) = own(part, "vcount").nth(1) {
            return Err(refused(second, "a second <vcount>"));
        }
        let is_text = |child: &Node<'_, '_>| {
            child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty())
        };
        if part.children().any(|child| is_text(&child)) {
            return Err(refused(part, format!("text in <{kind}> that is in none of its elements")));
        }
        let lists: Vec<_> = own(part, "p").collect();
        if lists.is_empty() {
            return check_count(part, 0);
        }
        let corners = Corners::of(part, self.ids)?;
        let (first, points) = self.positions(corners.positions)?;
        let mut found = 0;
        for list in lists {
            let polygon = corners.read(list, first, points)?;
            found += match kind {
                "triangles" => self.triangles(list, &polygon)?,
                "polylist" => self.polylist(part, &polygon)?,
                "tristrips" => self.strip(&polygon),
                // Polygons are lists of one fan each.
                _ => self.fan(&polygon),
            };
            if self.mesh.triangles.len() > MAX_TRIANGLES {
                return Err(refused(part, "too many triangles"));
            }
        }
        check_count(part, found)
    }

    fn triangles(&mut self, list: Node<'_, '_>, corners: &[u32]) -> Result<usize, MeshError> {
        let (triangles, []) = corners.as_chunks::<3>() else {
            return Err(refused(list, format!("{} corners make no triangles", corners.len())));
        };
        self.mesh.triangles.extend(triangles);
        Ok(triangles.len())
    }

    fn polylist(&mut self, part: Node<'a, 'a>, mut rest: &[u32]) -> Result<usize, MeshError> {
        let Some(sizes) = own(part, "vcount").next() else {
            return Err(refused(part, "there is no <vcount>"));
        };
        let given = indices(sizes)?;
        for &size in &given {
            let Some((polygon, after)) = rest.split_at_checked(size as usize) else {
                return Err(refused(sizes, "it counts more corners than <p> has"));
            };
            self.fan(polygon);
            self.lines += usize::from(size < 3);
            rest = after;
        }
        if rest.is_empty() {
            return Ok(given.len());
        }
        Err(refused(sizes, format!("it leaves {} corners of <p> without a polygon", rest.len())))
    }

    /// Every second triangle of a strip lists its corners the other way round.
    fn strip(&mut self, corners: &[u32]) -> usize {
        let triangles = corners
            .windows(3)
            .enumerate()
            .map(|(k, at)| if k % 2 == 0 { [at[0], at[1], at[2]] } else { [at[1], at[0], at[2]] });
        self.mesh.triangles.extend(triangles);
        1
    }

    fn fan(&mut self, corners: &[u32]) -> usize {
        self.mesh.triangles.extend(fan(corners));
        1
    }

    /// The points of a source, added to the vertices when first needed.
    fn positions(&mut self, source: Node<'a, 'a>) -> Result<(u32, usize), MeshError> {
        if let Some(&known) = self.sources.get(&source.id()) {
            return Ok(known);
        }
        let points = positions(source, self.ids)?;
        let before = self.mesh.vertices.len();
        if points.len() > 3 * MAX_TRIANGLES - before {
            return Err(refused(source, "too many points"));
        }
        let known = (before as u32, points.len());
        self.mesh.vertices.extend(points);
        self.sources.insert(source.id(), known);
        Ok(known)
    }
}

/// Where the corners of an element's lists stand among the numbers of its `<p>`.
struct Corners<'a> {
    /// The source of the positions.
    positions: Node<'a, 'a>,
    /// Where in each group the index of the position is.
    offset: usize,
    /// How many numbers a group, one for each corner, has.
    stride: usize,
}

impl<'a> Corners<'a> {
    fn of(part: Node<'a, 'a>, ids: &Ids<'a>) -> Result<Self, MeshError> {
        let mut vertex = None;
        let mut stride = 0;
        for input in own(part, "input") {
            let Some(offset) = count(input, "offset")? else {
                return Err(refused(input, "there is no attribute \"offset\""));
            };
            let Some(after) = offset.checked_add(1) else {
                return Err(refused(input, "the offset is too large"));
            };
            stride = stride.max(after);
            if attribute(input, "semantic")? == "VERTEX"
                && vertex.replace((input, offset)).is_some()
            {
                return Err(refused(input, "a second input of vertices is not supported"));
            }
        }
        let Some((input, offset)) = vertex else {
            return Err(refused(part, "there is no input of vertices"));
        };
        let vertices = ids.target(input, "source", "vertices")?;
        let is_position = |input: &Node<'_, '_>| input.attribute("semantic") == Some("POSITION");
        let positions: Vec<_> = own(vertices, "input").filter(is_position).collect();
        let &[position] = &positions[..] else {
            let problem = format!("{} inputs of positions, not one", positions.len());
            return Err(refused(vertices, problem));
        };
        Ok(Self { positions: ids.target(position, "source", "source")?, offset, stride })
    }

    /// The vertices that a list names, which count from `first`.
    fn read(&self, list: Node<'_, '_>, first: u32, points: usize) -> Result<Vec<u32>, MeshError> {
        let given = indices(list)?;
        if given.len() % self.stride != 0 {
            let problem =
                format!("{} numbers are not {} for each corner", given.len(), self.stride);
            return Err(refused(list, problem));
        }
        let corner = |group: &[u32]| {
            let index = group[self.offset];
            if (index as usize) < points {
                return Ok(first + index);
            }
            Err(refused(list, format!("it names point {index}, but there are {points}")))
        };
        given.chunks_exact(self.stride).map(corner).collect()
    }
}

/// The points of a source, as its accessor picks them.
fn positions<'a>(source: Node<'a, 'a>, ids: &Ids<'a>) -> Result<Vec<DVec3>, MeshError> {
    let technique = own(source, "technique_common").next();
    let accessor = technique.and_then(|technique| own(technique, "accessor").next());
    let Some(accessor) = accessor else { return Err(refused(source, "there is no <accessor>")) };
    let array = ids.target(accessor, "source", "float_array")?;
    let numbers = numbers(array)?;
    check_count(array, numbers.len())?;
    let axes = axes(accessor)?;
    let stride = count(accessor, "stride")?.unwrap_or(1);
    let offset = count(accessor, "offset")?.unwrap_or(0);
    let Some(points) = count(accessor, "count")? else {
        return Err(refused(accessor, "there is no attribute \"count\""));
    };
    let reach = axes.into_iter().max().unwrap_or(0);
    if reach >= stride {
        return Err(refused(accessor, format!("a stride of {stride} is too short for a point")));
    }
    // A point may end before its stride does.
    let last = points.checked_sub(1).map_or(Some(0), |before| {
        before.checked_mul(stride)?.checked_add(offset)?.checked_add(reach + 1)
    });
    if last.is_none_or(|last| last > numbers.len()) {
        let problem = format!("{points} points do not fit into {} numbers", numbers.len());
        return Err(refused(accessor, problem));
    }
    let point = |k: usize| {
        let [x, y, z] = axes.map(|axis| numbers[offset + k * stride + axis]);
        DVec3::new(x, y, z)
    };
    Ok((0..points).map(point).collect())
}

/// Where x, y and z are in each group of an accessor's numbers. A parameter without a name is
/// passed over; where none has a name the first three are meant.
fn axes(accessor: Node<'_, '_>) -> Result<[usize; 3], MeshError> {
    let names: Vec<_> = own(accessor, "param").map(|param| param.attribute("name")).collect();
    if names.iter().all(|name| name.is_none_or(str::is_empty)) {
        return Ok([0, 1, 2]);
    }
    let place = |axis: &str| {
        let found =
            names.iter().position(|name| name.is_some_and(|n| n.eq_ignore_ascii_case(axis)));
        found.ok_or_else(|| refused(accessor, format!("there is no parameter {axis:?}")))
    };
    Ok([place("X")?, place("Y")?, place("Z")?])
}
