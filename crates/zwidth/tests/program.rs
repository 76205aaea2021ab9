//! Cargo builds a program for the integration tests of its own package only: without this file
//! `cargo test --workspace` would not build the one that the tests of the whole (`tests/`) run.

use std::process::Command;

#[test]
fn the_program_says_its_version() {
    let output = Command::new(env!("CARGO_BIN_EXE_zwidth")).arg("--version").output().unwrap();
    let expect = concat!("zwidth ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expect);
}
