//! The hull of points in triangles (Barber, Dobkin, Huhdanpaa 1996), on a lattice.
//!
//! The points are rounded once to a lattice of 2⁻³⁸ of their extent; on it every decision is exact
//! in machine words. So the surface is closed and convex at each step, coplanar and collinear
//! points included, and nothing depends on a tolerance.

use glam::DVec3;

type Point = [i128; 3];

/// The bits of a lattice coordinate. Differences have one more, a determinant three times that and
/// three for its sum: 3·40 + 3 = 123 of 127.
const BITS: i32 = 38;

/// How far points may be off a line or plane that the lattice's rounding may have brought off it,
/// units: √3 halves each of three or four points. Smaller: flat shapes with a rim of slivers.
const ROUNDED: f64 = 4.0;

/// A triangle of the surface.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Counter-clockwise seen from outside.
    pub(super) corners: [u32; 3],
    /// The triangle across the edge from corner k to corner k + 1.
    pub(super) neighbours: [u32; 3],
}

impl Triangle {
    /// Along the outward normal, of twice the triangle's area.
    pub(super) fn weighted_normal(&self, vertices: &[DVec3]) -> DVec3 {
        let [p, q, r] = self.corners.map(|k| vertices[k as usize]);
        (q - p).cross(r - p)
    }
}

/// What the points span.
pub(super) enum Hull {
    Solid(Vec<Triangle>),
    /// A plane with this unit normal.
    Flat {
        normal: DVec3,
    },
    Segment([u32; 2]),
    Point(u32),
}

/// Of at least one point; of none, an index that nothing has.
pub(super) fn hull(vertices: &[DVec3]) -> Hull {
    let points = on_lattice(vertices);
    let start = match Start::of(&points) {
        Start::Solid(start) => start,
        Start::Flat([p, q, r]) => {
            let [p, q, r] = [p, q, r].map(|k| points[k as usize]);
            let normal = cross(minus(q, p), minus(r, p)).map(|x| x as f64);
            return Hull::Flat { normal: DVec3::from_array(normal).normalize() };
        }
        Start::Segment(ends) => return Hull::Segment(ends),
        Start::Point(only) => return Hull::Point(only),
    };
    let mut surface = Surface { points: &points, faces: Vec::new() };
    surface.start(start);
    surface.grow();
    Hull::Solid(surface.compact())
}

fn on_lattice(vertices: &[DVec3]) -> Vec<Point> {
    let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    // Halved first: the difference of two numbers may overflow.
    let (middle, half) = (low * 0.5 + high * 0.5, (high * 0.5 - low * 0.5).max_element());
    let steps = f64::from(2).powi(BITS);
    let on_axis = |x: f64| if half > 0.0 { (x / half * steps).round() as i128 } else { 0 };
    vertices.iter().map(|&v| (v - middle).to_array().map(on_axis)).collect()
}

/// What to begin with.
enum Start {
    Solid([u32; 4]),
    Flat([u32; 3]),
    Segment([u32; 2]),
    Point(u32),
}

impl Start {
    /// Points far apart: the farthest from the first, from their line, from their plane. What is
    /// off by no more than the lattice's rounding is on it.
    fn of(points: &[Point]) -> Self {
        let [Some(first), ..] = [points.first(), None] else { return Self::Point(0) };
        let indices = || 0..points.len() as u32;
        let at = |k: u32| minus(points[k as usize], *first);
        let square = |v: Point| v.iter().map(|&x| (x as f64) * (x as f64)).sum::<f64>();
        let farthest = |off: &dyn Fn(u32) -> f64| {
            indices().max_by(|&j, &k| off(j).total_cmp(&off(k)).then(k.cmp(&j)))
        };
        let Some(p) = farthest(&|k| square(at(k))).filter(|&k| at(k) != [0; 3]) else {
            return Self::Point(0);
        };
        // From an end, so that a segment's two are found.
        let at = |k: u32| minus(points[k as usize], points[p as usize]);
        let q = farthest(&|k| square(at(k))).unwrap_or(0);
        let off_line = |k: u32| cross(at(q), at(k));
        let length = |v: Point| square(v).sqrt();
        let is_off = |&k: &u32| length(off_line(k)) > ROUNDED * length(at(q));
        let Some(r) = farthest(&|k| square(off_line(k))).filter(is_off) else {
            return Self::Segment([p, q]);
        };
        let normal = off_line(r);
        let thin = ROUNDED * length(normal);
        let off_plane = |k: u32| dot(normal, at(k));
        let highest = indices().max_by_key(|&k| (off_plane(k).abs(), std::cmp::Reverse(k)));
        match highest.filter(|&k| off_plane(k).abs() as f64 > thin) {
            // The fourth below the first three.
            Some(s) if off_plane(s) < 0 => Self::Solid([p, q, r, s]),
            Some(s) => Self::Solid([p, r, q, s]),
            None => Self::Flat([p, q, r]),
        }
    }
}

struct Face {
    triangle: Triangle,
    normal: Point,
    offset: i128,
    /// The points beyond it that no other face has.
    outside: Vec<u32>,
    alive: bool,
}

/// An edge between what a point sees and what it does not, as the seen face runs along it.
#[derive(Clone, Copy)]
struct Edge {
    from: u32,
    to: u32,
    hidden: u32,
}

struct Surface<'a> {
    points: &'a [Point],
    /// Those that are gone too, so that an index stays good.
    faces: Vec<Face>,
}

impl Surface<'_> {
    fn start(&mut self, [p, q, r, s]: [u32; 4]) {
        for (corners, neighbours) in [
            ([p, q, r], [1, 2, 3]),
            ([q, p, s], [0, 3, 2]),
            ([r, q, s], [0, 1, 3]),
            ([p, r, s], [0, 2, 1]),
        ] {
            self.push(Triangle { corners, neighbours });
        }
        let all = 0..self.points.len() as u32;
        self.hand_out(all, 0);
    }

    /// Adds the farthest point of each face that has points beyond it, until none has.
    fn grow(&mut self) {
        let (mut seen, mut horizon, mut orphans) = (Vec::new(), Vec::new(), Vec::new());
        let mut starting = vec![0u32; self.points.len()];
        let mut index = 0;
        while index < self.faces.len() {
            let face = &self.faces[index];
            let far = |&k: &u32| (dot(face.normal, self.points[k as usize]), std::cmp::Reverse(k));
            let Some(apex) = face.outside.iter().copied().max_by_key(far).filter(|_| face.alive)
            else {
                index += 1;
                continue;
            };
            self.find_horizon(apex, index as u32, &mut seen, &mut horizon);
            orphans.clear();
            for &gone in &seen {
                orphans.append(&mut self.faces[gone as usize].outside);
            }
            let first = self.faces.len() as u32;
            for (k, edge) in (first..).zip(&horizon) {
                starting[edge.from as usize] = k;
            }
            for (k, &Edge { from, to, hidden }) in (first..).zip(&horizon) {
                self.reconnect(hidden, (to, from), k);
                let neighbours = [hidden, starting[to as usize], u32::MAX];
                self.push(Triangle { corners: [from, to, apex], neighbours });
            }
            for k in first..first + horizon.len() as u32 {
                let after = self.faces[k as usize].triangle.neighbours[1];
                self.faces[after as usize].triangle.neighbours[2] = k;
            }
            self.hand_out(orphans.drain(..), first);
        }
    }

    /// Gives each point to the first of the faces from `first` on that it is beyond, if any.
    fn hand_out(&mut self, points: impl Iterator<Item = u32>, first: u32) {
        for k in points {
            let p = self.points[k as usize];
            let beyond = |face: &&mut Face| dot(face.normal, p) > face.offset;
            if let Some(face) = self.faces[first as usize..].iter_mut().find(beyond) {
                face.outside.push(k);
            }
        }
    }

    /// Marks what the point sees as gone and collects the edges round it.
    fn find_horizon(
        &mut self,
        apex: u32,
        first: u32,
        seen: &mut Vec<u32>,
        horizon: &mut Vec<Edge>,
    ) {
        let p = self.points[apex as usize];
        seen.clear();
        horizon.clear();
        self.faces[first as usize].alive = false;
        seen.push(first);
        let mut next = 0;
        while let Some(&index) = seen.get(next) {
            next += 1;
            let Triangle { corners, neighbours } = self.faces[index as usize].triangle;
            for (k, &other) in neighbours.iter().enumerate() {
                let neighbour = &mut self.faces[other as usize];
                if !neighbour.alive {
                    continue;
                }
                if dot(neighbour.normal, p) > neighbour.offset {
                    neighbour.alive = false;
                    seen.push(other);
                } else {
                    horizon.push(Edge {
                        from: corners[k],
                        to: corners[(k + 1) % 3],
                        hidden: other,
                    });
                }
            }
        }
    }

    /// Makes `neighbour` the one across an edge of `face`.
    fn reconnect(&mut self, face: u32, edge: (u32, u32), neighbour: u32) {
        let triangle = &mut self.faces[face as usize].triangle;
        for k in 0..3 {
            if (triangle.corners[k], triangle.corners[(k + 1) % 3]) == edge {
                triangle.neighbours[k] = neighbour;
            }
        }
    }

    fn push(&mut self, triangle: Triangle) {
        let [p, q, r] = triangle.corners.map(|k| self.points[k as usize]);
        let normal = cross(minus(q, p), minus(r, p));
        let offset = dot(normal, p);
        self.faces.push(Face { triangle, normal, offset, outside: Vec::new(), alive: true });
    }

    /// The triangles that are there, numbered anew.
    fn compact(self) -> Vec<Triangle> {
        let mut number = 0;
        let numbers: Vec<u32> = self
            .faces
            .iter()
            .map(|face| {
                number += u32::from(face.alive);
                number.wrapping_sub(1)
            })
            .collect();
        let alive = self.faces.into_iter().filter(|face| face.alive);
        alive
            .map(|Face { triangle: Triangle { corners, neighbours }, .. }| Triangle {
                corners,
                neighbours: neighbours.map(|k| numbers[k as usize]),
            })
            .collect()
    }
}

fn minus(p: Point, q: Point) -> Point {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn cross(p: Point, q: Point) -> Point {
    let minor = |j: usize, k: usize| p[j] * q[k] - p[k] * q[j];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(p: Point, q: Point) -> i128 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}
