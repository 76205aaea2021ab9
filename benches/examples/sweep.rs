//! A large sweep with its time and its memory: `cargo run --release -p zwidth-benches --example
//! sweep -- 1000000 2` for a million trials on two threads. The peak of memory is read where the
//! system tells it (Linux).
#![allow(clippy::print_stdout, clippy::unwrap_used)] // an example may panic

use std::time::Instant;

use zwidth_benches::sweep::sweep;

/// Peak of resident memory in kB, as Linux counts it.
fn peak_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

fn argument(at: usize, fallback: u32) -> u32 {
    std::env::args().nth(at).map_or(fallback, |text| text.parse().unwrap())
}

fn main() {
    let (trials, threads) = (argument(1, 10_000), argument(2, 2));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build().unwrap();
    let start = Instant::now();
    let summary = pool.install(|| sweep(trials)).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let peak = peak_kb().map_or_else(|| "unknown".to_owned(), |kb| format!("{kb} kB"));
    println!(
        "{trials} trials, {threads} threads: {seconds:.2} s, {:.1} us a trial, peak memory {peak}",
        seconds / f64::from(trials) * 1e6
    );
    println!("{summary:?}");
}
