//! MoveIt's scenes as text (`.scene`), as its planning scene monitor and RViz write them: objects alone, in the
//! frame of the world.
//!
//! A line for the scene's name; for each object `* NAME`, in newer files its pose, the number of its shapes,
//! and each shape with its sizes, its pose and a colour, in newer files subframes; a line of a single `.`
//! ends it.

use super::{Obstacle, RobotError, World, world};
use dcd_geom::{Pose, Shape};
use glam::{DQuat, DVec3};
use std::str::FromStr;

/// How far the squared length of a quaternion may be from 1: it is written with six digits, which lose 5e-7 of each of four numbers
/// whose sum is at most 2. Smaller: files that are refused as MoveIt writes them. Larger: a scaling passes.
const PRINTED: f64 = 4e-6;

/// Reads the text. Quaternions that are off unit length by what six digits lose are normalised.
///
/// # Errors
/// What is no such text; planes; a number that is none, or not finite; two objects of one name; a shape or a pose
/// that is refused; all with the line.
pub(super) fn read(text: &str) -> Result<World, RobotError> {
    let mut lines = Lines { rest: text.lines().enumerate(), line: 0 };
    let mut world = World::default();
    let mut names = std::collections::HashSet::new();
    lines.name()?;
    loop {
        let marker = lines.next("an object or the end")?;
        if marker == "." {
            break;
        }
        let Some(name) = marker.strip_prefix('*').map(str::trim).filter(|name| !name.is_empty())
        else {
            return Err(lines.refused(format!("{marker:?} is neither \"* NAME\" nor \".\"")));
        };
        if !names.insert(name) {
            let name = name.to_owned();
            return Err(RobotError::Twice { what: "object", name }.at_line(lines.line));
        }
        object(&mut lines, name, &mut world)?;
    }
    if let Some((line, said)) = lines.rest.find(|(_, line)| !line.trim().is_empty()) {
        lines.line = line + 1;
        return Err(lines.refused(format!("{said:?} stands behind the end")));
    }
    world.note_obstacles();
    Ok(world)
}

fn object(lines: &mut Lines<'_>, name: &str, world: &mut World) -> Result<(), RobotError> {
    // A pose has three numbers in its first line, a count is one.
    let is_new = lines.peek().is_some_and(|line| line.split_whitespace().count() > 1);
    let outer = if is_new { Some(lines.pose(name)?) } else { None };
    let [count] = lines.row::<usize, 1>("the number of shapes")?;
    if count == 0 {
        return Err(lines.refused(format!("object {name:?} has no shape")));
    }
    for _ in 0..count {
        let shape = lines.shape(name)?;
        let own = lines.pose(name)?;
        let line = lines.line;
        let pose = match &outer {
            None => own,
            Some(outer) => outer.compose(&own).map_err(|error| {
                RobotError::Pose { user: format!("object {name:?}"), error }.at_line(line)
            })?,
        };
        // Its colour.
        lines.numbers::<4>()?;
        world.obstacles.push(Obstacle { name: name.to_owned(), shape, pose });
    }
    if is_new {
        let [subframes] = lines.row::<usize, 1>("the number of subframes")?;
        for _ in 0..subframes {
            lines.next("a subframe's name")?;
            lines.pose(name)?;
        }
    }
    Ok(())
}

/// The text's lines.
struct Lines<'t> {
    rest: std::iter::Enumerate<std::str::Lines<'t>>,
    /// Of what was read last, from 1.
    line: usize,
}

impl<'t> Lines<'t> {
    fn refused(&self, why: String) -> RobotError {
        RobotError::Refused { user: "scene".to_owned(), why }.at_line(self.line)
    }

    /// The scene's own name, which is a label and may be empty; no object's.
    fn name(&mut self) -> Result<(), RobotError> {
        self.line = 1;
        match self.rest.next() {
            None => Err(self.refused("the text ends where the scene's name should be".to_owned())),
            Some((_, line)) if line.trim_start().starts_with('*') => {
                Err(self.refused(format!("{line:?} stands where the scene's name should be")))
            }
            Some(_) => Ok(()),
        }
    }

    /// The next line that is not empty.
    fn next(&mut self, wanted: &str) -> Result<&'t str, RobotError> {
        for (index, line) in self.rest.by_ref() {
            self.line = index + 1;
            if !line.trim().is_empty() {
                return Ok(line.trim());
            }
        }
        Err(self.refused(format!("the text ends where {wanted} should be")))
    }

    fn peek(&self) -> Option<&'t str> {
        self.rest.clone().map(|(_, line)| line.trim()).find(|line| !line.is_empty())
    }

    /// A line of so many numbers.
    fn row<T: FromStr + Copy, const N: usize>(&mut self, what: &str) -> Result<[T; N], RobotError> {
        let line = self.next(what)?;
        let read: Result<Vec<T>, _> = line.split_whitespace().map(str::parse).collect();
        let row = read.ok().and_then(|row| row.try_into().ok());
        row.ok_or_else(|| self.refused(format!("{line:?} is not {what} ({N} numbers)")))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], RobotError> {
        let numbers: [f64; N] = self.row("sizes, a place, a turn or a colour")?;
        match numbers.into_iter().find(|number| !number.is_finite()) {
            None => Ok(numbers),
            Some(value) => {
                let (what, user) = ("number", "scene".to_owned());
                Err(RobotError::BadNumber { what, user, value }.at_line(self.line))
            }
        }
    }

    fn pose(&mut self, name: &str) -> Result<Pose, RobotError> {
        let place = DVec3::from_array(self.numbers()?);
        let turn = DQuat::from_array(self.numbers()?);
        let is_printed = (turn.length_squared() - 1.0).abs() <= PRINTED;
        let turn = if is_printed { turn.normalize() } else { turn };
        Pose::new(turn, place).map_err(|error| {
            RobotError::Pose { user: format!("object {name:?}"), error }.at_line(self.line)
        })
    }

    fn shape(&mut self, name: &str) -> Result<Shape, RobotError> {
        let kind = self.next("a shape")?;
        let line = self.line;
        let shape = match kind.to_lowercase().as_str() {
            "box" => Shape::cuboid(DVec3::from_array(self.numbers()?) * 0.5),
            "sphere" => {
                let [radius] = self.numbers()?;
                Shape::sphere(radius)
            }
            "cylinder" => {
                let [radius, length] = self.numbers()?;
                world::cylinder(length, radius)
            }
            "cone" => {
                let [radius, length] = self.numbers()?;
                Shape::cone(length * 0.5, radius)
            }
            "mesh" => {
                let (vertices, triangles) = self.mesh()?;
                Shape::mesh(vertices, triangles)
            }
            _ => {
                let (what, kind, user) = ("shape", kind.to_owned(), format!("object {name:?}"));
                return Err(RobotError::Unsupported { what, kind, user }.at_line(line));
            }
        };
        shape.map_err(|error| {
            RobotError::Shape { user: format!("object {name:?}"), error }.at_line(line)
        })
    }

    fn mesh(&mut self) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), RobotError> {
        let [vertices, triangles] =
            self.row::<usize, 2>("the numbers of vertices and triangles")?;
        let vertices = (0..vertices).map(|_| self.numbers().map(DVec3::from_array));
        let vertices = vertices.collect::<Result<_, _>>()?;
        let triangles = (0..triangles).map(|_| self.row("the corners of a triangle"));
        Ok((vertices, triangles.collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OLD: &str = "(noname)+\n* Box 0\n1\nbox\n0.2 0.5 0.04\n0.7 0.2 0.4\n0 0 0 1\n0 0 0 0\n\
        * post\n2\nsphere\n0.1\n1 2 3\n0 0 0 1\n1 0 0 1\ncylinder\n0.1 0.6\n4 5 6\n0 0 0 1\n0 0 0 0\n.\n";

    const NEW: &str = "table scene\n* table\n1 0 0\n0 0 0.7071067811865476 0.7071067811865476\n1\nmesh\n3 1\n0 0 0\n1 0 0\n0 1 0\n\
        0 1 2\n0 0 2\n0 0 0 1\n0 0 0 0\n1\ntop\n0 0 1\n0 0 0 1\n* cone\n0 0 0\n0 0 0 1\n1\ncone\n0.1 0.4\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n";

    /// Shapes are compared by what they print.
    fn shown(shape: &Shape) -> String {
        format!("{shape:?}")
    }

    #[test]
    fn files_with_and_without_poses_of_objects_are_read() {
        let old = read(OLD).unwrap().obstacles;
        let names: Vec<&str> = old.iter().map(|obstacle| obstacle.name.as_str()).collect();
        assert_eq!(names, ["Box 0", "post", "post"]);
        assert_eq!(
            shown(&old[0].shape),
            shown(&Shape::cuboid(DVec3::new(0.1, 0.25, 0.02)).unwrap())
        );
        assert_eq!(shown(&old[2].shape), shown(&Shape::cylinder(0.3, 0.1).unwrap()));
        assert_eq!(old[1].pose.translation(), DVec3::new(1.0, 2.0, 3.0));
        let new = read(NEW).unwrap().obstacles;
        assert!(matches!(new[0].shape, Shape::Mesh(_)) && new.len() == 2);
        assert_eq!(new[0].pose.translation(), DVec3::new(1.0, 0.0, 2.0));
        assert!(new[0].pose.apply(DVec3::X).distance(DVec3::new(1.0, 1.0, 2.0)) < 1e-12);
        assert_eq!(shown(&new[1].shape), shown(&Shape::cone(0.2, 0.1).unwrap()));
        assert_eq!(read(&OLD.replace("(noname)+", "")).unwrap().obstacles.len(), 3);
        assert_eq!(read("none\n.\n").unwrap().notes, ["there is no obstacle in it"]);
    }

    #[test]
    fn quaternions_of_six_digits_are_taken() {
        let with =
            |turn: &str| OLD.replacen("0.7 0.2 0.4\n0 0 0 1", &format!("0.7 0.2 0.4\n{turn}"), 1);
        let world = read(&with("-0.00297142 0.437944 -0.859485 0.263592")).unwrap();
        let due = DQuat::from_xyzw(-0.00297142, 0.437944, -0.859485, 0.263592);
        assert!((due.length_squared() - 1.0).abs() > Pose::UNIT_TOLERANCE);
        let turned = world.obstacles[0].pose.rotation().mul_vec3(DVec3::X);
        assert!(turned.distance(due.normalize() * DVec3::X) < 1e-15);
        assert!(read(&with("0 0 0 1.00001")).is_err());
    }

    #[test]
    fn what_is_not_understood_is_refused_with_its_line() {
        let with = |from: &str, to: &str| OLD.replacen(from, to, 1);
        for (text, why) in [
            (String::new(), "the scene's name"),
            (OLD.replace("(noname)+\n", ""), "line 1: scene: \"* Box 0\" stands where"),
            (
                with("* post\n2\n", "* bare\n0\n* post\n2\n"),
                "line 10: scene: object \"bare\" has no",
            ),
            (OLD.replace(".\n", ""), "ends where"),
            (with("box", "plane"), "line 4: object \"Box 0\": shape \"plane\" is not supported"),
            (with("* Box 0", "Box 0"), "line 2"),
            (with("* post", "* Box 0"), "line 9"),
            (with("0.2 0.5 0.04", "0.2 0.5"), "line 5: scene: \"0.2 0.5\" is not"),
            (with("0.2 0.5 0.04", "0.2 0.5 NaN"), "line 5"),
            (with("0.2 0.5 0.04", "0.2 -0.5 0.04"), "line 4"),
            (with("0.7 0.2 0.4\n0 0 0 1", "0.7 0.2 0.4\n0 0 0 2"), "line 7"),
            (with("\n1\nbox", "\n2\nbox"), "line 9"),
            (OLD.replace(".\n", ".\n* more\n"), "line 22: scene: \"* more\" stands behind the end"),
        ] {
            let refused = read(&text).unwrap_err().to_string();
            assert!(refused.contains(why), "{why}: {refused}");
        }
    }
}
