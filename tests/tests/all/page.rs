//! The page: as the run writes it, and as one file.

use crate::binary::zwidth;
use crate::shipped;
use std::fs;

#[test]
fn a_page_as_one_file_needs_nothing_beside_it_and_a_study_without_a_page_says_how_to_make_it() {
    let root = shipped::finished();
    let file = root.path().join("one.html");
    let file_text = file.to_str().unwrap();
    let ran = zwidth(root.path(), &["open", "thesis-twin", "--single-file", file_text]).exits(0);
    assert_eq!(ran.out, format!("{file_text}\n"));
    let one = fs::read_to_string(&file).unwrap();
    let (shown, _) = one.split_once("<script id=\"study-data\"").unwrap();
    assert!(shown.contains("src=\"data:image/svg+xml;base64,"));
    assert!(shown.split("src=\"").skip(1).all(|source| source.starts_with("data:")));
    for key in ["P01.S01.spring.hybrid", "P01.S01.spring_wall.passive"] {
        assert!(
            one.contains(&format!("class=\"trial-data\" data-key=\"{key}\">{{\"trials\"")),
            "{key}"
        );
    }
    assert!(one.contains("\"single_file\":true") && one.contains("SYNTHETIC"));
    let nowhere = root.path().join("no/such/one.html");
    zwidth(root.path(), &["open", "thesis-twin", "--single-file", nowhere.to_str().unwrap()])
        .exits(1)
        .one_error()
        .says(&["no/such", "does not exist"]);
    for (file, says) in [("raw/thesis-twin/one.html", "inside raw/"), ("one.txt", ".html")] {
        let path = root.path().join(file);
        zwidth(root.path(), &["open", "thesis-twin", "--single-file", path.to_str().unwrap()])
            .exits(1)
            .one_error()
            .says(&[file, says]);
        assert!(!path.exists());
    }
    fs::remove_file(root.path().join("reports/thesis-twin/index.html")).unwrap();
    zwidth(root.path(), &["open", "thesis-twin"])
        .exits(1)
        .one_error()
        .says(&["reports/thesis-twin/index.html", "zwidth run thesis-twin"]);
}
