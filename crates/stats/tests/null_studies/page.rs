//! Tables of what was found, for `docs/statistics-tried.md`.

use crate::judged::{Asked, Judged, Share};
use crate::predicted::Compared;

/// Prints a table below its title, and writes it where tables are asked for, as a file whose name
/// says its place among them.
pub(crate) fn write(place: u8, title: &str, table: &str) {
    let text = format!("### {title}\n\n{table}");
    println!("{text}");
    if let Ok(folder) = std::env::var("ZWIDTH_TRIED") {
        let file = std::path::Path::new(&folder).join(format!("null-{place:02}.md"));
        std::fs::write(file, text).unwrap();
    }
}

/// A row per kind; columns per test, and per interval.
pub(crate) fn table(all: &[(String, Vec<Judged>)]) -> String {
    let most = all.iter().map(|(_, judged)| judged).max_by_key(|judged| judged.len()).unwrap();
    // What any kind was put to has a column.
    let of_any = |own: &&Judged, of: fn(&Judged) -> usize| {
        all.iter()
            .flat_map(|(_, judged)| judged)
            .any(|judged| judged.test == own.test && of(judged) > 0)
    };
    let testing = |judged: &&Judged| of_any(judged, |judged| judged.rejected.of);
    let covering = |judged: &&Judged| of_any(judged, |judged| judged.covered.of);
    let heads = most.iter().filter(testing).map(|judged| format!("{} rejects", judged.test));
    let intervals = most.iter().filter(covering).map(|judged| format!("{} covers", judged.test));
    let studies = "studies of this kind".to_owned();
    let heads: Vec<String> = std::iter::once(studies).chain(heads).chain(intervals).collect();
    let rows = all.iter().map(|(kind, judged)| {
        let of_test = |test: &str| judged.iter().find(|judged| judged.test == test);
        let tests = most.iter().filter(testing);
        let rejected = tests.map(|of| of_test(of.test).map_or("–".to_owned(), rejected));
        let covered = most.iter().filter(covering);
        let covered = covered.map(|of| of_test(of.test).map_or("–".to_owned(), covers));
        let of = judged[0].rejected.of.max(judged[0].covered.of);
        line(&[vec![kind.clone(), of.to_string()], rejected.chain(covered).collect()].concat())
    });
    format!("{}{}", head("people, their scatter", &heads), rows.collect::<String>())
}

/// False positives: bold where they are too many beyond doubt.
fn rejected(judged: &Judged) -> String {
    let words = judged.rejected.words();
    let words = if judged.rejected.is_too_many() { format!("**{words}**") } else { words };
    words + mark(judged)
}

fn covers(judged: &Judged) -> String {
    judged.covered.words() + mark(judged)
}

/// A ring where nothing was promised.
fn mark(judged: &Judged) -> &'static str {
    if judged.asked == Asked::Nothing { " °" } else { "" }
}

/// A row per plan.
pub(crate) fn powers(all: &[Compared]) -> String {
    let row = |compared: &Compared| {
        let Share { count, of } = compared.observed;
        let (low, high) = compared.interval();
        let held = if compared.is_held() { "yes" } else { "**no**" };
        line(&[
            format!("n = {}, difference {}", compared.plan.participants, compared.plan.difference),
            format!("{:.2}", 100.0 * compared.predicted),
            format!("{:.2}", 100.0 * count as f64 / of as f64),
            format!("{:.2}–{:.2}", 100.0 * low, 100.0 * high),
            held.to_owned(),
        ])
    };
    let heads = ["predicted", "observed", "99 % interval", "holds the prediction"];
    let title = format!("{} studies of each plan", all[0].observed.of);
    format!(
        "{}{}",
        head(&title, &heads.map(str::to_owned)),
        all.iter().map(row).collect::<String>()
    )
}

fn head(title: &str, heads: &[String]) -> String {
    let rule = vec!["---".to_owned(); heads.len() + 1];
    format!("{}{}", line(&[vec![title.to_owned()], heads.to_vec()].concat()), line(&rule))
}

fn line(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}
