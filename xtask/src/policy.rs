//! Which crate may depend on what, as the layout of the workspace promises it.

use anyhow::{Context, Result};

use crate::cargo::{Metadata, cargo, printed};
use crate::license::is_permissive;

/// Crates that know no threads; whoever needs one pair's answer depends on these alone.
const WITHOUT_THREADS: [&str; 3] = ["dcd-simd", "dcd-geom", "dcd-gjk"];
/// The crates of a step. They know no Parry: it is a rival, behind traits of its own.
pub const STEP_CRATES: [&str; 7] =
    ["dcd-simd", "dcd-geom", "dcd-gjk", "dcd-bvh", "dcd-broad", "dcd-exec", "dcd-pipeline"];
/// The only crate with `unsafe`.
const WITH_UNSAFE: &str = "dcd-simd";
/// What gives them input and judges them: no Parry either, so that neither depends on a rival.
const INPUT_AND_JUDGE: [&str; 5] = ["dcd-io", "dcd-moveit", "dcd-robot", "dcd-scenes", "dcd-judge"];
/// The only crate with threads.
const WITH_THREADS: &str = "dcd-exec";
/// What makes threads.
const THREADS: [&str; 2] = ["rayon", "thread_local"];

/// Every breach of the policy, as a sentence; none if it is kept.
///
/// # Errors
/// Cargo cannot say what depends on what.
pub fn breaches() -> Result<Vec<String>> {
    let metadata = Metadata::read()?;
    let mut breaches = [
        missing_crates(&metadata),
        versions_of_glam(&metadata),
        licences(&metadata),
        manifests_with_threads(&metadata),
        targets_that_allow_unsafe(&metadata)?,
    ]
    .concat();
    let present = |name: &&str| metadata.member(name).is_some();
    for name_of in STEP_CRATES.into_iter().chain(INPUT_AND_JUDGE).filter(present) {
        let tree = normal_dependencies(name_of)?;
        breaches.extend(foreigners(name_of, &tree));
    }
    Ok(breaches)
}

/// A crate that was renamed would else slip out of the policy.
fn missing_crates(metadata: &Metadata) -> Vec<String> {
    let all = STEP_CRATES.into_iter().chain(INPUT_AND_JUDGE);
    let missing = all.filter(|name_of| metadata.member(name_of).is_none());
    missing.map(|name_of| format!("the workspace has no package {name_of}")).collect()
}

fn versions_of_glam(metadata: &Metadata) -> Vec<String> {
    let of_glam = metadata.packages.iter().filter(|package| package.name == "glam");
    let versions: Vec<&str> = of_glam.map(|package| package.version.as_str()).collect();
    match versions[..] {
        [_] => Vec::new(),
        _ => vec![format!("exactly one glam belongs in the tree, not {versions:?}")],
    }
}

fn licences(metadata: &Metadata) -> Vec<String> {
    let mut breaches = Vec::new();
    for package in &metadata.packages {
        let license = package.license.as_deref().unwrap_or("none stated");
        if !is_permissive(license) {
            breaches.push(format!(
                "the licence of {} {} is not permissive: {license}",
                package.name, package.version
            ));
        }
    }
    breaches
}

fn manifests_with_threads(metadata: &Metadata) -> Vec<String> {
    let in_crates = |path: &std::path::Path| {
        let folder = path.parent().and_then(std::path::Path::parent);
        folder.is_some_and(|folder| folder.ends_with("crates"))
    };
    let mut breaches = Vec::new();
    for crate_ in metadata.members().filter(|package| in_crates(&package.manifest_path)) {
        for threads in THREADS {
            let named = crate_.dependencies.iter().any(|dependency| dependency.name == threads);
            if named != (crate_.name == WITH_THREADS) {
                let does = if named { "names" } else { "does not name" };
                breaches.push(format!(
                    "{}: {} {does} {threads}, which belongs to {WITH_THREADS} alone",
                    crate_.manifest_path.display(),
                    crate_.name
                ));
            }
        }
    }
    breaches
}

/// Libraries and binaries whose source does not forbid `unsafe`, but for the one crate that has it.
fn targets_that_allow_unsafe(metadata: &Metadata) -> Result<Vec<String>> {
    let mut breaches = Vec::new();
    for package in metadata.members().filter(|package| package.name != WITH_UNSAFE) {
        for target in package.targets("lib").chain(package.targets("bin")) {
            let path = &target.src_path;
            let source = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            if !source.lines().any(|line| line == "#![forbid(unsafe_code)]") {
                breaches.push(format!("{} does not forbid unsafe code", path.display()));
            }
        }
    }
    Ok(breaches)
}

/// Names of all packages that a build of `name_of` alone brings in, itself included.
fn normal_dependencies(name_of: &str) -> Result<Vec<String>> {
    let arguments = ["--quiet", "--edges=normal", "--prefix=none", "--format={p}"];
    let tree = printed(cargo().args(["tree", "--package", name_of]).args(arguments))
        .with_context(|| format!("the dependencies of {name_of}"))?;
    let name = |line: &str| line.split(' ').next().unwrap_or(line).to_owned();
    Ok(tree.lines().map(name).collect())
}

fn foreigners(name_of: &str, tree: &[String]) -> Vec<String> {
    let has_threads = |name: &str| WITHOUT_THREADS.contains(&name_of) && THREADS.contains(&name);
    let mut names: Vec<&String> = tree.iter().collect();
    names.sort();
    names.dedup();
    names
        .into_iter()
        .filter(|name| name.starts_with("parry") || has_threads(name))
        .map(|name| format!("{name_of} must not depend on {name}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workspace_keeps_its_dependency_policy() -> Result<()> {
        assert_eq!(breaches()?, Vec::<String>::new());
        Ok(())
    }

    #[test]
    fn the_crate_with_threads_is_seen_to_have_them() -> Result<()> {
        let tree = normal_dependencies(WITH_THREADS)?;
        assert!(THREADS.iter().all(|threads| tree.iter().any(|name| name == threads)), "{tree:?}");
        Ok(())
    }

    fn metadata(glams: &[&str], named_by: &str) -> Result<Metadata> {
        let package = |name: &str, version: &str, dependencies: &[&str]| {
            let dependency = |name: &&str| serde_json::json!({ "name": name });
            serde_json::json!({
                "id": format!("{name} {version}"), "name": name, "version": version, "license": "MIT",
                "manifest_path": format!("/w/crates/{name}/Cargo.toml"), "targets": [],
                "dependencies": dependencies.iter().map(dependency).collect::<Vec<_>>(),
            })
        };
        let mut packages: Vec<_> =
            glams.iter().map(|version| package("glam", version, &[])).collect();
        for name_of in ["dcd-exec", "dcd-gjk"] {
            let named: &[&str] = if name_of == named_by { &THREADS } else { &[] };
            packages.push(package(name_of, "0.1.0", named));
        }
        let members = ["dcd-exec 0.1.0", "dcd-gjk 0.1.0"];
        let value = serde_json::json!({ "packages": packages, "workspace_members": members });
        Ok(serde_json::from_value(value)?)
    }

    #[test]
    fn no_glam_and_two_glams_are_breaches() -> Result<()> {
        assert!(versions_of_glam(&metadata(&["0.33.7"], "dcd-exec")?).is_empty());
        assert_eq!(versions_of_glam(&metadata(&["0.30.0", "0.33.7"], "dcd-exec")?).len(), 1);
        assert_eq!(versions_of_glam(&metadata(&[], "dcd-exec")?).len(), 1);
        Ok(())
    }

    #[test]
    fn threads_named_outside_their_crate_are_a_breach() -> Result<()> {
        assert!(manifests_with_threads(&metadata(&[], "dcd-exec")?).is_empty());
        let breaches = manifests_with_threads(&metadata(&[], "dcd-gjk")?);
        assert_eq!(breaches.len(), 4, "two that have them, two that lack them: {breaches:?}");
        Ok(())
    }

    #[test]
    fn a_target_that_does_not_forbid_unsafe_is_a_breach() -> Result<()> {
        let folder = std::env::temp_dir().join(format!("dcd-policy-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let mut seen = Vec::new();
        for source in ["#![forbid(unsafe_code)]\n", "// #![forbid(unsafe_code)]\n"] {
            let path = folder.join("lib.rs");
            std::fs::write(&path, source)?;
            let mut metadata = metadata(&[], "dcd-exec")?;
            for package in &mut metadata.packages {
                let target = serde_json::json!({ "name": "x", "kind": ["lib"], "src_path": path });
                package.targets = vec![serde_json::from_value(target)?];
            }
            seen.push(targets_that_allow_unsafe(&metadata)?.len());
        }
        std::fs::remove_dir_all(&folder)?;
        assert_eq!(seen, [0, 2]);
        Ok(())
    }

    #[test]
    fn a_licence_that_is_not_stated_is_a_breach() -> Result<()> {
        let mut metadata = metadata(&["0.33.7"], "dcd-exec")?;
        assert!(licences(&metadata).is_empty());
        metadata.packages[0].license = None;
        assert_eq!(
            licences(&metadata),
            ["the licence of glam 0.33.7 is not permissive: none stated"]
        );
        Ok(())
    }

    #[test]
    fn threads_and_parry_are_foreign_where_the_layout_says_so() {
        let tree = ["rayon", "parry3d", "glam", "rayon"].map(str::to_owned);
        assert_eq!(
            foreigners("dcd-gjk", &tree),
            ["dcd-gjk must not depend on parry3d", "dcd-gjk must not depend on rayon"]
        );
        assert_eq!(foreigners("dcd-pipeline", &tree), ["dcd-pipeline must not depend on parry3d"]);
    }
}
