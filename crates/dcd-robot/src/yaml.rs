//! MoveIt's YAML, read within bounds.

use super::RobotError;
use super::bounds::{FILE_BYTES, NESTING, YAML_ALIASES, YAML_NODES};
use super::scan::bounded;
use dcd_moveit::Limits;

/// Reads a text that shall be a `what`.
pub(super) fn read<T>(
    what: &'static str,
    yaml: &str,
    reader: fn(&str, Limits) -> Result<T, String>,
) -> Result<T, RobotError> {
    bounded("bytes", yaml.len(), FILE_BYTES)?;
    let limits = Limits { nesting: NESTING, nodes: YAML_NODES, aliases: YAML_ALIASES };
    reader(yaml, limits).map_err(|error| RobotError::NotOfKind { what, error })
}
