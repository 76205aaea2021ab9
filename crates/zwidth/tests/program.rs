//! Cargo builds a program for the integration tests of its own package only: without this file
//! `cargo test --workspace` would not build the one that the tests of the whole (`tests/`) run.

use std::process::Command;

#[test]
fn the_program_says_its_version() {
    let output = Command::new(env!("CARGO_BIN_EXE_zwidth")).arg("--version").output().unwrap();
    let expect = concat!("zwidth ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expect);
}

#[test]
fn without_the_program_for_clusters_a_run_on_one_says_how_to_build_it_and_makes_nothing() {
    let root = tempfile::tempdir().unwrap();
    let raw = root.path().join("raw/empty");
    std::fs::create_dir_all(&raw).unwrap();
    std::fs::write(raw.join("study.toml"), "").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_zwidth"));
    command.arg("--root").arg(root.path()).args(["run", "empty", "--cluster", "127.0.0.1:1"]);
    let output = command.env("PATH", root.path()).output().unwrap();
    let words = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{words}");
    for word in ["zwidth-cluster", "not on the path", "--manifest-path cluster/Cargo.toml"] {
        assert!(words.contains(word), "{words}");
    }
    assert!(!root.path().join("derived").exists());
}
