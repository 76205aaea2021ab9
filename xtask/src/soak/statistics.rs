//! Compares the statistics with R and SciPy on random data, and applies them to studies without an
//! effect. These are the tests of `crates/stats` with other numbers of data sets and studies. Their
//! counts are in `docs/statistics-tried.md`.

use crate::shell::{cargo, files, scratch};
use crate::tried::{END, held, parts};
use anyhow::{Context as _, bail, ensure};
use std::process::Command;
use std::time::Instant;

const PAGE: &str = "docs/statistics-tried.md";
/// Data sets, and studies of each kind, of a whole run.
pub(crate) const SETS: u32 = 1000;
pub(crate) const STUDIES: u32 = 40_000;
/// R's packages, and how Debian calls them.
const OF_R: [(&str, &str); 6] = [
    ("lme4", "r-cran-lme4"),
    ("lmerTest", "r-cran-lmertest"),
    ("pbkrtest", "r-cran-pbkrtest"),
    ("nlme", "r-cran-nlme"),
    ("ordinal", "r-cran-ordinal"),
    ("jsonlite", "r-cran-jsonlite"),
];

/// Compares linear mixed models, cumulative-link models, exact tests and psychometric functions with R, SciPy, statsmodels
/// and psignifit on so many random data sets each.
pub(crate) fn against_r(sets: u32, seed: Option<u32>) -> anyhow::Result<()> {
    let loaded: String = OF_R.map(|(package, _)| format!("library({package}); ")).concat();
    let debian = OF_R.map(|(_, package)| package).join(" ");
    let remedy = format!("install R with its packages (apt install r-base-core {debian})");
    need("Rscript", &["-e", &loaded]).context(remedy)?;
    let python = std::env::var("ZWIDTH_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let remedy = "install Python with what tests/interop/requirements.txt lists, and name it by \
                  ZWIDTH_PYTHON";
    need(&python, &["-c", "import scipy, statsmodels, psignifit"]).context(remedy)?;
    let began = Instant::now();
    let mut settings =
        ["ZWIDTH_R_CASES", "ZWIDTH_EXACT_CASES"].map(|name| (name, sets.to_string())).to_vec();
    if let Some(seed) = seed {
        settings
            .extend(["ZWIDTH_R_SEED", "ZWIDTH_EXACT_SEED"].map(|name| (name, seed.to_string())));
    }
    let tests = "--test r --test ordinal --test exact";
    // Each says what it counted; what is asked for by a name alone is not random.
    let tables = tables_of("r", tests, &["--ignored", "--nocapture"], settings)?;
    put("cargo xtask soak r", [sets, SETS], None, &tables)?;
    let what = "random data sets of each kind: models and tests as R, SciPy, statsmodels and psignifit have them";
    held(what, format!("cargo xtask soak r {sets}"), sets.into(), began)
}

/// Puts all tests, models and intervals to so many studies of each kind in which there is nothing
/// to find, and compares power with its prediction; or, as all of it takes hours, to `part`, the
/// tests whose names have it.
pub(crate) fn null(studies: u32, part: Option<&str>) -> anyhow::Result<()> {
    let began = Instant::now();
    let settings = vec![("ZWIDTH_NULL_STUDIES", studies.to_string())];
    let how: Vec<&str> = ["--nocapture"].into_iter().chain(part).collect();
    let tables = tables_of("null", "--test null_studies", &how, settings)?;
    ensure!(!tables.is_empty(), "no test of null_studies is called {}", part.unwrap_or_default());
    put("cargo xtask soak null", [studies, STUDIES], part, &tables)?;
    if part.is_some() {
        return Ok(());
    }
    let what =
        "studies of each kind without an effect: no default test finds more than it promises";
    held(what, format!("cargo xtask soak null {studies}"), studies.into(), began)
}

/// Runs tests of `crates/stats`, built for release, and gives what they wrote, in order of its
/// names.
fn tables_of(
    name: &str,
    tests: &str,
    how: &[&str],
    mut settings: Vec<(&str, String)>,
) -> anyhow::Result<Vec<String>> {
    std::fs::create_dir_all(scratch(name))?;
    let folder = scratch(name).canonicalize()?;
    settings.push(("ZWIDTH_TRIED", folder.display().to_string()));
    let line = format!("test --release --locked --package zwidth-stats {tests} --");
    cargo(&line, how, &settings, "a promise of the statistics is broken, see above")?;
    let mut paths = files(&folder)?;
    paths.sort();
    let tables = paths.iter().map(std::fs::read_to_string).collect::<Result<_, _>>()?;
    std::fs::remove_dir_all(&folder)?;
    Ok(tables)
}

/// Writes the tables of a whole run into the page, between the marks of its chore; those of a part
/// in the place of the tables that have their titles.
fn put(
    chore: &str,
    [times, whole]: [u32; 2],
    part: Option<&str>,
    tables: &[String],
) -> anyhow::Result<()> {
    if times < whole {
        println!("{PAGE} takes the tables of {whole} or more alone");
        return Ok(());
    }
    let text = std::fs::read_to_string(PAGE)?;
    let text = match part {
        Some(part) => replaced_part(&text, chore, &format!("{chore} {times} {part}"), tables)?,
        None => replaced(&text, chore, times, tables)?,
    };
    std::fs::write(PAGE, text)?;
    Ok(())
}

/// How a table's title begins.
const TITLE: &str = "### ";

/// The page with these tables in the place of those that have their titles; each says what wrote
/// it.
fn replaced_part(text: &str, chore: &str, by: &str, tables: &[String]) -> anyhow::Result<String> {
    let begin = format!("<!-- begin: {chore} -->\n");
    let [before, between, after] = parts(text, &begin)?;
    let mut sections: Vec<String> = between.split(TITLE).map(str::to_owned).collect();
    for table in tables {
        let (title, rest) = table.trim_start_matches(TITLE).split_once('\n').context("no title")?;
        let place = sections.iter().position(|section| section.lines().next() == Some(title));
        let place = place.with_context(|| format!("{PAGE} has no table '{title}'"))?;
        let end = if place + 1 < sections.len() { "\n" } else { "" };
        sections[place] = format!("{title}\n\nWritten by `{by}`.\n{rest}{end}");
    }
    Ok(format!("{before}{begin}{}{END}{after}", sections.join(TITLE)))
}

fn replaced(text: &str, chore: &str, times: u32, tables: &[String]) -> anyhow::Result<String> {
    let begin = format!("<!-- begin: {chore} -->\n");
    let [before, _, after] = parts(text, &begin)?;
    let tables = tables.join("\n");
    Ok(format!("{before}{begin}Written by `{chore} {times}`.\n\n{tables}{END}{after}"))
}

/// Runs a program that must end well.
fn need(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    let output = Command::new(program).args(arguments).output().context(program.to_owned())?;
    if !output.status.success() {
        bail!("{program}: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_take_the_place_of_earlier_ones_and_nothing_else_changes() {
        let chore = "cargo xtask soak null";
        let begin = format!("<!-- begin: {chore} -->\n");
        let tables = ["| a |\n".to_owned(), "| b |\n".to_owned()];
        let page = format!("# Title\n{begin}earlier\n{END}rest\n");
        let between = "Written by `cargo xtask soak null 1000`.\n\n| a |\n\n| b |\n";
        let made = replaced(&page, chore, 1000, &tables).unwrap();
        assert_eq!(made, format!("# Title\n{begin}{between}{END}rest\n"));
        assert_eq!(replaced(&made, chore, 1000, &tables).unwrap(), made);
        assert!(replaced("no marks", chore, 1, &tables).is_err());
    }

    #[test]
    fn the_table_of_a_part_takes_the_place_of_the_one_of_its_title_alone() {
        let chore = "cargo xtask soak null";
        let begin = format!("<!-- begin: {chore} -->\n");
        let page = format!("{begin}Prose.\n\n### A\n\n| 1 |\n\n### B\n\n| 2 |\n{END}rest\n");
        let table = |title: &str| format!("### {title}\n\n| 3 |\n");
        let by = "cargo xtask soak null 7 a";
        let first = replaced_part(&page, chore, by, &[table("A")]).unwrap();
        let of_a = "### A\n\nWritten by `cargo xtask soak null 7 a`.\n\n| 3 |\n\n### B\n\n| 2 |\n";
        assert_eq!(first, format!("{begin}Prose.\n\n{of_a}{END}rest\n"));
        assert_eq!(replaced_part(&first, chore, by, &[table("A")]).unwrap(), first);
        let last = replaced_part(&page, chore, by, &[table("B")]).unwrap();
        assert!(last.ends_with(&format!("a`.\n\n| 3 |\n{END}rest\n")), "{last}");
        assert!(replaced_part(&page, chore, by, &[table("C")]).is_err());
    }
}
