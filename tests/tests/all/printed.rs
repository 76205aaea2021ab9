//! The pages that lead a reader by the hand: their commands are run exactly as they are printed, in a
//! temporary folder, and what they say is what the page shows.

use crate::binary::binary;
use crate::folders::{copy, workspace};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A block of code of a page: what it is of, and its text.
type Block<'a> = (&'a str, &'a str);

/// Stands in the output behind what a block said, with the block's number and its exit code.
const END: &str = "@@ end of block";

/// The blocks of a page, in their order.
fn blocks(page: &str) -> Vec<Block<'_>> {
    let parts = page.split("```").skip(1).step_by(2);
    parts.filter_map(|part| part.split_once('\n')).collect()
}

/// Whether lines are as they are shown: a line `…` stands for any lines, and a line that ends in `…`
/// for any that begins so.
fn is_shown(shown: &[&str], said: &[&str]) -> bool {
    match (shown.split_first(), said.split_first()) {
        (None, None) => true,
        (Some((&"…", rest)), _) => (0..=said.len()).any(|passed| is_shown(rest, &said[passed..])),
        (Some((line, shown)), Some((first, said))) => {
            let fits = match line.strip_suffix('…') {
                Some(start) => first.starts_with(start),
                None => line == first,
            };
            fits && is_shown(shown, said)
        }
        _ => false,
    }
}

/// A script that runs the blocks of shell one after the other in one shell, and writes those of TOML
/// into map.toml, as the page asks for.
fn script(blocks: &[Block]) -> String {
    let step = |(number, (language, text)): (usize, &Block)| match *language {
        "sh" if !text.starts_with("cargo ") => {
            format!("{text}echo \"{END} {number}: $?\"\n")
        }
        "toml" => format!("cat > map.toml <<'EOF'\n{text}EOF\n"),
        _ => String::new(),
    };
    blocks.iter().enumerate().map(step).collect()
}

/// Runs the blocks in a folder; what each of them said.
fn run(blocks: &[Block], folder: &Path, home: &Path) -> Vec<Option<String>> {
    let programs = binary().parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::iter::once(programs).chain(std::env::split_paths(&path));
    let mut shell = Command::new("sh");
    shell.args(["-c", &script(blocks)]).current_dir(folder);
    shell.env("PATH", std::env::join_paths(path).unwrap()).env("HOME", home);
    shell.env_remove("ZWIDTH_ROOT").env_remove("XDG_STATE_HOME");
    let output = shell.output().unwrap();
    let (out, err) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8_lossy(&output.stderr));
    let mut rest = out.as_str();
    let mut said = vec![None; blocks.len()];
    for (number, (_, text)) in blocks.iter().enumerate() {
        if let Some((own, after)) = rest.split_once(&format!("{END} {number}: ")) {
            let (code, after) = after.split_once('\n').unwrap();
            assert_eq!(code, "0", "{text}{own}{err}");
            (said[number], rest) = (Some(own.to_owned()), after);
        }
    }
    said
}

/// Runs a page's commands in a folder and compares what they say with what it shows.
fn follow(page: &str, folder: &Path, home: &Path) {
    let text = fs::read_to_string(workspace().join(page)).unwrap();
    let blocks = blocks(&text);
    let said = run(&blocks, folder, home);
    let mut compared = 0;
    for (number, (language, shown)) in blocks.iter().enumerate() {
        if *language != "text" {
            continue;
        }
        let (_, command) = blocks[number - 1];
        let said = said[number - 1].as_ref().unwrap_or_else(|| panic!("{command} was not run"));
        let lines =
            |text: &'_ str| text.lines().map(str::trim_end).map(str::to_owned).collect::<Vec<_>>();
        let (shown, said) = (lines(shown), lines(said));
        let [a, b] =
            [&shown, &said].map(|lines| lines.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(
            is_shown(&a, &b),
            "{page}: {command}shows\n{}\nsaid\n{}",
            a.join("\n"),
            b.join("\n")
        );
        compared += 1;
    }
    assert!(compared > 1, "{page} shows {compared} outputs: were they found?");
}

#[test]
fn lines_are_compared_up_to_what_a_page_leaves_out() {
    let check = |shown: &[&str], said: &[&str]| is_shown(shown, said);
    assert!(check(&["a", "b"], &["a", "b"]) && !check(&["a"], &["a", "b"]));
    assert!(check(&["a", "…", "d"], &["a", "b", "c", "d"]) && check(&["…"], &[]));
    assert!(!check(&["a", "…", "d"], &["a", "b", "c"]));
    assert!(check(&["in …"], &["in 0.3 s"]) && !check(&["in …"], &["on 0.3 s"]));
}

#[test]
fn the_first_hour_and_readme_say_what_the_program_says() {
    let home = tempfile::tempdir().unwrap();
    let clone = home.path().join("clone");
    copy(&workspace().join("raw/thesis-twin"), &clone.join("raw/thesis-twin"));
    follow("docs/first-hour.md", &clone, home.path());
    // README's first command, by the program that cargo has built; its results are there already.
    let readme = fs::read_to_string(workspace().join("README.md")).unwrap();
    let (_, commands) = blocks(&readme)[0];
    let first = commands.lines().next().unwrap().replace("cargo run --release --", "zwidth");
    assert!(first.starts_with("zwidth run"), "{first}");
    let said = run(&[("sh", &format!("{first}\n"))], &clone, home.path());
    assert!(said[0].as_ref().unwrap().starts_with("thesis-twin: 0 made"), "{said:?}");
}

#[test]
fn the_page_of_a_session_says_what_the_program_says() {
    let home = tempfile::tempdir().unwrap();
    follow("docs/session.md", home.path(), home.path());
}
