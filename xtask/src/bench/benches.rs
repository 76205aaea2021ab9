//! The benches: how each is run, and where it leaves what it measured.

use super::case::Case;
use super::table::{Table, number, tables};
use crate::shell::files;
use anyhow::Context as _;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A bench.
pub(super) struct Bench {
    pub(super) name: &'static str,
    /// How it is run, for a shell in the workspace's folder, behind [`PRELUDE`].
    pub(super) line: &'static str,
    /// The same once, on little, only to see that it still runs.
    pub(super) short: &'static str,
    /// Reads what it measured the last time, given the folder of builds; nothing if it never ran.
    pub(super) read: fn(&Path) -> anyhow::Result<Vec<Case>>,
    /// The page on which it says where that was, and in which of its parts; without one here, now.
    pub(super) machine: Option<(&'static str, usize)>,
    /// Whether its ratios are held against the committed ones.
    pub(super) is_held: bool,
}

const PEERS: &str = "benches/peers/RESULTS.md";
const LONG: &str = "benches/long/RESULTS.md";
const FORMATS: &str = "benches/formats/RESULTS.md";
const STATISTICS: &str = "benches/statistics/RESULTS.md";
const PAGE: &str = "benches/page/RESULTS.md";
const SCALE: &str = "benches/scale/RESULTS.md";
const THRESHOLDS: &str = "benches/thresholds/RESULTS.md";

/// What lines have in common.
pub(super) const PRELUDE: &str = "\
    measure() { cargo bench --locked --package zwidth-benches \"$@\"; }\n\
    notes=\"${CARGO_TARGET_DIR:-target}/bench\"; mkdir -p \"$notes\"\n";

/// Those that measure nothing beside a peer: a name, and how each is run once on little.
pub(super) const ALONE: [(&str, &str); 3] = [
    ("rig", "benches/rig/run.sh 1 2"),
    ("session", "benches/session/run.sh --scale 2"),
    ("whole", "benches/scale/whole.sh 10 --rounds 1"),
];

/// All others: the quick ones first.
pub(super) const BENCHES: [Bench; 12] = [
    criterion(
        "store",
        ["measure --bench reference --bench store", "measure --bench store -- --test"],
        |target| from_criterion(target, &["trial of 4,000 samples"]),
    ),
    criterion(
        "dynamics",
        ["measure --bench reference --bench dynamics", "measure --bench dynamics -- --test"],
        |target| {
            from_criterion(
                target,
                &["exact hybrid spring", "exact recorded push", "sweep, summaries only"],
            )
        },
    ),
    criterion(
        "run",
        [
            "cargo build --release --locked && measure --bench reference --bench run",
            "cargo build --release --locked && measure --bench run -- --test",
        ],
        |target| from_criterion(target, &["zwidth run thesis-twin"]),
    ),
    Bench {
        name: "timing",
        line: "measure --bench timing >\"$notes/timing.txt\"",
        short: "measure --bench timing >\"$notes/timing.txt\"",
        read: timing,
        machine: None,
        is_held: false,
    },
    page_of("statistics", ["benches/statistics/run.sh"; 2], (STATISTICS, 0), |_| {
        side_by_side(
            STATISTICS,
            &["model", "participants × sessions × modes × repeats"],
            "zwidth, ms",
            "R, ms",
            "R",
            1e-3,
        )
    }),
    page_of("thresholds", ["benches/thresholds/run.sh"; 2], (THRESHOLDS, 0), |_| {
        Ok(fits(&page(THRESHOLDS)?).into_iter().collect())
    }),
    page_of("peers", ["benches/peers/run.sh --plain", "benches/peers/run.sh"], (PEERS, 0), |_| {
        solvers(&page(PEERS)?)
    }),
    page_of(
        "study",
        ["benches/peers/study/run.sh", "benches/peers/study/run.sh --rounds 1 --repeats 1"],
        (PEERS, 1),
        |_| {
            side_by_side(
                PEERS,
                &["job, fresh"],
                "zwidth, s",
                "script, s",
                "pandas, SciPy, matplotlib",
                1.0,
            )
        },
    ),
    page_of("long", ["benches/long/run.sh", "benches/long/run.sh --rows 10000"], (LONG, 0), |_| {
        side_by_side(LONG, &["rows"], "the three, s", "pandas, s", "pandas, a part of it", 1.0)
    }),
    page_of(
        "formats",
        ["benches/formats/run.sh", "benches/formats/run.sh --mb 1 --turns 1"],
        (FORMATS, 0),
        |_| {
            side_by_side(
                FORMATS,
                &["format", "beside"],
                "zwidth, s",
                "its time, s",
                "its own library",
                1.0,
            )
        },
    ),
    page_of(
        "page",
        ["benches/page/run.sh", "benches/page/run.sh --participants 10 --repeats 1"],
        (PAGE, 0),
        |_| browsed(&page(PAGE)?),
    ),
    page_of(
        "scale",
        ["benches/scale/run.sh", "benches/scale/run.sh 10 --rounds 1"],
        (SCALE, 0),
        |_| {
            side_by_side(
                SCALE,
                &["metrics, beside"],
                "zwidth, s",
                "a part of it, s",
                "a part of it",
                1.0,
            )
        },
    ),
];

type Read = fn(&Path) -> anyhow::Result<Vec<Case>>;

/// The lines are those of a whole run and of a short one.
const fn criterion(name: &'static str, [line, short]: [&'static str; 2], read: Read) -> Bench {
    Bench { name, line, short, read, machine: None, is_held: true }
}

const fn page_of(
    name: &'static str,
    [line, short]: [&'static str; 2],
    page: (&'static str, usize),
    read: Read,
) -> Bench {
    Bench { name, line, short, read, machine: Some(page), is_held: true }
}

/// The tables of a page; none if there is no such page.
fn page(path: &str) -> anyhow::Result<Vec<Table>> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(tables(&text)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(e) => Err(e).with_context(|| format!("cannot read {path}")),
    }
}

fn case(what: String, ours_s: f64, beside: &str, peer_s: f64) -> Case {
    Case { bench: String::new(), case: what, ours_s, beside: beside.to_owned(), peer_s }
}

/// Rows that have ours and another's time side by side, in these units.
fn side_by_side(
    path: &str,
    what: &[&str],
    ours: &str,
    theirs: &str,
    beside: &str,
    unit_s: f64,
) -> anyhow::Result<Vec<Case>> {
    let mut found = Vec::new();
    for table in page(path)? {
        let names: Option<Vec<usize>> = what.iter().map(|heading| table.column(heading)).collect();
        let (Some(names), Some(ours), Some(theirs)) =
            (names, table.column(ours), table.column(theirs))
        else {
            continue;
        };
        for row in &table.rows {
            let Some((a, b)) = number(&row[ours]).zip(number(&row[theirs])) else { continue };
            let name: Vec<&str> = names.iter().map(|i| row[*i].as_str()).collect();
            found.push(case(name.join(", "), a * unit_s, beside, b * unit_s));
        }
    }
    Ok(found)
}

/// Fits of psychometric functions, by maximum likelihood beside psignifit's.
fn fits(tables: &[Table]) -> Option<Case> {
    let table = tables.iter().find(|table| table.column("s a fit").is_some())?;
    let [what, time] = ["what", "s a fit"].map(|heading| table.column(heading));
    let (what, time) = (what?, time?);
    let of =
        |begin: &str| number(&table.rows.iter().find(|row| row[what].starts_with(begin))?[time]);
    let [ours, theirs] = ["zwidth, maximum likelihood", "psignifit"].map(of);
    Some(case("a fit with profile intervals".to_owned(), ours?, "psignifit", theirs?))
}

/// Solvers, each beside `exact` with its regions met before; a row with one cell is a heading.
fn solvers(tables: &[Table]) -> anyhow::Result<Vec<Case>> {
    let mut found = Vec::new();
    for table in tables {
        let columns = ["peer", "method", "sine", "time of two passes, µs"].map(|h| table.column(h));
        let [Some(peer), Some(method), Some(sine), Some(time)] = columns else { continue };
        let ready =
            table.rows.iter().find(|row| row[peer] == "zwidth exact" && row[method] == "ready");
        let ours = ready.and_then(|row| number(&row[time])).context("no row of `exact`, ready")?;
        let mut part = "";
        for row in &table.rows {
            match number(&row[time]) {
                None if row[method].is_empty() => part = &row[peer],
                Some(theirs) if !row[peer].starts_with("zwidth") => {
                    let name = format!("{part}: {}, sine {}", row[method], row[sine]);
                    found.push(case(name, ours * 1e-6, &unversioned(&row[peer]), theirs * 1e-6));
                }
                _ => {}
            }
        }
    }
    Ok(found)
}

/// A peer's name without its version, which the page of its bench has.
fn unversioned(peer: &str) -> String {
    let words = peer.split(' ').filter(|word| !word.starts_with(|c: char| c.is_ascii_digit()));
    words.collect::<Vec<_>>().join(" ")
}

/// The page's writer, and what a reader waits for, beside plotly's page.
fn browsed(tables: &[Table]) -> anyhow::Result<Vec<Case>> {
    let pairs = [
        ("one process", "wall, s", "the page and its data", "plotly's page", 1.0),
        ("page", "first trial drawn, ms", "zwidth", "plotly", 1e-3),
    ];
    let one = |(by, heading, ours, theirs, unit_s): (&str, &str, &str, &str, f64)| {
        let table =
            tables.iter().find(|t| t.column(by).is_some() && t.column(heading).is_some())?;
        let by = table.column(by)?;
        let column = table.column(heading)?;
        let of = |name: &str| number(&table.rows.iter().find(|row| row[by] == name)?[column]);
        let name = if heading == "wall, s" { "written" } else { "first trial drawn" };
        Some(case(name.to_owned(), of(ours)? * unit_s, "plotly", of(theirs)? * unit_s))
    };
    Ok(pairs.into_iter().filter_map(one).collect())
}

/// What is measured beside a peer that the same bench measures.
const PAIRS: [(&str, &str); 2] = [
    ("trial of 4,000 samples/encode, store", "trial of 4,000 samples/encode, parquet-rs defaults"),
    ("trial of 4,000 samples/read, store, all signals", "trial of 4,000 samples/read, parquet-rs"),
];
const REFERENCE: &str = "reference/loop";

/// What criterion measured of these groups.
fn from_criterion(target: &Path, groups: &[&str]) -> anyhow::Result<Vec<Case>> {
    let medians = medians(&target.join("criterion"))?;
    let Some(reference) = medians.get(REFERENCE) else { return Ok(Vec::new()) };
    let is_peer = |id: &str| PAIRS.iter().any(|(_, peer)| *peer == id);
    let own = medians.iter().filter(|(id, _)| {
        !is_peer(id) && groups.iter().any(|group| id.starts_with(&format!("{group}/")))
    });
    let cases = own.map(|(id, median)| {
        let pair = PAIRS
            .iter()
            .find(|(ours, _)| ours == id)
            .and_then(|(_, peer)| medians.get_key_value(*peer));
        let (beside, peer_s) = match pair {
            Some((peer, peer_s)) => (peer.split('/').next_back().unwrap_or(peer), *peer_s),
            None => ("the loop", *reference),
        };
        case(id.replace('/', ": "), *median, beside, peer_s)
    });
    Ok(cases.collect())
}

/// The medians of everything that criterion has measured here, s, by its full name.
fn medians(folder: &Path) -> anyhow::Result<BTreeMap<String, f64>> {
    let mut found = BTreeMap::new();
    if !folder.exists() {
        return Ok(found);
    }
    for path in files(folder)?.iter().filter(|path| path.ends_with("new/benchmark.json")) {
        let id = json(path)?["full_id"].as_str().map(str::to_owned);
        let estimates = json(&path.with_file_name("estimates.json"))?;
        let median = estimates["median"]["point_estimate"].as_f64();
        found.extend(id.zip(median.map(|ns| ns * 1e-9)));
    }
    Ok(found)
}

fn json(path: &PathBuf) -> anyhow::Result<serde_json::Value> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is no JSON", path.display()))
}

/// The least lateness that is shown, µs.
const SHOWN_US: f64 = 0.1;

/// How late one tick in a thousand is at least, beside Python's loop, quiet and busy.
fn timing(target: &Path) -> anyhow::Result<Vec<Case>> {
    let Ok(text) = fs::read_to_string(target.join("bench/timing.txt")) else {
        return Ok(Vec::new());
    };
    let late = |who: &str, load: &str| {
        let line =
            text.lines().find(|l| l.starts_with(who) && l.contains(&format!(", {load} ")))?;
        // Behind the name: p50, p99, p99.9, max, work, ticks, missed, lost.
        let late_us: f64 = line.split_whitespace().rev().nth(5)?.parse().ok()?;
        Some(late_us.max(SHOWN_US) * 1e-6)
    };
    let cases = ["quiet", "busy"].into_iter().filter_map(|load| {
        let name = format!("1 kHz, {load}: lateness of one tick in a thousand");
        Some(case(name, late("zwidth", load)?, "Python, time.sleep", late("Python", load)?))
    });
    Ok(cases.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_that_are_committed_are_understood() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let read = |page: &str| tables(&fs::read_to_string(root.join(page)).unwrap());
        let solvers = solvers(&read(PEERS)).unwrap();
        assert!(solvers.len() > 15, "{solvers:#?}");
        let first = &solvers[0];
        assert!(first.case.starts_with("error ≤ 1e-06 rad: DP5(4)"), "{first:?}");
        assert!(first.ratio() > 1.0, "{first:?}");
        assert_eq!(browsed(&read(PAGE)).unwrap().len(), 2);
    }

    #[test]
    fn what_criterion_left_is_read_and_stands_beside_its_peer_or_the_loop() {
        let target = tempfile::tempdir().unwrap();
        let measured = [
            (REFERENCE, 100.0),
            (PAIRS[0].0, 10.0),
            (PAIRS[0].1, 30.0),
            ("trial of 4,000 samples/x", 5.0),
        ];
        for (i, (id, ns)) in measured.iter().enumerate() {
            let folder = target.path().join(format!("criterion/g/{i}/new"));
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join("benchmark.json"), format!("{{\"full_id\": {id:?}}}")).unwrap();
            let estimates = format!("{{\"median\": {{\"point_estimate\": {ns}}}}}");
            fs::write(folder.join("estimates.json"), estimates).unwrap();
        }
        let found = from_criterion(target.path(), &["trial of 4,000 samples"]).unwrap();
        let told: Vec<(&str, f64)> = found.iter().map(|c| (c.beside.as_str(), c.ratio())).collect();
        assert_eq!(told.len(), 2);
        assert!(told.iter().any(
            |(who, ratio)| *who == "encode, parquet-rs defaults" && (ratio - 3.0).abs() < 1e-9
        ));
        assert!(told.iter().any(|(who, ratio)| *who == "the loop" && (ratio - 20.0).abs() < 1e-9));
    }
}
