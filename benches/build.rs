//! Hands the compiler and its settings to the library: only the build knows them.
//!
//! The commit is not taken here: a build script is not run again when some other crate changes, so
//! it would go stale. `machine` calls git when it runs.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let set = |name: &str, value: String| println!("cargo::rustc-env={name}={value}");
    let variable = |name: &str| env::var(name).unwrap_or_default();

    let compiler = Command::new(variable("RUSTC"))
        .arg("--version")
        .output()
        .ok()
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .map_or_else(|| "unknown".to_owned(), |version| version.trim().to_owned());
    set("DCD_COMPILER", compiler);
    set("DCD_TARGET", variable("TARGET"));
    set("DCD_TARGET_FEATURES", variable("CARGO_CFG_TARGET_FEATURE"));
    set("DCD_FLAGS", variable("CARGO_ENCODED_RUSTFLAGS").replace('\u{1f}', " "));
    set("DCD_PROFILE", format!("{}, opt-level {}", variable("PROFILE"), variable("OPT_LEVEL")));
}
