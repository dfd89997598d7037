#![no_main]

use libfuzzer_sys::fuzz_target;

// The fuzzer's own hook aborts at any panic, one that the reader catches from its library included.
// A panic that nobody catches still ends the run.
fuzz_target!(init: std::panic::set_hook(Box::new(|_| {})), |bytes: &[u8]| dcd_fuzz::urdf(bytes));
