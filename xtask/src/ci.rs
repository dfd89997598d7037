//! The checks, in order, up to the first that fails; the cheapest first.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};

use crate::cargo::{self, Metadata, cargo};
use crate::{measure, policy};

type Check = fn() -> Result<()>;

/// Runs all checks but the tests.
///
/// # Errors
/// The first check that fails, by name.
pub fn run() -> Result<()> {
    let checks: [(&str, Check); 8] = [
        ("format", format),
        ("dependency policy", dependency_policy),
        ("clippy", clippy),
        ("other processors", other_processors),
        ("docs", docs),
        ("examples", examples),
        ("quick measurements", quick_measurements),
        ("fuzzing", fuzzing),
    ];
    let start = Instant::now();
    for (name, check) in checks {
        eprintln!("== {name}");
        let begin = Instant::now();
        check().with_context(|| format!("the check `{name}` failed"))?;
        eprintln!("== {name}: passed in {:.0?}", begin.elapsed());
    }
    eprintln!("== all checks passed in {:.0?}", start.elapsed());
    Ok(())
}

fn format() -> Result<()> {
    cargo::shown(cargo().args(["fmt", "--all", "--check"]))
        .context("run `cargo fmt --all` (or `rustup component add rustfmt`)")
}

fn dependency_policy() -> Result<()> {
    let breaches = policy::breaches()?;
    ensure!(breaches.is_empty(), "\n  {}", breaches.join("\n  "));
    Ok(())
}

fn clippy() -> Result<()> {
    let all = ["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"];
    cargo::shown(cargo().args(all))
}

/// Targets without our intrinsics, on which the portable path is all there is.
const PORTABLE: [&str; 2] = ["aarch64-unknown-linux-gnu", "wasm32-unknown-unknown"];

/// That the rooms of a step compile for other processors, as far as the toolchain has them.
fn other_processors() -> Result<()> {
    for target in PORTABLE {
        if !cargo::has_target(target)? {
            eprintln!("-- {target}: skipped, `rustup target add {target}` would install it");
            continue;
        }
        eprintln!("-- {target}");
        let mut command = cargo();
        command.args(["check", "--quiet", "--target", target]);
        for room in policy::ROOMS {
            command.args(["--package", room]);
        }
        cargo::shown(&mut command)?;
    }
    Ok(())
}

fn docs() -> Result<()> {
    let mut command = cargo();
    command.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    cargo::shown(&mut command)
}

/// Builds all examples at once, so that what they share is built once, then runs each.
fn examples() -> Result<()> {
    let metadata = Metadata::read()?;
    let mut build = vec!["--release".to_owned(), "--examples".to_owned()];
    let mut names = Vec::new();
    for package in metadata.members() {
        let examples: Vec<_> = package.targets("example").collect();
        if examples.is_empty() {
            continue;
        }
        build.extend(["--package".to_owned(), package.name.clone()]);
        for example in examples {
            names.push(example.name.as_str());
            for feature in &example.required_features {
                build.extend(["--features".to_owned(), format!("{}/{feature}", package.name)]);
            }
        }
    }
    if names.is_empty() {
        eprintln!("the workspace has no examples");
        return Ok(());
    }
    let built = cargo::build(&build).context("the examples do not build")?;
    for name in names {
        let Some(example) = built.iter().find(|built| built.name == name) else {
            bail!("cargo built the example `{name}` but does not say where it is");
        };
        eprintln!("-- {name}");
        cargo::shown(Command::new(&example.path).current_dir(cargo::root()))
            .with_context(|| format!("the example `{name}` failed"))?;
    }
    Ok(())
}

/// Each measuring binary with `--quick`, `accuracy` if it exists: that they run and that what they
/// check holds, not how fast they are.
fn quick_measurements() -> Result<()> {
    let metadata = Metadata::read()?;
    for name in ["bench", "compare", "meshes", "batch", "frames", "scale", "accuracy"] {
        if name == "accuracy" && !measure::exists(&metadata, name) {
            eprintln!("-- {name}: there is no such binary yet");
            continue;
        }
        eprintln!("-- {name} --quick");
        let code = measure::run(name, &["--quick".into()])?;
        ensure!(code == std::process::ExitCode::SUCCESS, "`{name} --quick` failed: {code:?}");
    }
    Ok(())
}

/// How long each fuzz target runs, in seconds: long enough to meet what a change breaks at once.
const FUZZED: &str = "5";

/// The fuzz package, which is no member: its format, that it compiles, and each target for a few
/// seconds where cargo-fuzz is installed.
fn fuzzing() -> Result<()> {
    let manifest = ["--manifest-path", "fuzz/Cargo.toml"];
    cargo::shown(cargo().arg("fmt").args(manifest).arg("--check"))?;
    // The workspace's own target folder, so that what it has built serves here too.
    let folder = Metadata::read()?.target_directory;
    let mut clippy = cargo();
    clippy.arg("clippy").args(manifest).args(["--lib", "--examples", "--target-dir"]);
    cargo::shown(clippy.arg(folder).args(["--", "--deny", "warnings"]))?;
    let installed = cargo().args(["fuzz", "--version"]).output();
    if !installed.is_ok_and(|output| output.status.success()) {
        eprintln!("-- cargo-fuzz is not installed: no target is run");
        return Ok(());
    }
    cargo::shown(Command::new("fuzz/run").arg(FUZZED).current_dir(cargo::root()))
}
