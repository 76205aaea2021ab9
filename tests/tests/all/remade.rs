//! `zwidth figure`: one figure again, in another size or form; and the captions beside all figures.

use crate::binary::zwidth;
use crate::folders::{files, listing};
use crate::shipped;
use std::fs;
use std::path::Path;

const NAME: &str = "modes.P01.S01.spring_wall";

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

#[test]
fn every_figure_has_its_caption_beside_it_which_says_what_it_was_made_from() {
    let folder = shipped::folder().join("reports/thesis-twin/figures");
    let captions = files(&folder, "txt");
    assert_eq!(captions.len(), files(&folder, "svg").len());
    for path in captions {
        let caption = text(&path);
        assert!(!caption.contains(['*', '\u{7}']), "{caption}");
        let (words, origin) = caption.trim_end().rsplit_once("\n\n").unwrap();
        assert!(words.len() > 40 && origin.starts_with("zwidth:figures:"), "{caption}");
        let svg = text(&path.with_extension("svg"));
        assert_eq!(words.contains("SYNTHETIC"), svg.contains("SYNTHETIC"), "{}", path.display());
    }
}

#[test]
fn a_figure_is_remade_in_another_size_and_form_and_is_traced_like_its_own() {
    let root = shipped::finished();
    let before = listing(root.path());
    let out = root.path().join("thesis");
    let folder = out.to_str().unwrap();
    let asked = ["figure", "thesis-twin", NAME, "--size", "120x100", "--format", "svg,png"];
    let asked = [&asked[..], &["--bare", "--text", "--dpi", "100", "--out", folder]].concat();
    let made = zwidth(root.path(), &asked).exits(0).out;
    assert!(made.contains("modes.P01.S01.spring_wall.svg"), "{made}");
    let svg = text(&out.join(format!("{NAME}.svg")));
    assert!(svg.contains("width=\"120mm\"") && svg.contains("height=\"100mm\""), "{svg:.300}");
    assert!(svg.contains("<text") && svg.contains("SYNTHETIC"));
    assert!(!svg.contains("Thick:</text>"), "the small print stands in the caption");
    assert!(text(&out.join(format!("{NAME}.txt"))).contains("Thick: mean of the repeats"));
    assert!(!out.join(format!("{NAME}.pdf")).exists());
    let png = fs::read(out.join(format!("{NAME}.png"))).unwrap();
    let width = u32::from_be_bytes(png[16..20].try_into().unwrap());
    assert_eq!(width, 472, "120 mm at 100 dots an inch");
    let copy = out.join(format!("{NAME}.svg"));
    let traced = zwidth(root.path(), &["trace", copy.to_str().unwrap()]).exits(0);
    assert!(traced.out.contains(&format!("figure {NAME}")), "{}", traced.out);
    fs::remove_dir_all(&out).unwrap();
    assert_eq!(listing(root.path()), before, "what a run made stays as it was");
}

#[test]
fn what_is_remade_without_a_folder_says_what_it_was_made_from_and_in_which_form() {
    let root = shipped::finished();
    let out = root.path().join("reports/thesis-twin/remade");
    let form = ["--size", "120", "--format", "svg,pdf,png", "--bare"];
    zwidth(root.path(), &[&["figure", "thesis-twin", NAME][..], &form].concat()).exits(0);
    for extension in ["svg", "pdf", "png", "txt"] {
        let file = format!("reports/thesis-twin/remade/{NAME}.{extension}");
        for command in ["trace", "why"] {
            let told = zwidth(root.path(), &[command, &file]).exits(0);
            assert!(told.out.contains(&format!("figure {NAME}")), "{command} {file}: {}", told.out);
        }
    }
    assert!(text(&out.join(format!("{NAME}.svg"))).contains("120 mm wide, bare"));
    fs::write(out.join("own.svg"), "<svg/>").unwrap();
    let own = zwidth(root.path(), &["trace", "reports/thesis-twin/remade/own.svg"]);
    own.exits(1).one_error();
    fs::remove_dir_all(&out).unwrap();
}

#[test]
fn figures_of_sessions_that_study_toml_does_not_name_are_made_on_demand() {
    let root = shipped::finished();
    let study = root.path().join("raw/thesis-twin/study.toml");
    fs::write(&study, text(&study) + "\n[figures]\nsessions = []\n").unwrap();
    zwidth(root.path(), &["run", "thesis-twin"]);
    let reports = root.path().join("reports/thesis-twin");
    let own = |kind: &str| {
        let names = files(&reports.join("figures"), "svg").into_iter();
        names.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(kind)).count()
    };
    assert_eq!(["modes.", "loops.", "repeats.", "replay."].map(own), [0; 4]);
    assert!(own("compare.") > 0 && own("schematic.") > 0, "those of the whole study stay");
    for page in ["summary.md", "index.html"] {
        assert!(text(&reports.join(page)).contains("are made on demand, of 1 session"), "{page}");
    }
    let listed = zwidth(root.path(), &["figure", "thesis-twin"]).exits(0);
    assert!(listed.out.contains(NAME), "{listed:#?}");
    zwidth(root.path(), &["figure", "thesis-twin", NAME]).exits(0);
    assert!(text(&reports.join(format!("remade/{NAME}.svg"))).contains("zwidth:figures:"));
}

#[test]
fn a_figure_that_is_not_there_a_size_that_is_none_and_a_folder_of_recordings_are_told() {
    let root = shipped::finished();
    let ask = |more: &[&str]| zwidth(root.path(), &[&["figure", "thesis-twin"][..], more].concat());
    ask(&["modes.P01.S01.sprin"]).exits(1).one_error().says(&["did you mean modes.P01.S01.spring"]);
    ask(&[NAME, "--size", "0"]).exits(2);
    ask(&[NAME, "--size", "85xtall"]).exits(2);
    ask(&[NAME, "--format", "jpg"]).exits(2);
    let raw = root.path().join("raw/thesis-twin");
    ask(&[NAME, "--out", raw.to_str().unwrap()]).exits(1).one_error().says(&["another folder"]);
    ask(&[NAME, "--size", "20"]).exits(1).one_error();
    let no_font = raw.join("study.toml");
    let no_font = [NAME, "--font-file", no_font.to_str().unwrap()];
    ask(&no_font).exits(1).one_error().says(&["study.toml", "no TrueType or OpenType font"]);
    ask(&["--font-file", "a.ttf"]).exits(1).one_error().says(&["name the figure"]);
    ask(&["--size", "85"]).exits(1).one_error().says(&["name the figure", "lists them"]);
    let listed = ask(&[]).exits(0);
    assert!(listed.out.lines().count() > 30 && listed.out.contains(NAME), "{listed:#?}");
}
