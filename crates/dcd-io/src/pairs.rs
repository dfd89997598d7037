//! Pairs of posed point sets: JSON Lines, one pair a line.
//!
//! `{"name": "…", "a": [[x, y, z], …], "pose_a": {"R": [[…3], …3 rows], "t": [x, y, z]}, "b": …,
//! "pose_b": …}`, metres; `q` = [x, y, z, w] may stand in place of `R`. Keys that are none of these
//! are refused, but for `name` and those that begin with an underscore.

mod line;

use crate::read_lines;
use dcd_geom::{Polytope, Pose, PoseError, ShapeError};
use glam::{DMat3, DQuat, DVec3};
use line::{Number, PairLine, PoseValue, name_of, with_quoted_words};
use std::fmt;
use std::io::{self, BufRead};

/// One pair, checked.
#[derive(Clone, Debug)]
pub struct PairInput {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The first shape.
    pub a: Polytope,
    /// The first shape's pose.
    pub pose_a: Pose,
    /// The second shape.
    pub b: Polytope,
    /// The second shape's pose.
    pub pose_b: Pose,
}

/// Why a line was refused.
#[derive(Debug)]
pub struct PairError {
    /// The line's name, as far as it can be read.
    pub name: Option<String>,
    /// What is wrong.
    pub fault: PairFault,
}

/// What can be wrong with a line. `which` is the key: "a", "b", "pose_a" or "pose_b".
#[derive(Debug)]
#[non_exhaustive]
pub enum PairFault {
    /// It is not JSON, or lacks a key, or holds something else under it.
    Json(serde_json::Error),
    /// A point set is empty or not finite.
    Shape {
        /// Which.
        which: &'static str,
        /// What is wrong with it.
        error: ShapeError,
    },
    /// A pose is not finite, not orthonormal, or mirrors.
    Pose {
        /// Which.
        which: &'static str,
        /// What is wrong with it.
        error: PoseError,
    },
    /// A pose has neither `R` nor `q`.
    NoRotation {
        /// Which.
        which: &'static str,
    },
}

impl fmt::Display for PairFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Json(error) => error.fmt(f),
            Self::Shape { which, error } => write!(f, "{which}: {error}"),
            Self::Pose { which, error } => write!(f, "{which}: {error}"),
            Self::NoRotation { which } => write!(f, "{which}: there is neither R nor q"),
        }
    }
}

impl fmt::Display for PairError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{name}: {}", self.fault),
            None => self.fault.fmt(f),
        }
    }
}

impl std::error::Error for PairError {}

/// Reads one line, its end included or not.
///
/// The bare words NaN, Infinity and -Infinity, which are no JSON but what some writers print, are
/// understood in so far as the refusal says where they stand.
///
/// # Errors
/// A line that is no pair, with its name wherever that can be read.
pub fn read_pair(line: &[u8]) -> Result<PairInput, PairError> {
    let pair = serde_json::from_slice::<PairLine>(line).or_else(|error| {
        let quoted = with_quoted_words(line);
        serde_json::from_slice(&quoted)
            .map_err(|_| PairError { name: name_of(&quoted), fault: PairFault::Json(error) })
    })?;
    let PairLine { name, a, pose_a, b, pose_b } = pair;
    let checked = || {
        let a = hull("a", &a)?;
        let pose_a = pose("pose_a", &pose_a)?;
        Ok((a, pose_a, hull("b", &b)?, pose("pose_b", &pose_b)?))
    };
    match checked() {
        Ok((a, pose_a, b, pose_b)) => Ok(PairInput { name, a, pose_a, b, pose_b }),
        Err(fault) => Err(PairError { name, fault }),
    }
}

/// Reads line by line ([`read_lines`]). A refused line does not end the run; an empty one is refused, since
/// it is no pair.
pub fn read_pairs(
    reader: impl BufRead,
) -> impl Iterator<Item = io::Result<Result<PairInput, PairError>>> {
    read_lines(reader).map(|line| line.map(|line| read_pair(&line)))
}

fn vector(numbers: [Number; 3]) -> DVec3 {
    DVec3::from_array(numbers.map(|x| x.0))
}

fn hull(which: &'static str, points: &[[Number; 3]]) -> Result<Polytope, PairFault> {
    let points = points.iter().map(|&point| vector(point)).collect();
    Polytope::hull(points).map_err(|error| PairFault::Shape { which, error })
}

fn pose(which: &'static str, value: &PoseValue) -> Result<Pose, PairFault> {
    let t = vector(value.t);
    let pose = match (value.matrix, value.q) {
        // glam counts in columns: the rows' matrix is the transposed one.
        (Some(rows), _) => {
            let [x, y, z] = rows.map(vector);
            Pose::from_matrix(DMat3::from_cols(x, y, z).transpose(), t)
        }
        (None, Some(q)) => Pose::new(DQuat::from_array(q.map(|x| x.0)), t),
        (None, None) => return Err(PairFault::NoRotation { which }),
    };
    pose.map_err(|error| PairFault::Pose { which, error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LONGEST_LINE;

    const LINE: &str = r#"{"name": "edge", "a": [[0, 0, 0], [0.1, 2, 3]], "pose_a": {"R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "t": [4, 5, 6]}, "b": [[1, 1, 1]], "pose_b": {"q": [0, 0, 0, 1], "t": [0, 0, 0]}, "_more": {"x": [null]}}"#;

    fn refused(from: &str, to: &str) -> PairError {
        assert!(LINE.contains(from));
        read_pair(LINE.replacen(from, to, 1).as_bytes()).unwrap_err()
    }

    #[test]
    fn a_pair_is_read_row_major_and_without_loss() {
        let pair = read_pair(LINE.as_bytes()).unwrap();
        assert_eq!(pair.name.as_deref(), Some("edge"));
        assert_eq!(pair.a.vertices()[1], DVec3::new(0.1, 2.0, 3.0));
        assert_eq!(pair.pose_a.apply(DVec3::X), DVec3::new(4.0, 6.0, 6.0));
        assert_eq!(*pair.pose_b.rotation(), DMat3::IDENTITY);
        for x in [f64::MIN_POSITIVE.next_down(), 5e-324, f64::MAX, -0.0, 0.1f64.next_up()] {
            let text = LINE.replacen("0.1", &format!("{x:?}"), 1);
            let pair = read_pair(text.as_bytes()).unwrap();
            assert_eq!(pair.a.vertices()[1].x.to_bits(), x.to_bits());
        }
    }

    #[test]
    fn a_matrix_counts_where_a_quaternion_stands_too() {
        let both = LINE.replacen(r#""R""#, r#""q": [9, 9, 9, 9], "R""#, 1);
        let pair = read_pair(both.as_bytes()).unwrap();
        assert_eq!(pair.pose_a, read_pair(LINE.as_bytes()).unwrap().pose_a);
    }

    #[test]
    fn a_matrix_that_is_no_rotation_is_refused() {
        let shear = refused("[0, -1, 0]", "[0, -1, 1e-5]").fault;
        let PairFault::Pose { which: "pose_a", error: PoseError::NotOrthonormal { deviation } } =
            shear
        else {
            panic!("{shear}")
        };
        assert!((deviation - 1e-5).abs() < 1e-9);
        assert!(read_pair(LINE.replacen("[0, -1, 0]", "[0, -1, 9e-7]", 1).as_bytes()).is_ok());
        let mirror = refused("[0, -1, 0]", "[0, 1, 0]").fault;
        let expected = PoseError::Mirrors { determinant: -1.0 };
        assert!(matches!(mirror, PairFault::Pose { error, .. } if error == expected));
    }

    #[test]
    fn a_quaternion_off_the_unit_sphere_is_refused_and_a_near_one_normalised() {
        for (w, fine) in [("1.0000004", true), ("1.000001", false), ("0", false), ("-1", true)] {
            let line = LINE.replacen("[0, 0, 0, 1]", &format!("[0, 0, 0, {w}]"), 1);
            match read_pair(line.as_bytes()) {
                Ok(pair) => assert!(fine && *pair.pose_b.rotation() == DMat3::IDENTITY),
                Err(PairError { fault: PairFault::Pose { which, error }, .. }) => {
                    assert!(!fine && which == "pose_b");
                    assert!(matches!(error, PoseError::NotUnit { .. }));
                }
                Err(other) => panic!("{other}"),
            }
        }
    }

    #[test]
    fn nan_and_infinity_are_refused_where_they_stand_with_the_lines_name() {
        for word in ["NaN", "Infinity", "-Infinity"] {
            let vertex = refused("0.1", word);
            assert_eq!(vertex.name.as_deref(), Some("edge"));
            let error = "a: vertex 1 holds ";
            assert!(vertex.fault.to_string().starts_with(error), "{vertex}");
            for (from, which) in
                [("[[0, -1", "pose_a"), ("[4, 5", "pose_a"), ("[0, 0, 0, 1", "pose_b")]
            {
                let to = from.replacen(|c: char| c.is_ascii_digit(), word, 1);
                let fault = refused(from, &to).fault;
                let PairFault::Pose { which: key, error: PoseError::NotFinite { value } } = fault
                else {
                    panic!("{fault}")
                };
                assert!(key == which && !value.is_finite());
            }
        }
        let out_of_range = refused("0.1", "1e999");
        assert_eq!(out_of_range.name.as_deref(), Some("edge"));
        assert!(matches!(out_of_range.fault, PairFault::Json(_)));
    }

    #[test]
    fn an_empty_set_is_refused() {
        let empty = refused("[[1, 1, 1]]", "[]").fault;
        assert!(matches!(empty, PairFault::Shape { which: "b", error: ShapeError::Empty }));
    }

    #[test]
    fn a_pose_without_rotation_is_refused() {
        for text in [r#""q": null"#, r#""_p": [0, 0, 0, 1]"#] {
            let none = refused(r#""q": [0, 0, 0, 1]"#, text).fault;
            assert!(matches!(none, PairFault::NoRotation { which: "pose_b" }), "{none}");
        }
    }

    #[test]
    fn a_line_that_is_no_pair_is_refused_and_says_why() {
        for (from, to, why) in [
            (r#""a""#, r#""_c""#, "missing field `a`"),
            (r#""t": [4, 5, 6]"#, r#""_u": 1"#, "missing field `t`"),
            ("[0.1, 2, 3]", "[0.1, 2]", "invalid length 2"),
            ("[0.1, 2, 3]", "[0.1, 2, 3, 4]", "trailing characters"),
            ("0.1", "\"0.1\"", "expected a number"),
            ("0.1", "null", "expected a number"),
            (r#""b""#, r#""a""#, "duplicate field `a`"),
        ] {
            let error = refused(from, to);
            assert_eq!(error.name.as_deref(), Some("edge"));
            assert!(error.fault.to_string().contains(why), "{to}: {error}");
        }
        for text in ["", "\n", "[]", "7", "{", "\u{ff}"] {
            assert!(matches!(
                read_pair(text.as_bytes()),
                Err(PairError { fault: PairFault::Json(_), .. })
            ));
        }
    }

    #[test]
    fn a_key_that_is_unknown_is_refused_at_every_level_but_for_names_and_underscores() {
        for (from, to, key) in [
            (r#""_more""#, r#""more""#, "more"),
            (r#""_more""#, r#""margin""#, "margin"),
            (r#""_more""#, r#""A""#, "A"),
            (r#""t": [4"#, r#""r": [[1, 0, 0]], "t": [4"#, "r"),
            (r#""q""#, r#""Q""#, "Q"),
            (r#""_more""#, r#""\u001b[2J\n""#, "\\u{1b}[2J\\n"),
        ] {
            let error = refused(from, to);
            assert_eq!(error.name.as_deref(), Some("edge"));
            assert!(error.fault.to_string().contains(&format!("unknown field `{key}`")), "{error}");
        }
        for to in [r#""t": [4, 5, 6], "_a": 1, "_a": [{}]"#, r#""t": [4, 5, 6], "name": {"_": 1}"#]
        {
            assert!(read_pair(LINE.replacen(r#""t": [4, 5, 6]"#, to, 1).as_bytes()).is_ok());
        }
    }

    #[test]
    fn a_list_in_place_of_an_object_is_refused() {
        let pose = r#"{"q": [0, 0, 0, 1], "t": [0, 0, 0]}"#;
        let list = format!("[\"x\", [[0, 0, 0]], {pose}, [[0, 0, 0]], {pose}]");
        assert!(read_pair(list.as_bytes()).is_err());
        assert!(
            read_pair(LINE.replacen(pose, "[null, [0, 0, 0, 1], [0, 0, 0]]", 1).as_bytes())
                .is_err()
        );
    }

    #[test]
    fn nesting_of_any_depth_is_refused_or_passed_over_without_a_stack() {
        let deep = |key: &str| {
            LINE.replacen(r#"{"x": [null]}"#, &"[".repeat(1_000_000), 1).replacen("_more", key, 1)
        };
        assert!(read_pair(deep("_more").as_bytes()).is_err());
        assert!(read_pair(deep("more").as_bytes()).is_err());
        let closed = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
        let own = LINE.replacen(r#"{"x": [null]}"#, &closed, 1);
        // Whether it is passed over is the JSON reader's matter.
        let _ = read_pair(own.as_bytes());
        let points = LINE.replacen("[[1, 1, 1]]", &closed, 1);
        assert!(read_pair(points.as_bytes()).is_err());
    }

    #[test]
    fn a_byte_order_mark_is_passed_over_before_the_first_line_alone() {
        let text = ["\u{feff}", LINE, "\n\u{feff}", LINE, "\n"].concat();
        let fine: Vec<bool> =
            read_pairs(text.as_bytes()).map(|line| line.unwrap().is_ok()).collect();
        assert_eq!(fine, [true, false]);
    }

    #[test]
    fn a_line_without_an_end_is_refused_before_it_takes_all_memory() {
        let mut items = read_pairs(io::BufReader::new(io::repeat(b' ')));
        let refused = items.next().unwrap().unwrap_err().to_string();
        assert!(refused.contains(&LONGEST_LINE.to_string()) && items.next().is_none(), "{refused}");
    }

    #[test]
    fn a_line_cut_at_any_byte_is_refused() {
        for end in 0..LINE.len() {
            assert!(read_pair(&LINE.as_bytes()[..end]).is_err(), "{end}");
        }
    }

    #[test]
    fn a_refused_line_does_not_end_the_run() {
        let text = [LINE.as_bytes(), b"\n\xff\xfe\n\n", LINE.as_bytes(), b"\r\n"].concat();
        let fine: Vec<bool> = read_pairs(&text[..]).map(|line| line.unwrap().is_ok()).collect();
        assert_eq!(fine, [true, false, false, true]);
    }

    #[test]
    fn a_reader_that_fails_ends_the_run_once() {
        struct Broken;
        impl io::Read for Broken {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::Error::other("broken"))
            }
        }
        let items: Vec<_> = read_pairs(io::BufReader::new(Broken)).collect();
        assert!(matches!(items[..], [Err(_)]));
    }
}
