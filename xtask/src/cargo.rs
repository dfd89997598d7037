//! What cargo knows: the packages of the workspace, their dependencies, and where it puts what it builds.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

/// `cargo metadata`, as far as it is of use here.
#[derive(Debug, Deserialize)]
pub struct Metadata {
    /// Every package in the tree of this machine's target, our own included.
    pub packages: Vec<Package>,
    /// Ids of our own.
    pub workspace_members: Vec<String>,
    /// Where cargo puts what it builds.
    #[serde(default)]
    pub target_directory: PathBuf,
}

/// One package of the tree.
#[derive(Debug, Deserialize)]
pub struct Package {
    /// Cargo's name for exactly this version from this place.
    pub id: String,
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The SPDX expression of its licence, if it states one.
    pub license: Option<String>,
    /// Its Cargo.toml.
    pub manifest_path: PathBuf,
    /// What its manifest names as dependencies, of every kind.
    pub dependencies: Vec<Dependency>,
    /// What cargo builds from it.
    pub targets: Vec<Target>,
}

/// A dependency as a manifest names it.
#[derive(Debug, Deserialize)]
pub struct Dependency {
    /// The package depended on.
    pub name: String,
}

/// One thing that cargo builds from a package.
#[derive(Debug, PartialEq, Eq, Deserialize)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// What it is: "lib", "bin", "example", …
    pub kind: Vec<String>,
    /// Its first source file.
    #[serde(default)]
    pub src_path: PathBuf,
    /// Features without which it is not built.
    #[serde(rename = "required-features", default)]
    pub required_features: Vec<String>,
}

impl Metadata {
    /// Reads this workspace's metadata from cargo.
    ///
    /// # Errors
    /// Cargo fails, or answers what cannot be read.
    pub fn read() -> Result<Self> {
        // Only this machine's target: others would have packages downloaded that are never built.
        let host = host()?;
        let arguments = ["metadata", "--quiet", "--format-version=1", "--filter-platform", &host];
        let json = printed(cargo().args(arguments))?;
        let mut metadata: Self =
            serde_json::from_str(&json).context("cannot read what `cargo metadata` prints")?;
        metadata.packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
        Ok(metadata)
    }

    /// Our own packages, by name.
    pub fn members(&self) -> impl Iterator<Item = &Package> {
        self.packages.iter().filter(|package| self.workspace_members.contains(&package.id))
    }

    /// Our own package of this name.
    #[must_use]
    pub fn member(&self, name: &str) -> Option<&Package> {
        self.members().find(|package| package.name == name)
    }
}

impl Package {
    /// Its targets of a kind.
    pub fn targets<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Target> {
        self.targets.iter().filter(move |target| target.kind.iter().any(|own| own == kind))
    }
}

/// The root of the workspace.
#[must_use]
pub fn root() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package)
}

/// A call of cargo in the root of the workspace: of the cargo that runs us, if one does.
#[must_use]
pub fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root());
    command
}

/// A built executable.
#[derive(Debug, PartialEq, Eq)]
pub struct Executable {
    /// What it was built from.
    pub target: Target,
    /// Where it is.
    pub path: PathBuf,
}

impl Executable {
    /// Whether it is the one of that kind and name: an example may be called as a binary is.
    #[must_use]
    pub fn is(&self, kind: &str, name: &str) -> bool {
        self.target.name == name && self.target.kind.iter().any(|own| own == kind)
    }
}

/// Builds with `cargo build` and the arguments; gives the executables among the requested targets.
///
/// # Errors
/// The build fails.
pub fn build(arguments: &[String]) -> Result<Vec<Executable>> {
    let mut command = cargo();
    command.arg("build").args(arguments).arg("--message-format=json-render-diagnostics");
    Ok(executables(&printed(&mut command)?))
}

/// The executables that cargo's messages name, one message a line.
fn executables(messages: &str) -> Vec<Executable> {
    #[derive(Deserialize)]
    struct Message {
        executable: PathBuf,
        target: Target,
    }
    let of_line = |line| serde_json::from_str(line).ok();
    let named = |message: Message| Executable { target: message.target, path: message.executable };
    messages.lines().filter_map(of_line).map(named).collect()
}

/// Runs a command in view.
///
/// # Errors
/// It cannot be started, or fails.
pub fn shown(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    ensure!(status.success(), "{status}");
    Ok(())
}

/// What a command prints; its errors stay in view.
///
/// # Errors
/// It cannot be started, fails, or prints no text.
pub fn printed(command: &mut Command) -> Result<String> {
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.with_context(|| format!("cannot start {command:?}"))?;
    ensure!(output.status.success(), "{command:?}: {}", output.status);
    String::from_utf8(output.stdout).with_context(|| format!("{command:?} prints no text"))
}

/// Whether the toolchain has the standard library of a target.
///
/// # Errors
/// The compiler cannot be run.
pub fn has_target(target: &str) -> Result<bool> {
    let library = printed(rustc().args(["--print", "target-libdir", "--target", target]))?;
    Ok(Path::new(library.trim()).is_dir())
}

fn rustc() -> Command {
    let mut command = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    command.current_dir(root());
    command
}

/// The target triple of this machine.
fn host() -> Result<String> {
    let version = printed(rustc().arg("-vV"))?;
    match version.lines().find_map(|line| line.strip_prefix("host: ")) {
        Some(host) => Ok(host.to_owned()),
        None => bail!("`rustc -vV` names no host: {version}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn executables_are_read_from_the_messages_of_a_build() {
        let messages = r#"{"reason":"compiler-artifact","target":{"name":"a","kind":["lib"]},"executable":null}
{"reason":"compiler-artifact","target":{"name":"b","kind":["example"]},"executable":"/t/b"}
{"reason":"compiler-artifact","target":{"name":"b","kind":["bin"]},"executable":"/t/c"}
{"reason":"build-finished","success":true}"#;
        let found = executables(messages);
        assert_eq!(found.iter().map(|built| &built.path).collect::<Vec<_>>(), ["/t/b", "/t/c"]);
        assert!(found[0].is("example", "b") && found[1].is("bin", "b") && !found[1].is("bin", "a"));
    }

    #[test]
    fn the_toolchain_has_its_own_target() -> Result<()> {
        assert!(has_target(&host()?)?);
        Ok(())
    }

    #[test]
    fn cargo_knows_this_package_as_a_member() -> Result<()> {
        let metadata = Metadata::read()?;
        let names: Vec<_> = metadata.members().map(|package| package.name.as_str()).collect();
        assert!(names.contains(&"xtask"), "{names:?}");
        Ok(())
    }
}
