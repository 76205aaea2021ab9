//! How often the thesis' statements hold for the simulated device and its participant: studies of
//! one session of one person, each number of the device drawn over its range, recorded and judged
//! as users do it. No seed is selected.

use super::{RATE, STUDY, fraction, fresh, most_hits, of_seeds, run, twin};
use crate::shell::{program, scratch};
use crate::tried::{END, held, parts};
use anyhow::{Context as _, ensure};
use std::path::Path;
use std::time::Instant;
use zwidth_device::TwinParameters;
use zwidth_results::JudgedStatement;
use zwidth_tables::Table;

const PAGE: &str = "docs/twin.md";
const CHORE: &str = "cargo xtask soak thesis";
/// Seeds of a whole run, and how many the page takes at least.
pub(crate) const SEEDS: u32 = 200;
const LEAST: u32 = 50;
/// The one number that stands in the study's own file.
const LEVER: &str = "lever_m";
/// A statement holds where so many studies of a hundred support it.
const HOLDS: f64 = 0.9;
/// Of fewer seeds it may be supported by as many as 90 % would leave in one of a thousand runs.
const RARE: f64 = 0.001;

/// Why a statement may be told less often than that. One without a reason must be told.
const WHY: &[(&str, &str)] = &[
    (
        "active_renders",
        "back-EMF and bearings drag by up to 0.25 N s/rad in the assumed ranges; the user's force falls as the lever \
         slows, and where no plateau is found the line goes through it",
    ),
    (
        "active_flattens",
        "friction of up to 0.4 N and that drag stand between the motor's 4.16 N and the user's force, which is then \
         above 4.5 N, or slopes so much that no plateau is found",
    ),
    ("active_to_some_extent", "it rests on the two above"),
    (
        "passive_stops",
        "on the way in the brake alone and the hybrid are one device, and who does not know the mode turns at one angle \
         in both; it was taken from motor and hybrid, 32°",
    ),
    (
        "hybrid_like_active",
        "soft hands swing past their angle with the motor, and six trials of each say a difference to within about \
         1.5° only, so that most of the others are undecided",
    ),
    (
        "hybrid_earlier_reversal",
        "the motor gives way above 4.16 N, so that the angle is reached sooner; the thesis itself puts it down to the \
         user's control rather than to mechanics",
    ),
    (
        "active_never_settles",
        "at the turn the lever stands while the user's force falls by twice the friction, which takes a tenth of a \
         second and more where there is much of it",
    ),
    (
        "active_as_without",
        "who likes to turn before the wall goes further where there is one to feel; and six trials say a difference \
         to within about 1.5° only",
    ),
    ("mechanics_against_perception", "it rests on the hybrid's displacement, see above"),
    ("spooling_up", "no study's tables tell"),
    ("model_misses_velocity", "no study's tables tell"),
    ("model_needs_its_device", "no study's tables tell"),
    (
        "model_true_active",
        "the model's damping of 1 N s/rad was chosen by eye on the thesis' hybrid (§4.3); the twin's is 0.02 to \
         0.25 N s/rad, so that the model stays behind where the motor gives way",
    ),
    ("model_true_passive", "the same damping, and the lengths of lever in which it is felt"),
    ("model_true_hybrid", "the same damping, and the lengths of lever in which it is felt"),
    ("model_in_time", "the same damping: the model creeps on while the lever stands"),
    ("model_velocity_varies", "the same damping: it smooths the model's velocity"),
    ("wall_lets_go", "the thesis calls it a defect of its code, which the twin's control has not"),
    (
        "brake_lets_go_again",
        "the thesis calls it a defect of its code, which the twin's control has not",
    ),
    (
        "short_of_wall",
        "a participant who is comfortable below 8 N puts 6 to 7 N on the wall, which 12 N would hold",
    ),
];

/// A statement over all studies.
#[derive(Default)]
struct Counted {
    key: String,
    source: String,
    text: String,
    unit: String,
    values: Vec<f64>,
    /// Supported, contradicted, undecided, not measured.
    verdicts: [usize; 4],
}

pub(crate) fn thesis(seeds: u32) -> anyhow::Result<()> {
    let program = program()?;
    let folder = scratch("thesis");
    let began = Instant::now();
    let studies = of_seeds(&folder, seeds, |root, seed| one(&program, root, seed))?;
    let counted = count(studies.into_iter().flatten());
    std::fs::remove_dir_all(&folder)?;
    let table = written(&counted, seeds);
    println!("{table}{seeds} studies in {:.0} s", began.elapsed().as_secs_f64());
    if seeds >= LEAST {
        put(seeds, &table)?;
    } else {
        println!("{PAGE} takes the table of {LEAST} or more alone");
    }
    judge(&counted, seeds as usize)?;
    let what = "studies of the simulated device over its ranges: nine of ten support each thesis' \
                statement but those with a reason";
    held(what, format!("{CHORE} {seeds}"), seeds.into(), began)
}

/// Records one session by somebody at a device of this seed, and judges it.
fn one(program: &Path, root: &Path, seed: u32) -> anyhow::Result<Vec<JudgedStatement>> {
    let drawn = TwinParameters::table().map(|parameter| {
        let [low, high] = parameter.range;
        Ok((parameter.name, low + (high - low) * fraction(&format!("{} {seed}", parameter.name))?))
    });
    let drawn: Vec<(&str, f64)> = drawn.into_iter().collect::<anyhow::Result<_>>()?;
    let is_lever = |(name, _): &&(&str, f64)| *name == LEVER;
    let (_, lever_m) = drawn.iter().find(is_lever).context("the twin has a lever")?;
    let layout = fresh(
        root,
        &[
            ("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {RATE}.0\n")),
            ("\nlever_m = 0.045\n", &format!("\nlever_m = {lever_m:?}\n")),
        ],
    )?;
    let others = drawn.iter().filter(|drawn| !is_lever(drawn));
    let numbers: String = others.map(|(name, value)| format!("{name} = {value:?}\n")).collect();
    std::fs::write(layout.raw().join("twin.toml"), numbers)?;
    twin(program, root, seed)?;
    run(program, root, &["--quiet", "run", STUDY, "--only", "report"], &[0])?;
    Ok(Table::from_parquet(&layout.derived().join("report/thesis.parquet"))?.to_rows()?)
}

/// The statements in their order, with what was found of each.
fn count(rows: impl Iterator<Item = JudgedStatement>) -> Vec<Counted> {
    let mut counted: Vec<Counted> = Vec::new();
    for JudgedStatement { key, source, statement: text, verdict, value, unit, .. } in rows {
        let place = counted.iter().position(|of| of.key == key).unwrap_or_else(|| {
            counted.push(Counted { key, source, text, ..Counted::default() });
            counted.len() - 1
        });
        let of = &mut counted[place];
        // In the order of the words: supported, contradicted, undecided, not measured.
        of.verdicts[verdict as usize] += 1;
        of.values.extend(value);
        if let Some(unit) = unit {
            of.unit = unit;
        }
    }
    counted
}

/// The table, and why what is not told is not.
fn written(counted: &[Counted], seeds: u32) -> String {
    let told = counted.iter().filter(|of| of.is_told(seeds)).count();
    let mut text = format!(
        "Written by `{CHORE} {seeds}`: {seeds} studies, one session of one person each. {told} of {} statements are told.\n\n\
         | statement | source | supported | contradicted | undecided | not measured | value: median (5 to 95 %) |\n\
         |---|---|---|---|---|---|---|\n",
        counted.len()
    );
    for of in counted {
        let [a, b, c, d] = of.verdicts;
        let words = &of.text;
        let source = &of.source;
        let words = if of.is_told(seeds) { words.clone() } else { format!("*{words}*") };
        let value = spread(&of.values, &of.unit);
        text += &format!("| {words} | {source} | {a} | {b} | {c} | {d} | {value} |\n");
    }
    text += "\nNot told, and why:\n\n";
    for of in counted.iter().filter(|of| !of.is_told(seeds)) {
        text += &format!("* {}: {}.\n", of.text, why(&of.key).unwrap_or("unknown"));
    }
    text
}

impl Counted {
    /// Whether nine of ten studies support it.
    fn is_told(&self, seeds: u32) -> bool {
        self.verdicts[0] as f64 >= HOLDS * f64::from(seeds)
    }
}

fn why(key: &str) -> Option<&'static str> {
    WHY.iter().find(|(of, _)| *of == key).map(|(_, why)| *why)
}

/// Median, and the values between which nine of ten lie.
fn spread(values: &[f64], unit: &str) -> String {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    let Some(((low, middle), high)) = at(0.05).zip(at(0.5)).zip(at(0.95)) else {
        return String::new();
    };
    let unit = if unit == "1" || unit.is_empty() { String::new() } else { format!(" {unit}") };
    format!("{middle:.2} ({low:.2} to {high:.2}){unit}")
}

fn put(seeds: u32, table: &str) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(PAGE)?;
    let begin = format!("<!-- begin: {CHORE} -->\n");
    let [before, _, after] = parts(&text, &begin)?;
    std::fs::write(PAGE, format!("{before}{begin}{table}{END}{after}"))?;
    println!("{PAGE} has the table of {seeds}");
    Ok(())
}

/// Fails where a statement is told too seldom without a reason.
fn judge(counted: &[Counted], seeds: usize) -> anyhow::Result<()> {
    let least = least(seeds);
    let mut wrong = Vec::new();
    for Counted { key, verdicts, .. } in counted {
        if why(key).is_none() && verdicts[0] < least {
            wrong.push(format!("{key}: supported by fewer than {least} of {seeds}"));
        }
    }
    let unknown = WHY.iter().filter(|(key, _)| counted.iter().all(|of| of.key != *key));
    wrong.extend(unknown.map(|(key, _)| format!("{key} is no statement")));
    ensure!(wrong.is_empty(), "{}", wrong.join("\n"));
    Ok(())
}

/// How many studies must support a statement: 90 %, or of fewer than a whole run as many as 90 %
/// would give but for one run in a thousand.
fn least(seeds: usize) -> usize {
    if seeds >= SEEDS as usize {
        return (HOLDS * seeds as f64).ceil() as usize;
    }
    most_hits(seeds, HOLDS, |reached| 1.0 - reached < RARE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::ClaimVerdict;

    /// SciPy: `binom.ppf(0.999, n, 0.1)` misses.
    #[test]
    fn few_seeds_are_judged_by_the_binomial_distribution_and_many_by_the_share() {
        assert_eq!(least(12), 12 - 5);
        assert_eq!(least(40), 40 - 11);
        assert_eq!(least(200), 180);
    }

    #[test]
    fn what_nine_of_ten_values_lie_between_is_told_with_its_unit() {
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(spread(&values, "°"), "50.00 (5.00 to 95.00) °");
        assert_eq!(spread(&[], "°"), "");
    }

    #[test]
    fn statements_are_counted_by_their_verdicts_in_their_order() {
        let row = |key: &str, verdict| JudgedStatement {
            key: key.to_owned(),
            source: "§1".to_owned(),
            statement: key.to_owned(),
            verdict,
            metric: None,
            value: Some(1.0),
            ci_low: None,
            ci_high: None,
            unit: Some("N".to_owned()),
            n: None,
            unit_of_analysis: None,
            asked: None,
            shown: None,
            remark: None,
        };
        let rows = [
            row("b", ClaimVerdict::Supported),
            row("a", ClaimVerdict::Undecided),
            row("b", ClaimVerdict::Contradicted),
        ];
        let counted = count(rows.into_iter());
        let found: Vec<_> = counted.iter().map(|of| (of.key.as_str(), of.verdicts)).collect();
        assert_eq!(found, [("b", [1, 1, 0, 0]), ("a", [0, 0, 1, 0])]);
    }
}
