//! Builds a measuring binary in release and runs it.

use std::ffi::OsString;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use crate::cargo::{self, Metadata};

/// The package of the measuring binaries.
pub const PACKAGE: &str = "dcd-benches";

/// Whether there is a measuring binary of this name.
fn exists(metadata: &Metadata, name: &str) -> bool {
    binaries(metadata).contains(&name)
}

/// Builds the measuring binary `name` in release, runs it where we were called, and gives its exit code.
///
/// # Errors
/// There is no such binary, it does not build or does not start.
pub fn run(name: &str, arguments: &[OsString]) -> Result<ExitCode> {
    let metadata = Metadata::read()?;
    if !exists(&metadata, name) {
        let there = binaries(&metadata);
        bail!("{PACKAGE} has no binary `{name}` among {there:?}");
    }
    let build = ["--release", "--package", PACKAGE, "--bin", name].map(str::to_owned);
    let built = cargo::build(&build).with_context(|| format!("`{name}` does not build"))?;
    let Some(executable) = built.iter().find(|built| built.is("bin", name)) else {
        bail!("cargo built `{name}` but does not say where it is");
    };
    let status = Command::new(&executable.path).args(arguments).status();
    let status = status.with_context(|| format!("cannot start {}", executable.path.display()))?;
    // No code: a signal ended it.
    let code = status.code().map_or(1, |code| u8::try_from(code).unwrap_or(1));
    Ok(ExitCode::from(code))
}

fn binaries(metadata: &Metadata) -> Vec<&str> {
    let package = metadata.member(PACKAGE);
    package.map_or_else(Vec::new, |package| {
        package.targets("bin").map(|target| target.name.as_str()).collect()
    })
}
