//! Where a motion starts and where it shall end, from MoveIt's requests.

use super::{Robot, RobotError};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// A motion planning request: joint values by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// The start's values.
    pub start: Vec<(String, f64)>,
    /// The goal's; joints that it leaves out stay where they start.
    pub goal: Vec<(String, f64)>,
}

#[derive(Deserialize)]
struct File {
    start_state: State,
    #[serde(default)]
    goal_constraints: Vec<Goal>,
}

#[derive(Deserialize)]
struct State {
    joint_state: JointState,
}

#[derive(Deserialize)]
struct JointState {
    name: Vec<String>,
    position: Vec<f64>,
}

#[derive(Deserialize)]
struct Goal {
    #[serde(default)]
    joint_constraints: Vec<Constraint>,
}

#[derive(Deserialize)]
struct Constraint {
    joint_name: String,
    position: f64,
}

impl Request {
    /// Reads a request of MoveIt as YAML: `start_state.joint_state`, and the joint constraints of
    /// the first of its `goal_constraints`.
    ///
    /// # Errors
    /// What is no such YAML; another number of names than of positions.
    pub fn read(yaml: &str) -> Result<Self, RobotError> {
        let file: File = parse("request", yaml)?;
        let JointState { name, position } = file.start_state.joint_state;
        let (expected, found) = (name.len(), position.len());
        if expected != found {
            let user = "joint_state".to_owned();
            return Err(RobotError::Count { what: "positions", user, expected, found });
        }
        let goal = file.goal_constraints.into_iter().next();
        let constraints = goal.map_or_else(Vec::new, |goal| goal.joint_constraints);
        let goal = constraints.into_iter().map(|c| (c.joint_name, c.position)).collect();
        Ok(Self { start: name.into_iter().zip(position).collect(), goal })
    }

    /// [`Request::read`] from a file.
    ///
    /// # Errors
    /// Those of [`Request::read`], and those of reading the file, both with its path.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        let text = std::fs::read_to_string(path).map_err(RobotError::io(path))?;
        Self::read(&text).map_err(|error| error.inside(path))
    }

    /// The start as a state of the robot.
    ///
    /// # Errors
    /// See [`Robot::state`].
    pub fn start_of(&self, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        robot.state(&self.start)
    }

    /// The goal as a state of the robot.
    ///
    /// # Errors
    /// See [`Robot::state`].
    pub fn goal_of(&self, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        let values: Vec<_> = self.start.iter().chain(&self.goal).cloned().collect();
        robot.state(&values)
    }
}

impl Robot {
    /// A state from values by joint name, the last of each name, 0 for moved joints that are left
    /// out. Values of joints that are fixed here, or that mimic others, say nothing.
    ///
    /// # Errors
    /// A name that no joint has; a value that is not finite.
    pub fn state(&self, values: &[(String, f64)]) -> Result<Vec<f64>, RobotError> {
        let mut state = vec![0.0; self.moved_joints().len()];
        for (name, value) in values {
            if !value.is_finite() {
                let user = format!("joint {name:?}");
                return Err(RobotError::BadNumber { what: "value", user, value: *value });
            }
            match self.moved_joints().iter().position(|joint| joint == name) {
                Some(index) => state[index] = *value,
                None if self.joints().iter().any(|joint| joint.name == *name) => {}
                None => {
                    let (what, name) = ("joint", name.clone());
                    return Err(RobotError::Unknown { what, name, user: "state".to_owned() });
                }
            }
        }
        Ok(state)
    }
}

/// YAML of the kind that a struct describes.
pub(super) fn parse<T: DeserializeOwned>(what: &'static str, yaml: &str) -> Result<T, RobotError> {
    serde_saphyr::from_str(yaml).map_err(|error| RobotError::Syntax {
        what,
        place: PathBuf::from("YAML"),
        error: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "start_state:
  joint_state: {name: [a, b], position: [1, -0.5]}
goal_constraints:
  - joint_constraints:
      - joint_name: b
        position: 2
max_corner: [1, 1, 1]
";

    #[test]
    fn a_requests_start_and_goal_are_read_by_name() {
        let request = Request::read(TEXT).unwrap();
        assert_eq!(request.start, [("a".to_owned(), 1.0), ("b".to_owned(), -0.5)]);
        assert_eq!(request.goal, [("b".to_owned(), 2.0)]);
    }

    #[test]
    fn a_list_of_another_length_and_no_yaml_are_refused() {
        let short = TEXT.replace("[1, -0.5]", "[1]");
        let refused = Request::read(&short).unwrap_err().to_string();
        assert_eq!(refused, "joint_state: 1 positions, not 2");
        for text in ["", "start_state: 3", "start_state: [", "\u{0}"] {
            let refused = Request::read(text).unwrap_err();
            assert!(matches!(refused, RobotError::Syntax { what: "request", .. }), "{refused}");
        }
    }
}
