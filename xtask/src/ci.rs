//! The checks, in order, up to the first that fails; the cheapest first.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::cargo::{self, Executable, Metadata, cargo};
use crate::policy;

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

/// That the crates of a step compile for other processors, as far as the toolchain has them.
fn other_processors() -> Result<()> {
    for target in PORTABLE {
        if !cargo::has_target(target)? {
            eprintln!("-- {target}: skipped, `rustup target add {target}` would install it");
            continue;
        }
        eprintln!("-- {target}");
        let mut command = cargo();
        command.args(["check", "--quiet", "--target", target]);
        for name_of in policy::STEP_CRATES {
            command.args(["--package", name_of]);
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

/// Builds all examples and binaries at once, as the tests are built: optimized, with debug assertions.
/// So nothing is compiled twice, neither between the checks nor by `cargo test --workspace`.
fn build_all(metadata: &Metadata) -> Result<Vec<Executable>> {
    let all = ["--profile", "test", "--workspace", "--bins", "--examples"];
    let mut build = all.map(str::to_owned).to_vec();
    for package in metadata.members() {
        let features = package.targets("example").flat_map(|example| &example.required_features);
        for feature in features {
            build.extend(["--features".to_owned(), format!("{}/{feature}", package.name)]);
        }
    }
    cargo::build(&build).context("the examples and binaries do not build")
}

fn find<'a>(built: &'a [Executable], kind: &str, name: &str) -> Result<&'a Executable> {
    let found = built.iter().find(|built| built.is(kind, name));
    found.with_context(|| format!("cargo built the {kind} `{name}` but does not say where it is"))
}

fn examples() -> Result<()> {
    let metadata = Metadata::read()?;
    let built = build_all(&metadata)?;
    for example in metadata.members().flat_map(|package| package.targets("example")) {
        let name = &example.name;
        eprintln!("-- {name}");
        let example = find(&built, "example", name)?;
        cargo::shown(Command::new(&example.path).current_dir(cargo::root()))
            .with_context(|| format!("the example `{name}` failed"))?;
    }
    Ok(())
}

/// Each measuring binary with `--quick`: that they run and that what they check holds, not how fast they
/// are.
fn quick_measurements() -> Result<()> {
    let metadata = Metadata::read()?;
    let built = build_all(&metadata)?;
    for name in ["bench", "compare", "meshes", "batch", "frames", "scale", "accuracy"] {
        eprintln!("-- {name} --quick");
        let binary = find(&built, "bin", name)?;
        cargo::shown(Command::new(&binary.path).arg("--quick"))
            .with_context(|| format!("`{name} --quick` failed"))?;
    }
    Ok(())
}

/// How long each fuzz target runs, in seconds: long enough to meet what a change breaks at once.
const FUZZED: &str = "10";

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
