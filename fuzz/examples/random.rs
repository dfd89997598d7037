//! Random bytes for the targets about pairs, frames and batches, where no fuzzer is installed: `cargo run
//! --release --example random -- SECONDS`.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

fn main() {
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |now| now.as_nanos() as u64);
    let mut seed = now | 1;
    let (begun, mut inputs) = (Instant::now(), 0u64);
    println!("seed {seed}");
    while begun.elapsed() < Duration::from_secs(seconds) {
        let length = 64 + (next(&mut seed) % 1024) as usize;
        let bytes: Vec<u8> = (0..length).map(|_| (next(&mut seed) >> 32) as u8).collect();
        dcd_fuzz::overlap(&bytes);
        dcd_fuzz::measures(&bytes);
        dcd_fuzz::probe(&bytes);
        dcd_fuzz::frames(&bytes);
        inputs += 1;
    }
    println!("{inputs} inputs");
}

/// xorshift64*.
fn next(seed: &mut u64) -> u64 {
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    seed.wrapping_mul(0x2545_f491_4f6c_dd1d)
}
