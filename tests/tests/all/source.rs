//! What the sources promise of themselves: one seed, handles on `raw/`, where modules lie.

use crate::folders::{files, workspace};
use std::fs;
use std::path::{Path, PathBuf};

/// Sources below a place, but for tests, benches and examples.
fn sources(place: &Path) -> Vec<PathBuf> {
    let mut sources = files(place, "rs");
    sources.retain(|p| p.iter().any(|part| part == "src"));
    sources
}

/// The modules that a source declares for tests only: `#[cfg(test)]`, and `mod name;` on the next
/// line.
fn test_modules(text: &str) -> Vec<&str> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let pairs = lines.windows(2).filter(|w| w[0] == "#[cfg(test)]");
    pairs.filter_map(|w| Some(w[1].strip_suffix(';')?.split_once("mod ")?.1)).collect()
}

/// A source without its comments and without the module of tests at its end.
fn code(text: &str) -> String {
    let before_tests = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let without_comment = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    before_tests.lines().map(without_comment).collect::<Vec<_>>().join("\n")
}

#[test]
fn modules_of_tests_are_told_from_others() {
    let text = "mod a;\n#[cfg(test)]\nmod real_data;\n#[cfg(test)]\npub(crate) mod b;\n#[cfg(test)]\nuse x::y;\nmod c;";
    assert_eq!(test_modules(text), ["real_data", "b"]);
    assert_eq!(code("a // std::fs\nb\n#[cfg(test)]\nmod tests {\nstd::fs"), "a \nb");
}

/// `.cargo/config.toml` gives proptest its seed, and no property chooses another.
#[test]
fn every_random_property_draws_from_one_seed() {
    assert!(
        std::env::var("PROPTEST_RNG_SEED").is_ok(),
        "cargo sets no seed: is .cargo/config.toml there?"
    );
    let mut properties = 0;
    for path in files(&workspace().join("crates"), "rs") {
        let text = fs::read_to_string(&path).unwrap();
        assert!(!text.contains("rng_seed"), "{} chooses a seed of its own", path.display());
        properties += text.matches("proptest! {").count();
    }
    assert!(properties >= 6, "only {properties} blocks of properties: were they found?");
}

/// Which command holds which handle on `raw/` (`zwidth_store::Raw`); none writes there without.
#[test]
fn only_the_commands_that_may_hold_a_handle_that_writes_below_raw() {
    let commands = workspace().join("crates/zwidth/src/commands");
    let holders = |handle: &str| -> Vec<String> {
        let holds = |path: &PathBuf| code(&fs::read_to_string(path).unwrap()).contains(handle);
        let name = |path: &PathBuf| {
            let name = path.strip_prefix(&commands).unwrap().with_extension("");
            name.to_str().unwrap().to_owned()
        };
        let mut found: Vec<String> =
            files(&commands, "rs").iter().filter(|p| holds(p)).map(name).collect();
        found.sort();
        found
    };
    assert_eq!(holders("Raw::mends("), ["import", "recover"]);
    assert_eq!(
        holders("Raw::adds("),
        [
            "acquire",
            "beside",
            "characterise",
            "metric",
            "power",
            "recover",
            "said/answers",
            "said/mod",
            "twin",
            "unseal"
        ]
    );
    assert_eq!(holders("Raw::new_study("), ["new", "twin"]);
    // The disk itself is handed to what only reads, to the two handles, and to the output of
    // `simulate`, `trade`, `ladder`, `stability`, `open` and `export`, which have folders of their own; what
    // somebody allows lies in a folder of the user's.
    let writes = writes_without_handle();
    let others = ["commands/output.rs", "commands/consent.rs"];
    let is_other = |path: &&PathBuf| others.iter().any(|own| path.ends_with(own));
    for path in files(&commands, "rs").iter().filter(|path| !is_other(path)) {
        for line in code(&fs::read_to_string(path).unwrap()).lines() {
            assert!(!writes.iter().any(|w| line.contains(w)), "{}: {line}", path.display());
        }
    }
}

/// Calls that write, with a disk instead of a handle.
fn writes_without_handle() -> Vec<String> {
    let functions = [
        "append_events",
        "log_sweeps",
        "write_new",
        "write_private",
        "replace",
        "accept_study",
        "recover_study",
        "settle",
        "record_sweep",
        "give_metric",
        "withdraw_metric",
        "lay_down",
        "keep",
    ];
    let disks = ["RealFiles", "Unsynced"];
    let call = |f: &&str| disks.map(|disk| format!("{f}(&{disk}"));
    let mut calls: Vec<String> = functions.iter().flat_map(call).collect();
    calls.extend(disks.map(|disk| format!("files: &{disk}")));
    calls.extend(disks.map(|disk| format!("{disk}.re"))); // remove, remove_folder, rename
    calls
}

/// Places whose files for tests have names of their own (`testing.rs`, `real_data.rs`).
const OWN_NAMES: [&str; 2] = ["crates/import", "pipelines"];

/// Sources that follow the layout: below `src` of the crates, of the stages and of the chores.
fn laid_out() -> Vec<PathBuf> {
    let places = ["crates", "pipelines", "xtask"];
    places.iter().flat_map(|place| sources(&workspace().join(place))).collect()
}

#[test]
fn a_module_with_files_below_it_is_the_mod_rs_of_their_folder() {
    let sources = laid_out();
    assert!(sources.len() > 200, "only {} sources: were they found?", sources.len());
    for path in sources {
        assert!(!path.with_extension("").is_dir(), "{} beside its folder", path.display());
    }
}

#[test]
fn modules_of_tests_are_called_tests() {
    let has_own = |path: &PathBuf| OWN_NAMES.iter().any(|p| path.starts_with(workspace().join(p)));
    for path in laid_out().into_iter().filter(|path| !has_own(path)) {
        for name in test_modules(&fs::read_to_string(&path).unwrap()) {
            let at = path.display();
            assert!(name == "tests", "{at}: {name} is for tests");
        }
    }
}
