//! Where a motion starts and where it shall end, from MoveIt's requests.

use super::kinematics::JointFrame;
use super::notes::Unused;
use super::scene::{MultiDof, each_once, joint_values};
use super::{MovedJoint, Robot, RobotError, Srdf, World, xml, yaml};
use dcd_moveit::{MotionPlanRequest, RobotState};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// A motion planning request: joint values by name.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// The start's values.
    pub start: Vec<(String, f64)>,
    /// The goal's; joints that it leaves out stay where they start.
    pub goal: Vec<(String, f64)>,
    state: RobotState,
    /// Whether the first goal requires more than joint values.
    beyond_joints: bool,
    notes: Vec<String>,
}

impl Request {
    /// Reads a request of MoveIt as YAML: `start_state.joint_state`, and the joint constraints of
    /// the first of its `goal_constraints`.
    ///
    /// # Errors
    /// What is no such YAML; another number of names than of positions; two values or constraints of one joint.
    pub fn read(yaml: &str) -> Result<Self, RobotError> {
        let file: MotionPlanRequest = yaml::read("request", yaml, dcd_moveit::read_request)?;
        if let Some(attached) = file.start_state.attached_collision_objects.first() {
            let user = format!("attached object {:?}", attached.value.object.id);
            let why = "a request does not attach objects here: the scene may".to_owned();
            return Err(RobotError::Refused { user, why }.at_line(attached.line));
        }
        let start = joint_values(&file.start_state)?;
        let mut unused = Unused::default();
        file.for_each_unused(&mut |kind, line| unused.add(kind, line));
        let mut notes: Vec<String> = unused.kinds().into_iter().collect();
        if file.goal_constraints.len() > 1 {
            let goals = file.goal_constraints.len();
            notes.push(format!("of {goals} goal_constraints the first is used"));
        }
        if file.start_state.is_diff {
            let what = "start_state is a difference (is_diff)";
            notes.push(format!("{what}: as without, what it leaves out is where the world has it"));
        }
        let goal = file.goal_constraints.into_iter().next().unwrap_or_default();
        let beyond =
            [goal.position_constraints, goal.orientation_constraints, goal.visibility_constraints];
        let beyond_joints = beyond.iter().any(|held| held.0);
        let constraints = goal.joint_constraints;
        let (names, positions): (Vec<String>, Vec<f64>) =
            constraints.into_iter().map(|c| (c.joint_name, c.position)).unzip();
        each_once("constraint of joint", &names)?;
        let goal = names.into_iter().zip(positions).collect();
        Ok(Self { start, goal, state: file.start_state, beyond_joints, notes })
    }

    /// [`Request::read`] from a file.
    ///
    /// # Errors
    /// Those of [`Request::read`], and those of reading the file, both with its path.
    pub fn load(path: &Path) -> Result<Self, RobotError> {
        Self::read(&xml::text_of(path)?).map_err(|error| error.inside(path))
    }

    /// The start as a state of the robot.
    ///
    /// # Errors
    /// See [`Robot::state`].
    pub fn start_of(&self, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        self.start_in(&World::default(), robot)
    }

    /// The goal as a state of the robot.
    ///
    /// # Errors
    /// See [`Robot::state`]; a goal that requires more than joint values, or nothing.
    pub fn goal_of(&self, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        self.goal_in(&World::default(), robot)
    }

    /// The start in a world, whose joint values count where the request says nothing.
    ///
    /// # Errors
    /// See [`Robot::state`], of the goal's values too: a request that names a joint which the robot has not is about another
    /// robot.
    pub fn start_in(&self, world: &World, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        robot.state(&self.goal)?;
        robot.state(&self.values_in(world))
    }

    /// The goal in a world, whose joint values count where the request says nothing.
    ///
    /// # Errors
    /// See [`Request::goal_of`].
    pub fn goal_in(&self, world: &World, robot: &Robot) -> Result<Vec<f64>, RobotError> {
        let refused =
            |why: &str| Err(RobotError::Refused { user: "goal".to_owned(), why: why.to_owned() });
        if self.beyond_joints {
            return refused("it contains poses, and joint values alone are understood");
        }
        if self.goal.is_empty() {
            return refused("the request constrains no joint: there is none");
        }
        robot.state(&[self.values_in(world), self.goal.clone()].concat())
    }

    /// Values of joints by name, the later ones of more weight.
    fn values_in(&self, world: &World) -> Vec<(String, f64)> {
        [&world.joints[..], &self.start].concat()
    }

    /// Takes over what the start says of joints of several values: the robot of a world stands where it has its
    /// root, and its own floating and planar joints are among the world's values.
    ///
    /// # Errors
    /// A joint that neither the SRDF nor the robot knows, or a pose that is refused.
    pub fn place_base(
        &self,
        world: &mut World,
        robot: &Robot,
        srdf: Option<&Srdf>,
    ) -> Result<(), RobotError> {
        let MultiDof { base, values } = MultiDof::of(&self.state, robot, srdf)?;
        world.joints.extend(values);
        if let Some(base) = base {
            let user = "start_state".to_owned();
            let pose = JointFrame::pose(&base).map_err(|error| RobotError::Pose { user, error })?;
            world.base = Some(pose);
        }
        Ok(())
    }

    /// What the request says that is not used: a sentence each.
    pub fn notes(&self, robot: &Robot) -> Vec<String> {
        let mut notes = self.notes.clone();
        notes.extend(robot.idle_values(&self.start));
        notes.extend(robot.idle_values(&self.goal).map(|note| format!("goal: {note}")));
        notes
    }
}

impl Robot {
    /// A state from values by joint name, the last of each name, 0 for moved joints that are left
    /// out. Values of joints that are fixed here, or that mimic others, say nothing.
    ///
    /// # Errors
    /// A name that no joint has, or one of several values; a value that is not finite.
    pub fn state(&self, values: &[(String, f64)]) -> Result<Vec<f64>, RobotError> {
        let (own, mut known) = (self.variables(), HashMap::new());
        known.extend(self.joints().iter().map(|joint| (joint.name.as_str(), None)));
        known.extend(own.iter().map(String::as_str).zip((0..).map(Some)));
        let several = self.moved_joints().iter().filter(|joint| joint.values.len() > 1);
        let several: HashMap<&str, &MovedJoint> =
            several.map(|joint| (joint.name.as_str(), joint)).collect();
        let mut state = self.rest_state();
        for (name, value) in values {
            if !value.is_finite() {
                let user = format!("joint {name:?}");
                return Err(RobotError::BadNumber { what: "value", user, value: *value });
            }
            if let Some(joint) = several.get(name.as_str()) {
                let (user, names) = (format!("joint {name:?}"), &own[joint.values.clone()]);
                let why = format!("it has {} values: {}", names.len(), names.join(", "));
                return Err(RobotError::Refused { user, why });
            }
            match known.get(name.as_str()) {
                Some(&Some(index)) => state[index] = *value,
                Some(None) => {}
                None => {
                    let (what, name) = ("joint", name.clone());
                    return Err(RobotError::Unknown { what, name, user: "state".to_owned() });
                }
            }
        }
        Ok(state)
    }

    /// A sentence about those values that are of joints without a value of their own. Those of unknown joints,
    /// which [`Robot::state`] refuses, are not among them.
    pub(super) fn idle_values(&self, values: &[(String, f64)]) -> Option<String> {
        let own: HashSet<&str> = self.variables().iter().map(String::as_str).collect();
        let joints: HashSet<&str> = self.joints().iter().map(|joint| joint.name.as_str()).collect();
        let idle = |name: &&str| joints.contains(name) && !own.contains(name);
        let idle: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).filter(idle).collect();
        (!idle.is_empty()).then(|| {
            format!(
                "not used: values of joints that are fixed or mimic others: {}",
                idle.join(", ")
            )
        })
    }
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
planner_id: fast
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
        assert_eq!(refused, "line 2: joint_state: 1 positions, not 2");
        let twice =
            TEXT.replace("      - joint", "      - {joint_name: b, position: 1}\n      - joint");
        let refused = Request::read(&twice).unwrap_err().to_string();
        assert_eq!(refused, "there are two of constraint of joint \"b\"");
        for text in ["", "start_state: 3", "start_state: [", "\u{0}"] {
            let refused = Request::read(text).unwrap_err();
            assert!(matches!(refused, RobotError::NotOfKind { what: "request", .. }), "{refused}");
        }
    }

    /// A robot of two joints, of which one is fixed.
    fn robot() -> Robot {
        let joint = |name, kind, [parent, child]: [&str; 2]| {
            format!(
                "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/>\
                 <child link=\"{child}\"/></joint>"
            )
        };
        let joints = [joint("a", "continuous", ["x", "y"]), joint("b", "fixed", ["y", "z"])];
        let shape = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
        let links = format!("<link name=\"x\">{shape}</link><link name=\"y\"/><link name=\"z\"/>");
        let urdf = format!("<robot name=\"r\">{links}{}</robot>", joints.concat());
        Robot::read(&urdf, Path::new("."), crate::LinkShapes::Hulls).unwrap()
    }

    #[test]
    fn a_goal_without_constraints_is_none() {
        let start = "start_state: {joint_state: {name: [a], position: [1]}}\n";
        let noted = "goal_constraints: [{joint_constraints: [], position_constraints: []}]";
        for goal in ["", "goal_constraints: []", "goal_constraints: [{}]", noted] {
            let request = Request::read(&[start, goal].concat()).unwrap();
            assert_eq!(request.start_of(&robot()).unwrap(), [1.0]);
            let refused = request.goal_of(&robot()).unwrap_err().to_string();
            assert_eq!(refused, "goal: the request constrains no joint: there is none", "{goal}");
        }
    }

    #[test]
    fn what_a_request_says_for_nothing_is_named() {
        let notes = |text: &str| Request::read(text).unwrap().notes(&robot());
        let idle = "not used: values of joints that are fixed or mimic others: b";
        assert_eq!(notes(TEXT), ["not used: planner_id", idle, &format!("goal: {idle}")]);
        let constraint = "position: 2, tolerance_above: 0, tolerance_below: 0.1, weight: 1";
        let goal =
            format!("goal_constraints: [{{joint_constraints: [{{joint_name: a, {constraint}}}]}}]");
        let notes = notes(&format!("start_state: {{is_diff: true}}\n{goal}"));
        let unused = "not used: tolerances of joint constraints, weights of joint constraints";
        let difference = "start_state is a difference (is_diff): as without, what it leaves out is where \
                          the world has it";
        assert_eq!(notes, [unused, difference]);
    }

    #[test]
    fn an_unknown_joint_is_refused_and_called_neither_fixed_nor_mimicking() {
        let text = "start_state: {joint_state: {name: [c], position: [1]}}";
        let request = Request::read(text).unwrap();
        assert_eq!(request.notes(&robot()), [""; 0]);
        let refused = request.start_of(&robot()).unwrap_err().to_string();
        assert!(refused.contains("\"c\""), "{refused}");
        for wrong in ["{joint_name: c, position: 1}", "{joint_name: a, position: .inf}"] {
            let goal = format!("goal_constraints: [{{joint_constraints: [{wrong}]}}]");
            let text = format!("start_state: {{}}\n{goal}");
            let request = Request::read(&text).unwrap();
            for state in [request.start_of(&robot()), request.goal_of(&robot())] {
                let refused = state.unwrap_err().to_string();
                let named = refused.contains("\"c\"") || refused.contains("inf");
                assert!(named, "{wrong}: {refused}");
            }
        }
    }
}
