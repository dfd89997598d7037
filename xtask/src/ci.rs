//! The checks, in order, up to the first that fails; the cheapest first.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::cargo::{self, Executable, Metadata, cargo};
use crate::policy;

/// A check returns what it skipped, with the reason: a sentence each.
type Check = fn() -> Result<Vec<String>>;

/// Runs all checks but the tests.
///
/// # Errors
/// The first check that fails, by name.
pub fn run() -> Result<()> {
    let checks: [(&str, Check); 10] = [
        ("format", format),
        ("dependency policy", dependency_policy),
        ("clippy", clippy),
        ("features", features),
        ("other processors", other_processors),
        ("docs", docs),
        ("packages", packages),
        ("examples", examples),
        ("quick measurements", quick_measurements),
        ("fuzzing", fuzzing),
    ];
    let start = Instant::now();
    let mut skipped = Vec::new();
    for (name, check) in checks {
        eprintln!("== {name}");
        let begin = Instant::now();
        let left_out = check().with_context(|| format!("the check `{name}` failed"))?;
        skipped.extend(left_out.into_iter().map(|what| format!("{name}: {what}")));
        eprintln!("== {name}: passed in {:.0?}", begin.elapsed());
    }
    eprintln!("== all checks passed in {:.0?}", start.elapsed());
    for what in skipped {
        eprintln!("-- skipped: {what}");
    }
    Ok(())
}

fn format() -> Result<Vec<String>> {
    cargo::shown(cargo().args(["fmt", "--all", "--check"]))
        .context("run `cargo fmt --all` (or `rustup component add rustfmt`)")?;
    Ok(Vec::new())
}

fn dependency_policy() -> Result<Vec<String>> {
    let breaches = policy::breaches()?;
    ensure!(breaches.is_empty(), "\n  {}", breaches.join("\n  "));
    Ok(Vec::new())
}

fn clippy() -> Result<Vec<String>> {
    let all = ["clippy", "--workspace", "--all-targets", "--", "--deny", "warnings"];
    cargo::shown(cargo().args(all))?;
    Ok(Vec::new())
}

/// Features that no crate of the workspace turns on: their tests, and that the front compiles with them.
fn features() -> Result<Vec<String>> {
    let tests = ["test", "--quiet", "--package", "dcd-geom", "--features", "serde,mint", "--lib"];
    // Built for this check alone.
    cargo::shown(cargo().args(tests).env("CARGO_PROFILE_TEST_OPT_LEVEL", "0"))?;
    let front = ["check", "--quiet", "--package", "dcd-pipeline", "--features", "serde,mint"];
    cargo::shown(cargo().args(front))?;
    Ok(Vec::new())
}

/// Targets without our intrinsics, on which the portable path is all there is.
const PORTABLE: [&str; 2] = ["aarch64-unknown-linux-gnu", "wasm32-unknown-unknown"];

/// That the crates of a step compile for other processors, as far as the toolchain has them.
fn other_processors() -> Result<Vec<String>> {
    let mut skipped = Vec::new();
    for target in PORTABLE {
        if !cargo::has_target(target)? {
            skipped.push(format!("{target}: `rustup target add {target}` would install it"));
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
    Ok(skipped)
}

fn docs() -> Result<Vec<String>> {
    let mut command = cargo();
    command.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    cargo::shown(&mut command)?;
    Ok(Vec::new())
}

/// That every crate could be published as it stands, short of building it once more from its package.
fn packages() -> Result<Vec<String>> {
    let dry = ["publish", "--workspace", "--dry-run", "--no-verify", "--allow-dirty", "--quiet"];
    cargo::shown(cargo().args(dry))?;
    Ok(Vec::new())
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

fn examples() -> Result<Vec<String>> {
    let metadata = Metadata::read()?;
    let built = build_all(&metadata)?;
    for example in metadata.members().flat_map(|package| package.targets("example")) {
        let name = &example.name;
        eprintln!("-- {name}");
        let example = find(&built, "example", name)?;
        cargo::shown(Command::new(&example.path).current_dir(cargo::root()))
            .with_context(|| format!("the example `{name}` failed"))?;
    }
    Ok(Vec::new())
}

/// Each measuring binary with `--quick`: that they run and that what they check holds, not how fast they
/// are.
fn quick_measurements() -> Result<Vec<String>> {
    let metadata = Metadata::read()?;
    let built = build_all(&metadata)?;
    // Each with what makes it smaller still: Parry takes most of the time of a scene that is compared.
    let runs: [(&str, &[&str]); 11] = [
        ("bench", &[]),
        ("compare", &["--n", "1000"]),
        ("meshes", &[]),
        ("batch", &[]),
        ("frames", &[]),
        ("scale", &[]),
        ("accuracy", &[]),
        ("questions", &[]),
        ("ranks", &[]),
        ("rays", &[]),
        ("robots", &[]),
    ];
    for (name, smaller) in runs {
        eprintln!("-- {name} --quick {}", smaller.join(" "));
        let binary = find(&built, "bin", name)?;
        cargo::shown(Command::new(&binary.path).arg("--quick").args(smaller))
            .with_context(|| format!("`{name} --quick` failed"))?;
    }
    Ok(Vec::new())
}

/// How long each fuzz target runs, in seconds: long enough to meet what a change breaks at once.
const FUZZED: &str = "10";

/// The fuzz package, which is no member: its format, that it compiles, and each target for a few
/// seconds where cargo-fuzz is installed.
fn fuzzing() -> Result<Vec<String>> {
    let manifest = ["--manifest-path", "fuzz/Cargo.toml"];
    cargo::shown(cargo().arg("fmt").args(manifest).arg("--check"))?;
    // The workspace's own target folder, so that what it has built serves here too.
    let folder = Metadata::read()?.target_directory;
    let mut clippy = cargo();
    clippy.arg("clippy").args(manifest).args(["--lib", "--examples", "--target-dir"]);
    cargo::shown(clippy.arg(folder).args(["--", "--deny", "warnings"]))?;
    let installed = cargo().args(["fuzz", "--version"]).output();
    if !installed.is_ok_and(|output| output.status.success()) {
        return Ok(vec![
            "no target is run: `cargo install cargo-fuzz` would install it".to_owned(),
        ]);
    }
    cargo::shown(Command::new("fuzz/run").arg(FUZZED).current_dir(cargo::root()))?;
    Ok(Vec::new())
}
