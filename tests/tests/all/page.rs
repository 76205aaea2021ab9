//! The page: as the run writes it, and as one file.

use crate::binary::{Ran, zwidth};
use crate::shipped;
use std::fs;
use std::path::Path;

#[test]
fn a_page_as_one_file_needs_nothing_beside_it_and_a_study_without_a_page_says_how_to_make_it() {
    let root = shipped::finished();
    let file = root.path().join("one.html");
    assert_eq!(single(root.path(), &file).exits(0).out, format!("{}\n", file.display()));
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
    single(root.path(), &nowhere).exits(1).one_error().says(&["no/such", "does not exist"]);
    for (file, says) in [("raw/thesis-twin/one.html", "inside raw/"), ("one.txt", ".html")] {
        let path = root.path().join(file);
        single(root.path(), &path).exits(1).one_error().says(&[file, says]);
        assert!(!path.exists());
    }
    fs::remove_file(root.path().join("reports/thesis-twin/index.html")).unwrap();
    let words = ["reports/thesis-twin/index.html", "zwidth run thesis-twin"];
    zwidth(root.path(), &["open", "thesis-twin"]).exits(1).one_error().says(&words);
}

/// The page as one file.
fn single(root: &Path, file: &Path) -> Ran {
    zwidth(root, &["open", "thesis-twin", "--single-file", file.to_str().unwrap()])
}

/// `zwidth open --single-file` of a page whose first figure, or first script of samples, is another
/// path.
#[test]
fn one_file_takes_in_regular_files_of_its_own_report_alone_and_names_what_else_the_page_shows() {
    let root = shipped::finished();
    let report = root.path().join("reports/thesis-twin");
    fs::write(root.path().join("secret.svg"), "secret").unwrap();
    fs::write(root.path().join("secret.js"), "zwidthData(\"x\", secret);").unwrap();
    let page = fs::read_to_string(report.join("index.html")).unwrap();
    let figure = page.split(" src=\"").nth(1).unwrap().split('"').next().unwrap();
    let key = "P01.S01.spring.hybrid";
    let file = root.path().join("one.html");
    let single = || single(root.path(), &file);
    let refused = |named: &str, says: &[&str]| {
        single().exits(1).one_error().says(&[named]).says(says);
        assert!(!file.exists(), "{named}");
    };
    for path in ["figures/../../../secret.svg", "figures//secret.svg", "figures/missing.svg"] {
        let edited = page.replace(&format!("\"{figure}\""), &format!("\"{path}\""));
        fs::write(report.join("index.html"), edited).unwrap();
        refused(path, &["zwidth run"]);
    }
    for path in ["/etc/hostname", "https://example.org/x.svg"] {
        let edited = page.replace(&format!(" src=\"{figure}\""), &format!(" src=\"{path}\""));
        fs::write(report.join("index.html"), edited).unwrap();
        refused(path, &["no figure of the study"]);
    }
    let edited =
        page.replace(&format!("\"data\":\"{key}\""), "\"data\":\"../../../secret.hybrid\"");
    assert_ne!(edited, page);
    fs::write(report.join("index.html"), edited).unwrap();
    refused("report-data/../../../secret.js", &["no file of this report"]);
    fs::write(report.join("index.html"), &page).unwrap();
    single().exits(0);
    fs::remove_file(&file).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        for name in [figure.to_owned(), "report-data/P01.S01.spring.js".to_owned()] {
            let path = report.join(&name);
            let kept = fs::read(&path).unwrap();
            fs::remove_file(&path).unwrap();
            symlink(root.path().join("secret.svg"), &path).unwrap();
            refused(&name, &["link"]);
            fs::remove_file(&path).unwrap();
            // Nobody writes into this pipe: whoever waits for it hangs.
            std::process::Command::new("mkfifo").arg(&path).status().unwrap();
            refused(&name, &[]);
            fs::remove_file(&path).unwrap();
            fs::write(&path, kept).unwrap();
        }
        fs::rename(report.join("figures"), root.path().join("elsewhere")).unwrap();
        symlink(root.path().join("elsewhere"), report.join("figures")).unwrap();
        refused("reports/thesis-twin/figures", &["it is a link"]);
        fs::remove_file(report.join("figures")).unwrap();
        fs::rename(root.path().join("elsewhere"), report.join("figures")).unwrap();
        single().exits(0);
    }
}
