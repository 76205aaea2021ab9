//! What the program tells of itself: its licences and its manual pages.

use crate::binary::zwidth;
use std::fs;
use std::path::Path;

#[test]
fn the_licences_have_the_text_of_every_package_and_that_of_the_font() {
    let ran = zwidth(Path::new("."), &["licences"]).exits(0);
    for words in ["serde 1.", "polars-core ", "Apache License", "SIL OPEN FONT LICENSE Version 1.1"]
    {
        assert!(ran.out.contains(words), "{words}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man/man1");
    let out = pages.to_str().unwrap();
    zwidth(folder.path(), &["man", "--out", out]).exits(0);
    let compare = fs::read_to_string(pages.join("zwidth-compare.1")).unwrap();
    assert!(compare.contains("pingouin"), "{compare}");
    for command in ["zwidth", "zwidth-run", "zwidth-licences", "zwidth-man"] {
        assert!(pages.join(format!("{command}.1")).exists(), "{command}");
    }
    // A file where a folder should be is named.
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let within = file.join("pages");
    zwidth(folder.path(), &["man", "--out", within.to_str().unwrap()])
        .exits(1)
        .says(&["file/pages"]);
}
