//! The header of every result: what it was measured on, and by which build.

use std::env;
use std::fs;
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::options::{Options, cores, workspace};

/// Packages whose versions and features a reader of a timing wants, beside our own.
const PACKAGES_OF_INTEREST: [&str; 7] =
    ["glam", "glamx", "parry3d", "parry3d-f64", "rayon", "simba", "thread_local"];

/// What a result was measured on, and by which build.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The processor's name as the system gives it.
    pub cpu: String,
    /// Cores that the process may use; hardware threads count.
    pub cores: usize,
    /// Threads of the parallel runs.
    pub threads: usize,
    /// System and architecture.
    pub os: String,
    /// SIMD features that the processor offers, whatever the build assumes.
    pub cpu_features: Vec<String>,
    /// The instruction set that our kernels ran on.
    pub simd: String,
    /// `rustc --version` of the build.
    pub compiler: String,
    /// Target triple of the build.
    pub target: String,
    /// SIMD features that the build assumes unchecked.
    pub target_features: Vec<String>,
    /// RUSTFLAGS of the build; empty for none.
    pub flags: String,
    /// Profile and optimisation level of the build.
    pub profile: String,
    /// Our crates and the others that a timing depends on, as resolved, with their features.
    /// Empty where cargo cannot be run.
    pub packages: Vec<String>,
    /// The commit, with `-dirty` behind it if files differ from it; "unknown" without git.
    pub commit: String,
    /// Digest of the running executable: two runs with the same one ran the same code.
    pub executable: String,
    /// Seed of the scenes.
    pub seed: u64,
    /// Whether the scenes and repetitions were cut down.
    pub quick: bool,
}

impl Header {
    /// Queries the machine, the build, git and cargo; what is unavailable is "unknown" or empty.
    ///
    /// Commit and packages are those of the workspace as it stands, hence of this executable only
    /// if it was built just before, as `cargo xtask` does.
    #[must_use]
    pub fn observe(options: &Options) -> Self {
        Self {
            cpu: cpu(),
            cores: cores(),
            threads: options.threads(),
            os: format!("{} {}", env::consts::OS, env::consts::ARCH),
            cpu_features: cpu_features(),
            simd: dcd_simd::Path::best().name().to_owned(),
            compiler: env!("DCD_COMPILER").to_owned(),
            target: env!("DCD_TARGET").to_owned(),
            target_features: list(env!("DCD_TARGET_FEATURES")),
            flags: env!("DCD_FLAGS").to_owned(),
            profile: env!("DCD_PROFILE").to_owned(),
            packages: packages(),
            commit: commit(),
            executable: executable(),
            seed: options.seed,
            quick: options.quick,
        }
    }

    /// Name and value of each line of the header, in the order of reading.
    #[must_use]
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let or_none = |text: String| if text.is_empty() { "none".to_owned() } else { text };
        vec![
            ("CPU", self.cpu.clone()),
            ("cores", self.cores.to_string()),
            ("threads", self.threads.to_string()),
            ("OS", self.os.clone()),
            ("CPU features", or_none(self.cpu_features.join(" "))),
            ("SIMD path", self.simd.clone()),
            ("compiler", self.compiler.clone()),
            ("target", self.target.clone()),
            ("target features", or_none(self.target_features.join(" "))),
            ("flags", or_none(self.flags.clone())),
            ("profile", self.profile.clone()),
            ("packages", or_none(self.packages.join("; "))),
            ("commit", self.commit.clone()),
            ("executable", self.executable.clone()),
            ("seed", self.seed.to_string()),
            ("effort", if self.quick { "quick" } else { "full" }.to_owned()),
        ]
    }

    /// One line that two runs share exactly when the numbers of one may stand beside the other's.
    #[must_use]
    pub fn fingerprint(&self) -> String {
        let mut line = String::new();
        for (name, value) in self.lines() {
            line.push_str(&format!("{name}={value}|"));
        }
        line
    }
}

fn cpu() -> String {
    let named = fs::read_to_string("/proc/cpuinfo").ok().and_then(|info| {
        let line = info.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    named
        .or_else(|| output(Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"])))
        .unwrap_or_else(|| "unknown".to_owned())
}

/// The features that the lanes choose by.
fn cpu_features() -> Vec<String> {
    let mut features: Vec<String> = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        let mut note = |name: &str, present: bool| {
            if present {
                features.push(name.to_owned());
            }
        };
        note("sse4.2", is_x86_feature_detected!("sse4.2"));
        note("avx", is_x86_feature_detected!("avx"));
        note("avx2", is_x86_feature_detected!("avx2"));
        note("fma", is_x86_feature_detected!("fma"));
        note("bmi1", is_x86_feature_detected!("bmi1"));
        note("bmi2", is_x86_feature_detected!("bmi2"));
        note("lzcnt", is_x86_feature_detected!("lzcnt"));
        note("popcnt", is_x86_feature_detected!("popcnt"));
        note("avx512f", is_x86_feature_detected!("avx512f"));
        note("avx512bw", is_x86_feature_detected!("avx512bw"));
        note("avx512dq", is_x86_feature_detected!("avx512dq"));
        note("avx512vl", is_x86_feature_detected!("avx512vl"));
    }
    #[cfg(target_arch = "aarch64")]
    features.push("neon".to_owned());
    features
}

fn commit() -> String {
    let arguments = ["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"];
    output(Command::new("git").arg("-C").arg(workspace()).args(arguments))
        .unwrap_or_else(|| "unknown".to_owned())
}

fn packages() -> Vec<String> {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let tree = output(Command::new(cargo).current_dir(workspace()).args([
        "tree",
        "--offline",
        "--quiet",
        "--package=dcd-benches",
        "--edges=normal",
        "--prefix=none",
        "--format={p}|{f}",
    ]));
    tree.map_or_else(Vec::new, |tree| packages_of_tree(&tree))
}

/// From lines `name vVERSION (path)|feature,feature` to sorted `name VERSION (feature feature)`.
fn packages_of_tree(tree: &str) -> Vec<String> {
    let mut found: Vec<String> = tree
        .lines()
        .filter_map(|line| {
            let (package, features) = line.split_once('|')?;
            let mut words = package.split(' ');
            let (name, version) = (words.next()?, words.next()?.trim_start_matches('v'));
            if !name.starts_with("dcd-") && !PACKAGES_OF_INTEREST.contains(&name) {
                return None;
            }
            // Cargo writes " (*)" behind a package that it has listed before.
            let features = features.trim_end_matches(" (*)").replace(',', " ");
            Some(if features.is_empty() {
                format!("{name} {version}")
            } else {
                format!("{name} {version} ({features})")
            })
        })
        .collect();
    found.sort();
    found.dedup();
    found
}

fn executable() -> String {
    let bytes = env::current_exe().and_then(fs::read);
    bytes.map_or_else(|_| "unknown".to_owned(), |bytes| format!("{:016x}", fnv1a(&bytes)))
}

/// FNV-1a, 64 bits (Fowler, Noll, Vo): it need not resist an adversary, only distinguish builds.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// What a command prints, if it exists, succeeds and prints anything.
fn output(command: &mut Command) -> Option<String> {
    let output = command.output().ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (!text.is_empty()).then_some(text)
}

fn list(commas: &str) -> Vec<String> {
    commas.split(',').filter(|item| !item.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_names_the_compiler_and_the_options() {
        let options = Options { quick: true, seed: 42, ..Options::default() };
        let header = Header::observe(&options);
        assert!(header.compiler.starts_with("rustc "), "{}", header.compiler);
        assert!(header.quick && header.seed == 42 && header.threads == cores());
        assert_eq!(header.executable.len(), 16);
    }

    #[test]
    fn another_seed_has_another_fingerprint() {
        let header = |seed| Header::observe(&Options { seed, ..Options::default() });
        assert_eq!(header(1).fingerprint(), header(1).fingerprint());
        assert_ne!(header(1).fingerprint(), header(2).fingerprint());
    }

    #[test]
    fn packages_are_listed_once_with_their_features() {
        let tree = "dcd-benches v0.1.0 (/somewhere)|\nserde v1.0.0|std\n\
                    glam v0.33.7|default,std\nglam v0.33.7|default,std (*)\n";
        assert_eq!(packages_of_tree(tree), ["dcd-benches 0.1.0", "glam 0.33.7 (default std)"]);
    }

    #[test]
    fn the_digest_is_the_published_fnv1a() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
    }

    #[test]
    fn a_command_that_is_not_there_gives_nothing() {
        assert_eq!(output(&mut Command::new("no-such-command-as-this")), None);
    }
}
