//! `cargo xtask hx711 COMMAND…`: our reader at the sketch of a load cell, which COMMAND runs in an
//! emulator with an HX711 at its pins.

use crate::emulator::Emulator;
use anyhow::{Context as _, ensure};
use zwidth_link::Settings;
use zwidth_link::text::{Field, Lines};

/// What `rig.toml` says of it: the table of docs/rig.md.
const RIG: &str = "newtons_per_count = 1\n[hx711]\nport = \"/dev/cell\"\nline = \"={hx711}\"";
/// Values that it is given, and for how long each, µs: two of the chip's.
const VALUES: u32 = 400;
const EACH_US: u32 = 25_000;
/// Both ends of its range come first.
const ENDS: [i32; 4] = [0x7F_FFFF, -0x80_0000, 0, -1];

/// Every value arrives, in its order, as often as the chip gives one, and no other.
pub(crate) fn run(command: &[&str]) -> anyhow::Result<()> {
    let mut emulator = Emulator::start(command)?;
    let settings: Settings = toml::from_str(RIG)?;
    let template = settings.hx711.context("no table [hx711]")?.template()?;
    let mut lines = Lines::from_anywhere();
    let mut printed = Vec::new();
    let values: Vec<i32> = (0..VALUES).map(value).collect();
    for value in &values {
        emulator.set("force", *value)?;
        emulator.run(EACH_US, &[])?;
        for byte in std::mem::take(&mut emulator.said) {
            let Some(line) = lines.push(byte) else { continue };
            let told = template.read(line).and_then(|values| values.get(Field::Hx711));
            let counts = told.with_context(|| {
                format!("{:?} is no line of it", line.escape_ascii().to_string())
            })?;
            printed.push(i32::try_from(counts)?);
        }
    }
    let rate_hz = printed.len() as f64 / (f64::from(VALUES * (EACH_US / 1000)) * 1e-3);
    ensure!((79.0..81.0).contains(&rate_hz), "{rate_hz} values a second");
    ensure!(lines.damaged() == 0, "{} lines are damaged", lines.damaged());
    printed.dedup();
    // The reader begins anywhere, so the first line is none to it.
    let from = values.iter().position(|value| printed.first() == Some(value));
    let from = from.filter(|from| *from < 2).context("the first value is missing")?;
    let arrived = printed.iter().zip(&values[from..]).take_while(|(a, b)| a == b).count();
    ensure!(arrived + 2 >= values.len() - from, "{arrived} of {VALUES} values arrived in order");
    println!("{VALUES} values by an HX711, {rate_hz:.1} a second, none lost, none changed");
    Ok(())
}

/// Each differs from the one before.
fn value(i: u32) -> i32 {
    ENDS.get(i as usize).copied().unwrap_or(i as i32 * 7919 % 0x80_0000 - 0x40_0000)
}
