//! The program dcd-mpi: built in release, run by mpirun.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

/// The program.
pub(crate) struct Program {
    path: PathBuf,
}

impl Program {
    /// Builds it; nothing where there is no MPI.
    pub(crate) fn build() -> Result<Option<Self>> {
        let there = |command: &str| {
            Command::new(command).arg("--version").output().is_ok_and(|done| done.status.success())
        };
        if !(there("mpirun") && there("mpicc")) {
            eprintln!("-- no mpirun and mpicc: `ranks/check` installs them");
            return Ok(None);
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("ranks");
        let done = Command::new("cargo")
            .args(["build", "--release", "--locked", "--bin", "dcd-mpi", "--manifest-path"])
            .arg(folder.join("Cargo.toml"))
            .arg("--target-dir")
            .arg(folder.join("target"))
            .status()
            .context("cargo does not start")?;
        ensure!(done.success(), "dcd-mpi does not build");
        Ok(Some(Self { path: folder.join("target/release/dcd-mpi") }))
    }

    /// Its report on a scene, as JSON.
    pub(crate) fn detect(&self, ranks: usize, arguments: &[String]) -> Result<Value> {
        let output = Command::new("mpirun")
            .args(["-n", &ranks.to_string()])
            .arg(&self.path)
            .args(["detect", "--json"])
            .args(arguments)
            // More ranks than cores, and in a container as root.
            .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
            .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
            .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
            .output()
            .context("mpirun does not start")?;
        let printed = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "dcd-mpi {arguments:?} at {ranks} ranks: {printed}");
        serde_json::from_slice(&output.stdout).context("dcd-mpi printed no JSON")
    }
}
