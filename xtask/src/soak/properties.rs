//! Fresh cases for every random property: `cargo test` draws the same cases each time
//! (`.cargo/config.toml`); this chore draws others.

use crate::shell::cargo;
use crate::tried::held;
use anyhow::ensure;
use std::time::Instant;

/// The properties of the dynamics draw so many times the cases of the others
/// (`solve::properties::many`).
const DYNAMICS: u32 = 40;

/// Runs every unit test with the properties' seed and count changed. A failure prints its smallest
/// case, to be kept as a test with a name beside the property.
pub(crate) fn properties(cases: u32, seed: u64) -> anyhow::Result<()> {
    ensure!(cases >= DYNAMICS, "{cases} cases are fewer than {DYNAMICS}, one for the others");
    println!(
        "{cases} cases a property of the dynamics, {} of the others, seed {seed}",
        cases / DYNAMICS
    );
    let began = Instant::now();
    let cases_of_others = (cases / DYNAMICS).to_string();
    cargo(
        "test --workspace --locked --lib --bins",
        &[],
        &[("PROPTEST_CASES", cases_of_others), ("PROPTEST_RNG_SEED", seed.to_string())],
        &format!("a property fails with seed {seed}: keep its smallest case as a test with a name"),
    )?;
    let what = "fresh random cases for each property of the dynamics";
    held(what, format!("cargo xtask soak properties {cases}"), cases.into(), began)
}
