//! Speed, measured beside peers in one run: `cargo bench -p zwidth-benches`. No test asserts a
//! time.

pub mod sweep;
