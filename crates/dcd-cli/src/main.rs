//! The command `dcd`.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    dcd_cli::run()
}
