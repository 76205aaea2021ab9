//! A case of a bench: ours beside another, and the page of all cases.

use super::table::tables;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// What was measured of one thing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Case {
    pub(crate) bench: String,
    /// What was done.
    pub(crate) case: String,
    /// Median time of ours, s.
    pub(crate) ours_s: f64,
    /// Whom it is measured beside.
    pub(crate) beside: String,
    /// Median time of theirs, s.
    pub(crate) peer_s: f64,
}

impl Case {
    /// How many times as long the other takes.
    pub(crate) fn ratio(&self) -> f64 {
        self.peer_s / self.ours_s
    }
}

/// A number with three digits.
pub(crate) fn listed(number: f64) -> String {
    let digits = number.abs().log10().floor();
    let decimals = if digits.is_finite() { (2.0 - digits).clamp(0.0, 9.0) as usize } else { 0 };
    format!("{number:.decimals$}")
}

const UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)];

/// A time with its unit.
fn shown(seconds: f64) -> String {
    let (unit, size) = UNITS.into_iter().find(|(_, size)| seconds >= *size).unwrap_or(UNITS[3]);
    format!("{} {unit}", listed(seconds / size))
}

/// A time as it is shown, s.
fn time(text: &str) -> Option<f64> {
    let (number, unit) = text.split_once(' ')?;
    let (_, size) = UNITS.into_iter().find(|(name, _)| *name == unit)?;
    Some(number.parse::<f64>().ok()? * size)
}

const HEADINGS: [&str; 6] = ["bench", "case", "zwidth", "beside", "its time", "ratio"];

const INTRODUCTION: &str = "\
Medians, and how many times as long the other takes. What has no peer stands beside a loop of a
hundred thousand dependent multiplications and additions, which tells one machine from another.
`cargo xtask bench` fails where a ratio is more than 10 % below the committed one; `timing` is told
and not held, for it depends on the system's scheduler.

";

/// The page.
pub(crate) fn page(cases: &[Case], machines: &[(&str, String)]) -> String {
    let mut text =
        "<!-- Written by `cargo xtask bench`. -->\n# Speed, beside others\n\n".to_owned();
    text += INTRODUCTION;
    let _ = writeln!(text, "| {} |\n|{}", HEADINGS.join(" | "), " --- |".repeat(HEADINGS.len()));
    for case in cases {
        let Case { bench, case: what, ours_s, beside, peer_s } = case;
        let ours = shown(*ours_s);
        let theirs = shown(*peer_s);
        // Of the times as they are shown: a page that is read back is written as it was.
        let ratio = time(&theirs).zip(time(&ours)).map_or(case.ratio(), |(b, a)| b / a);
        let ratio = listed(ratio);
        let _ = writeln!(text, "| {bench} | {what} | {ours} | {beside} | {theirs} | {ratio} |");
    }
    text += "\n## Machines\n\n";
    for (bench, machine) in machines {
        let _ = writeln!(text, "* {bench}: {machine}");
    }
    text
}

/// What a page says: its cases, and the machine of each bench.
pub(crate) fn read_back(page: &str) -> (Vec<Case>, BTreeMap<String, String>) {
    let cases = tables(page)
        .into_iter()
        .filter(|table| table.headings == HEADINGS)
        .flat_map(|table| table.rows);
    let case = |row: Vec<String>| {
        let [bench, case, ours, beside, theirs, _] = <[String; 6]>::try_from(row).ok()?;
        Some(Case { bench, case, beside, ours_s: time(&ours)?, peer_s: time(&theirs)? })
    };
    let machine = |line: &str| {
        let (bench, machine) = line.strip_prefix("* ")?.split_once(": ")?;
        Some((bench.to_owned(), machine.to_owned()))
    };
    (cases.filter_map(case).collect(), page.lines().filter_map(machine).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_reads_back_as_it_was_written() {
        let case = |ours_s: f64, peer_s: f64| Case {
            bench: "peers".to_owned(),
            case: "error ≤ 1e-06 rad".to_owned(),
            ours_s,
            beside: "SciPy".to_owned(),
            peer_s,
        };
        let cases = [case(8.5e-6, 0.00519), case(0.5, 21.0), case(12e-9, 498.0)];
        let machines = [("peers", "x86_64, 2 cores".to_owned())];
        let text = page(&cases, &machines);
        assert!(
            text.contains("| peers | error ≤ 1e-06 rad | 8.50 µs | SciPy | 5.19 ms | 611 |"),
            "{text}"
        );
        let (read, told) = read_back(&text);
        assert_eq!(read.len(), 3);
        for (read, case) in read.iter().zip(&cases) {
            assert!((read.ratio() / case.ratio() - 1.0).abs() < 1e-3, "{read:?} {case:?}");
        }
        assert_eq!(told["peers"], "x86_64, 2 cores");
        assert_eq!(page(&read, &machines), text);
    }
}
