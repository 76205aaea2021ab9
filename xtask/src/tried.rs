//! What was tried and what came of it: chores note it, and `cargo xtask reliability` makes `docs/reliability.md` of it.

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Instant;
use zwidth_store::hex_blake3;

/// One thing that was tried many times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tried {
    /// What, in words.
    pub(crate) what: String,
    /// How to try it again.
    pub(crate) command: String,
    /// How often.
    pub(crate) times: u64,
    /// How often a promise was broken.
    pub(crate) broken: u64,
    /// How long it took, s.
    pub(crate) seconds: f64,
}

/// Where the notes lie: beside what cargo builds, one file a thing.
fn folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from).join("tried")
}

/// Notes it in the place of an earlier, shorter try of the same.
pub(crate) fn note(tried: &Tried) -> anyhow::Result<()> {
    let path = folder().join(format!("{}.json", &hex_blake3(tried.what.as_bytes())[..16]));
    let before: Option<Tried> =
        std::fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if before.is_some_and(|before| before.times > tried.times && tried.broken == 0) {
        return Ok(());
    }
    std::fs::create_dir_all(folder())?;
    std::fs::write(&path, serde_json::to_vec_pretty(tried)?)?;
    Ok(())
}

/// Notes what was tried so often since `began` without a promise broken.
pub(crate) fn held(what: &str, command: String, times: u64, began: Instant) -> anyhow::Result<()> {
    let seconds = began.elapsed().as_secs_f64();
    note(&Tried { what: what.to_owned(), command, times, broken: 0, seconds })
}

/// The notes, in order of their words.
fn all() -> anyhow::Result<Vec<Tried>> {
    let mut all = Vec::new();
    let entries = std::fs::read_dir(folder())
        .context("nothing was tried yet: run `cargo xtask soak …` and `cargo xtask fuzz` first")?;
    for entry in entries {
        let path = entry?.path();
        let tried = serde_json::from_slice(&std::fs::read(&path)?)
            .with_context(|| format!("{} is no note", path.display()))?;
        all.push(tried);
    }
    all.sort_by(|a: &Tried, b: &Tried| a.what.cmp(&b.what));
    Ok(all)
}

/// Writes the table into `docs/reliability.md`, between its marks.
pub(crate) fn reliability() -> anyhow::Result<()> {
    const PATH: &str = "docs/reliability.md";
    let text = std::fs::read_to_string(PATH)?;
    std::fs::write(PATH, put(&text, &table(&all()?))?)?;
    Ok(())
}

const BEGIN: &str = "<!-- begin: cargo xtask reliability -->\n";
const END: &str = "<!-- end -->\n";

/// The text with the table between its marks.
fn put(text: &str, table: &str) -> anyhow::Result<String> {
    let (before, rest) =
        text.split_once(BEGIN).context("the page lost the mark at which its table begins")?;
    let (_, after) = rest.split_once(END).context("the page lost the mark at which its table ends")?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}

fn table(all: &[Tried]) -> String {
    let mut text = "| tried | times | promises broken | took | again |\n|---|---|---|---|---|\n".to_owned();
    for Tried { what, command, times, broken, seconds } in all {
        text += &format!("| {what} | {} | {broken} | {} | `{command}` |\n", grouped(*times), took(*seconds));
    }
    text
}

/// 1000000 as 1,000,000.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(",")
}

fn took(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_stands_between_its_marks_and_nothing_else_changes() {
        let tried = Tried {
            what: "a kill".to_owned(),
            command: "cargo xtask soak kill 1000".to_owned(),
            times: 1_234_567,
            broken: 0,
            seconds: 300.0,
        };
        let page = format!("# Title\n{BEGIN}old\n{END}rest\n");
        let made = put(&page, &table(&[tried])).unwrap();
        assert!(made.starts_with("# Title\n") && made.ends_with("rest\n") && !made.contains("old"));
        assert!(
            made.contains("| a kill | 1,234,567 | 0 | 5 min | `cargo xtask soak kill 1000` |\n"),
            "{made}"
        );
        assert!(put("no marks", "").is_err());
    }
}
