//! How large a robot's files may be. Each is checked before the work that it bounds; what goes
//! beyond is refused with the limit in the message. A robot of a hundred links takes a thousandth of
//! any of them.

/// Bytes of a URDF, an SRDF, a scene or a request. Read up to here and no further, so that a file
/// without an end is refused too.
pub const FILE_BYTES: usize = 64 << 20;

/// Elements of an XML file: about a hundred bytes of memory each.
pub const XML_ELEMENTS: usize = 2_000_000;

/// How deep elements of an XML file, lists and maps of YAML, and an SRDF's groups of groups may be nested.
pub const NESTING: usize = 64;

/// Attributes of one XML element: whether two are equal is found by comparing all.
pub const XML_ATTRIBUTES: usize = 64;

/// Namespaces declared in an XML file: each is copied to what stands inside.
pub const XML_NAMESPACES: usize = 64;

/// Names and values, lists and maps of a YAML file, what aliases repeat among them.
pub const YAML_NODES: usize = 4_000_000;

/// Aliases of a YAML file.
pub const YAML_ALIASES: usize = 10_000;

/// Different mesh files of a robot.
pub const MESH_FILES: usize = 10_000;

/// Vertices of all shapes of a robot, a mesh that is used twice counted twice.
pub const VERTICES: usize = 1 << 24;

/// Pairs of shapes that may touch, one by one: what is tied rigidly counts once a shape. Eight bytes
/// of memory each.
pub const ALLOWED_PAIRS: usize = 1 << 23;
