//! The floors of the house, proved from `cargo metadata`: arrows point down only.

use crate::folders::workspace;
use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What lies on which floor. A place is a folder of the workspace; `pipelines/*` is every folder in
/// it.
const FLOORS: [(u8, &[&str]); 8] = [
    (0, &["crates/study", "crates/numerics", "crates/arrow"]),
    (
        1,
        &[
            "crates/dynamics",
            "crates/programs",
            "crates/results",
            "crates/store",
            "crates/stats",
            "crates/testing",
        ],
    ),
    (2, &["crates/device", "crates/draw", "crates/tables", "crates/import", "crates/judge"]),
    (3, &["crates/export", "crates/frames", "crates/link"]),
    (4, &["crates/runner", "pipelines/*"]),
    (5, &["crates/plan", "crates/acquire", "crates/rig"]),
    (6, &["crates/zwidth"]),
    (TOP, &["tests", "benches", "xtask"]),
];

/// Chores, tests and comparisons look at everything, and at peers; nothing looks at them.
const TOP: u8 = 7;

/// Libraries of other people that stay where they are below the top floor, and the places that may
/// know them.
const CONFINED: [(&str, &[&str]); 10] = [
    ("arrow", &[]),
    ("arrow-array", &["crates/arrow"]),
    ("zwidth-arrow", &["crates/store", "crates/tables", "crates/import", "crates/judge"]),
    ("parquet", &["crates/store", "crates/import"]),
    ("polars", &["crates/frames"]),
    ("csv", &["crates/import", "crates/study"]),
    ("plotters", &["crates/draw"]),
    ("serialport", &["crates/link"]),
    ("clap", &["crates/zwidth"]),
    ("anyhow", &["crates/zwidth"]),
];

fn metadata() -> Metadata {
    MetadataCommand::new().manifest_path(workspace().join("Cargo.toml")).no_deps().exec().unwrap()
}

/// A member's folder, from the workspace's on: `crates/study`.
fn place(package: &Package) -> String {
    let folder = package.manifest_path.parent().unwrap().as_std_path();
    folder.strip_prefix(workspace()).unwrap().to_str().unwrap().replace('\\', "/")
}

fn is_at(place: &str, pattern: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(folder) => place.starts_with(folder),
        None => place == pattern,
    }
}

fn floor(place: &str) -> u8 {
    let found = FLOORS.iter().find(|(_, patterns)| patterns.iter().any(|p| is_at(place, p)));
    found
        .unwrap_or_else(|| {
            panic!("{place} is on no floor; give it one in this test and in ARCHITECTURE.md")
        })
        .0
}

#[test]
fn every_arrow_points_down() {
    let metadata = metadata();
    let places: BTreeMap<&str, String> =
        metadata.packages.iter().map(|p| (p.name.as_str(), place(p))).collect();
    let mut arrows = 0;
    for package in &metadata.packages {
        let from = place(package);
        // A package that is its own dev-dependency turns a feature of its on for its tests.
        let others = package.dependencies.iter().filter(|d| d.name != package.name.as_str());
        for to in others.filter_map(|d| places.get(d.name.as_str())) {
            assert!(floor(to) < floor(&from), "{from} must not know {to}: arrows point down only");
            arrows += 1;
        }
    }
    assert!(arrows > 20, "only {arrows} arrows: were the members found?");
}

/// `rust-version` is a promise to whoever builds with that version. Our own code is held to it by
/// clippy (`incompatible_msrv`), and what it is built of here.
#[test]
fn nothing_that_is_built_in_asks_for_a_newer_rust_than_ours() {
    let metadata = MetadataCommand::new()
        .manifest_path(workspace().join("Cargo.toml"))
        .other_options(["--locked".into(), "--filter-platform=x86_64-unknown-linux-gnu".into()])
        .exec()
        .unwrap();
    let is_ours = |p: &&Package| metadata.workspace_members.contains(&p.id);
    let ours = metadata.packages.iter().find(is_ours).and_then(|p| p.rust_version.clone()).unwrap();
    let newer: Vec<String> = metadata
        .packages
        .iter()
        .filter(|p| p.rust_version.as_ref().is_some_and(|asked| *asked > ours))
        .map(|p| format!("{} {} asks for {:?}", p.name, p.version, p.rust_version))
        .collect();
    assert!(newer.is_empty(), "rust-version is {ours}, and {newer:?}");
    assert!(
        metadata.packages.len() > 100,
        "{} packages: were they found?",
        metadata.packages.len()
    );
}

#[test]
fn a_member_is_named_after_its_folder() {
    for package in metadata().packages {
        let place = place(&package);
        let folder = Path::new(&place).file_name().unwrap().to_str().unwrap();
        let expect = match folder {
            "zwidth" | "xtask" => folder.to_owned(),
            other => format!("zwidth-{other}"),
        };
        assert_eq!(package.name.as_str(), expect);
    }
}

#[test]
fn libraries_of_one_purpose_stay_where_they_belong() {
    for package in metadata().packages {
        let place = place(&package);
        for (library, places) in CONFINED {
            let knows = package.dependencies.iter().any(|d| d.name == library);
            let may = floor(&place) == TOP || places.iter().any(|p| is_at(&place, p));
            assert!(may || !knows, "{place} must not know {library}; only {places:?} may");
        }
    }
}

/// Polars takes longer to compile than everything of ours: what does not stand on queries must not
/// wait for it, not even by way of another crate.
#[test]
fn most_of_the_house_does_not_wait_for_polars() {
    let metadata = metadata();
    let built_from: BTreeMap<&str, Vec<&str>> = metadata
        .packages
        .iter()
        .map(|package| {
            let needs =
                package.dependencies.iter().filter(|d| d.kind != DependencyKind::Development);
            (package.name.as_str(), needs.map(|d| d.name.as_str()).collect())
        })
        .collect();
    fn reaches(built_from: &BTreeMap<&str, Vec<&str>>, from: &str) -> bool {
        let needs = built_from.get(from).map(Vec::as_slice).unwrap_or_default();
        needs.iter().any(|name| *name == "polars" || reaches(built_from, name))
    }
    assert!(reaches(&built_from, "zwidth-frames"), "was it found?");
    for name in ["tables", "draw", "device", "acquire", "store", "import", "runner"] {
        let name = format!("zwidth-{name}");
        assert!(built_from.contains_key(name.as_str()), "{name}");
        assert!(!reaches(&built_from, &name), "{name} must not wait for polars");
    }
}

#[test]
fn unsafe_code_is_forbidden_in_every_member() {
    let table =
        |path: &Path| toml::from_str::<toml::Table>(&fs::read_to_string(path).unwrap()).unwrap();
    let root = table(&workspace().join("Cargo.toml"));
    assert_eq!(root["workspace"]["lints"]["rust"]["unsafe_code"].as_str(), Some("forbid"));
    for package in metadata().packages {
        let member = table(package.manifest_path.as_std_path());
        assert_eq!(member["lints"]["workspace"].as_bool(), Some(true), "{}", package.name);
    }
}

#[test]
fn cargo_run_means_the_program() {
    let metadata = metadata();
    let default: Vec<&str> =
        metadata.workspace_default_packages().iter().map(|p| p.name.as_str()).collect();
    assert_eq!(default, ["zwidth"]);
}
