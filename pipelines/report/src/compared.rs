//! What the comparison of modes says, in a matrix and in sentences.

use crate::findings::Finding;
use crate::gallery::Shown;
use serde::Serialize;
use zwidth_study::{EnvironmentId, ModeId, Setup, contrast_label};
use zwidth_tables::{Table, TableError, Values, for_people, number, p_value, with_unit};

/// What a study says of a metric that it compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The study's primary metric, whose claims count. That one may not be among those compared:
    /// trials of the study may not have it.
    Primary,
    /// The same, where study.toml names no other than the one that is primary by default.
    PrimaryByDefault,
    /// Any other.
    Exploratory,
}

/// A metric's tables of the stage `compare`.
#[derive(Debug, Clone, Copy)]
pub struct ComparedMetric<'a> {
    /// Its column in the table of metrics.
    pub name: &'a str,
    /// What the study says of it.
    pub role: Role,
    /// Means by condition.
    pub means: &'a Table,
    /// Differences between modes.
    pub contrasts: &'a Table,
}

/// Means by metric, environment and mode.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Matrix {
    /// The modes and their labels.
    pub modes: Vec<(ModeId, String)>,
    /// A row a metric and environment.
    pub rows: Vec<MatrixRow>,
    /// What stands in the cells, a sentence.
    pub caption: String,
}

/// A metric in one environment.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MatrixRow {
    /// The metric in words, with its unit.
    pub metric: String,
    /// The environment.
    pub environment: EnvironmentId,
    /// Its label.
    pub label: String,
    /// One cell per mode, where it has a mean: `1.617 ± 0.029 (6)`.
    pub cells: Vec<Option<String>>,
}

/// The numbers of a column by its name without the unit.
pub(crate) fn floats(table: &Table, stem: &str) -> Result<Vec<Option<f64>>, TableError> {
    match &table.column_of(stem)?.values {
        Values::Float(values) => Ok(values.clone()),
        _ => table.floats(stem),
    }
}

/// The metric in words, from the title of one of its tables.
pub(crate) fn words(table: &Table) -> &str {
    table.title().split_once(": ").map_or(table.title(), |(_, words)| words)
}

/// The means of every metric, environment and mode, as people read them.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn matrix(study: &Setup, metrics: &[ComparedMetric]) -> Result<Matrix, TableError> {
    let mut matrix = Matrix {
        modes: study.modes.iter().map(|mode| (mode.id.clone(), mode.label.clone())).collect(),
        ..Matrix::default()
    };
    for metric in metrics {
        let means = for_people(metric.means, study.coordinate)?;
        let unit = means.column_of("mean")?.field.unit.to_string();
        let unit = if unit == "1" { String::new() } else { format!(" ({unit})") };
        let (environments, modes) = (means.texts("environment")?, means.texts("mode")?);
        let (mean, sd, n) = (floats(&means, "mean")?, floats(&means, "sd")?, means.integers("n")?);
        for environment in &study.environments {
            let of_mode = |mode: &str| {
                let is = |row: &usize| {
                    environments[*row].as_deref() == Some(environment.id.as_str())
                        && modes[*row].as_deref() == Some(mode)
                };
                let row = (0..means.height()).find(is)?;
                let spread = sd[row].map(|sd| format!(" ± {}", number(sd, Some(sd))));
                let mean = number(mean[row]?, sd[row]);
                Some(format!("{mean}{} ({})", spread.unwrap_or_default(), n[row]?))
            };
            let cells: Vec<Option<String>> =
                study.modes.iter().map(|mode| of_mode(mode.id.as_str())).collect();
            if cells.iter().any(Option::is_some) {
                matrix.rows.push(MatrixRow {
                    metric: format!("{}{unit}", words(&means)),
                    environment: environment.id.clone(),
                    label: environment.label.clone(),
                    cells,
                });
            }
        }
        if matrix.caption.is_empty() && means.height() > 0 {
            matrix.caption = caption(&unit_of_analysis(&means)?);
        }
    }
    Ok(matrix)
}

/// `participants`, `trials of P01`.
fn unit_of_analysis(table: &Table) -> Result<String, TableError> {
    Ok(table.texts("unit_of_analysis")?.into_iter().flatten().next().unwrap_or_default())
}

fn caption(unit: &str) -> String {
    match unit.strip_prefix("trials of ") {
        Some(who) => format!(
            "Mean ± standard deviation within {who}; in brackets the number of trials. \
             Nothing is said of anybody else."
        ),
        None => format!("Mean ± standard deviation over {unit}; in brackets their number."),
    }
}

/// What the contrasts of the first of `metrics` say, the primary one where it is there: first how
/// many show a difference, then each in a sentence with effect, interval, n and unit. Of each other
/// metric, one sentence with its differences.
///
/// # Errors
/// Tables that are not of the stage `compare`.
pub fn contrasts(study: &Setup, metrics: &[ComparedMetric]) -> Result<Vec<Finding>, TableError> {
    let Some((first, others)) = metrics.split_first() else { return Ok(Vec::new()) };
    let table = for_people(first.contrasts, study.coordinate)?;
    let sentences = sentences(study, &table)?;
    if sentences.is_empty() {
        return Ok(Vec::new());
    }
    let exploratory = others.iter().map(|metric| {
        let text = briefly(study, &for_people(metric.contrasts, study.coordinate)?)?;
        let shown = Shown::Compared(metric.name.to_owned());
        Ok(text.map(|text| Finding { text, shown }))
    });
    let exploratory: Vec<Option<Finding>> = exploratory.collect::<Result<_, TableError>>()?;
    let shown = Shown::Compared(first.name.to_owned());
    let texts = [answer(&table, first.role)?].into_iter().chain(sentences);
    let found = texts.map(|text| Finding { text, shown: shown.clone() });
    Ok(found.chain(exploratory.into_iter().flatten()).collect())
}

/// How many contrasts show a difference; if no contrast has a test, that it was not asked.
fn answer(table: &Table, role: Role) -> Result<String, TableError> {
    let verdicts: Vec<String> = table.texts("verdict")?.into_iter().flatten().collect();
    let differ = verdicts.iter().filter(|verdict| verdict.starts_with("different")).count();
    let (who, the) = match unit_of_analysis(table)?.strip_prefix("trials of ") {
        Some(who) => (format!("Within {who}, "), "the"),
        None => (String::new(), "The"),
    };
    let all = verdicts.len();
    let metric = match role {
        Role::Primary => format!("the primary metric, {}", words(table)),
        Role::PrimaryByDefault => {
            format!("the primary metric, {} (primary by default)", words(table))
        }
        Role::Exploratory => format!("{} (exploratory: not the primary metric)", words(table)),
    };
    if floats(table, "p_adjusted")?.iter().all(Option::is_none) {
        let whether = format!("whether {} modes differ in {metric}", the.to_lowercase());
        let start = if who.is_empty() { "It" } else { "it" };
        return Ok(format!(
            "{who}{start} was not tested {whether}: none of {all} contrasts has a test."
        ));
    }
    let n = size(table)?;
    let text = match (differ, all) {
        (0, _) => format!("{who}{the} modes were not shown to differ in {metric} ({n})."),
        (1, 1) => format!("{who}{the} modes were shown to differ in {metric} ({n})."),
        _ => format!(
            "{who}{the} modes were shown to differ in {metric}, in {differ} of {all} contrasts ({n})."
        ),
    };
    Ok(smallest_p(table).map_or(text.clone(), |p| {
        format!(
            "{text} The test compares the order of trials that was drawn with every other order that the design could \
             have drawn; with this design, no adjusted p can be below {}. The intervals only describe the trials.",
            number(p, None)
        )
    }))
}

/// `n = 4 participants`, `n = 3 to 4 participants`: over all contrasts.
fn size(table: &Table) -> Result<String, TableError> {
    let n: Vec<i64> = table.integers("n")?.into_iter().flatten().collect();
    let ends = n.iter().min().zip(n.iter().max()).unwrap_or((&0, &0));
    let n = if ends.0 == ends.1 { ends.0.to_string() } else { format!("{} to {}", ends.0, ends.1) };
    Ok(format!("n = {n} {}", unit_of_analysis(table)?))
}

/// The smallest adjusted p value that the design's orders reach, where claims rest on them.
fn smallest_p(table: &Table) -> Option<f64> {
    floats(table, "smallest_p_adjusted").ok()?.into_iter().flatten().min_by(f64::total_cmp)
}

/// The differences of a metric on which no claim rests, in one sentence.
fn briefly(study: &Setup, table: &Table) -> Result<Option<String>, TableError> {
    let told: Vec<String> = differences(study, table)?.into_iter().map(|d| d.in_brief()).collect();
    let text = format!("Exploratory, {}: {}.", words(table), told.join("; "));
    Ok((!told.is_empty()).then_some(text))
}

/// Each contrast in a sentence.
fn sentences(study: &Setup, table: &Table) -> Result<Vec<String>, TableError> {
    let of = words(table);
    Ok(differences(study, table)?.into_iter().map(|difference| difference.told(of)).collect())
}

/// A difference between two modes in one environment, in words.
struct Told {
    place: String,
    amount: String,
    interval: Option<String>,
    n: String,
    /// `t(5) = −3.21`, between participants.
    test: Option<String>,
    /// `= 0.0123` or `< 0.001`, adjusted.
    p: Option<String>,
    /// `g_av = −1.4`, likewise.
    effect: Option<String>,
    verdict: String,
    /// `below what is felt: −0.03 JND (−0.05 to −0.01)`, where a difference that is just noticed is known.
    size: Option<String>,
}

impl Told {
    fn told(&self, metric: &str) -> String {
        let Self { place, amount, n, verdict, .. } = self;
        let interval = self.interval.as_ref().map(|ends| format!("interval {ends}, "));
        let p = self.p.as_ref().map(|p| format!("adjusted p {p}"));
        let more: String = [self.test.clone(), p, self.effect.clone()]
            .into_iter()
            .flatten()
            .map(|said| format!(", {said}"))
            .collect();
        let why = if verdict == UNDECIDED { NEITHER } else { "" };
        let size = self.size.as_ref().map(|size| format!("; {size}")).unwrap_or_default();
        format!(
            "{place}: the difference in {metric} is {amount} ({}n = {n}{more}): {verdict}{why}{size}.",
            interval.unwrap_or_default(),
        )
    }

    fn in_brief(&self) -> String {
        let Self { place, amount, verdict, .. } = self;
        let interval = self.interval.as_ref().map(|ends| format!("{ends}, ")).unwrap_or_default();
        let size = self.size.as_ref().map(|size| format!(", {size}")).unwrap_or_default();
        format!("{place}: {amount} ({interval}{verdict}{size})")
    }
}

/// Every contrast that has an estimate.
fn differences(study: &Setup, table: &Table) -> Result<Vec<Told>, TableError> {
    let unit = table.column_of("difference")?.field.unit.to_string();
    let (environments, contrasts) = (table.texts("environment")?, table.texts("contrast")?);
    let (verdicts, remarks) = (table.texts("verdict")?, table.texts("remark")?);
    let n = table.integers("n")?;
    let of = |stem| floats(table, stem);
    let (difference, error) = (of("difference")?, of("difference_std_error")?);
    let (low, high) = (of("difference_ci_low")?, of("difference_ci_high")?);
    let p = of("p_adjusted")?;
    // With one participant there is no test by t, and not every metric is felt.
    let [t, df, in_jnds, jnds_low, jnds_high] =
        ["statistic", "df", "difference_jnd", "difference_jnd_ci_low", "difference_jnd_ci_high"]
            .map(|stem| of(stem).unwrap_or_else(|_| vec![None; table.height()]));
    let effects = EFFECTS.map(|stem| (stem, of(stem).ok()));
    let sizes = table.texts("size").unwrap_or_else(|_| vec![None; table.height()]);
    let counted = unit_of_analysis(table)?;
    let label = |id: &str| {
        let known = study.environments.iter().find(|e| e.id.as_str() == id);
        known.map_or_else(|| id.to_owned(), |e| e.label.clone())
    };
    let mut found = Vec::new();
    for row in 0..table.height() {
        let (Some(environment), Some(contrast)) = (&environments[row], &contrasts[row]) else {
            continue;
        };
        let Some(estimate) = difference[row] else { continue };
        let amount = with_unit(&number(estimate, error[row]), &unit);
        let interval = low[row].zip(high[row]).map(|(low, high)| {
            let [low, high] = [low, high].map(|end| number(end, error[row]));
            format!("{low} to {high}")
        });
        found.push(Told {
            place: format!("{}, {}", label(environment), contrast_label(&study.modes, contrast)),
            amount,
            interval,
            n: format!("{} {counted}", n[row].unwrap_or_default()),
            test: t[row]
                .zip(df[row])
                .map(|(t, df)| format!("t({}) = {}", number(df, None), number(t, None))),
            p: p[row].map(p_value),
            effect: effects.iter().find_map(|(name, values)| {
                let effect = (*values.as_ref()?)[row]?;
                Some(format!("{name} = {}", number(effect, None)))
            }),
            verdict: match (verdicts[row].clone().unwrap_or_default(), &remarks[row]) {
                (verdict, Some(remark)) => format!("{verdict}: {remark}"),
                (verdict, None) => verdict,
            },
            size: sizes[row].as_ref().map(|size| {
                let [jnds, low, high] = [in_jnds[row], jnds_low[row], jnds_high[row]]
                    .map(|jnds| jnds.map_or_else(String::new, |jnds| number(jnds, None)));
                format!("{size}: {jnds} JND ({low} to {high})")
            }),
        });
    }
    Ok(found)
}

/// Effect sizes that a study may have: of several the first is told.
const EFFECTS: [&str; 4] = ["g_av", "g_z", "d_av", "d_z"];
/// The verdict of a contrast that shows nothing.
const UNDECIDED: &str = "undecided";
const NEITHER: &str = ", neither a difference nor its absence was shown";

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    fn text(name: &'static str, values: &[&str]) -> Column {
        Column::text(name, "", values.iter().map(|v| Some((*v).to_owned())))
    }

    fn means(unit: &str) -> Table {
        let float = |name, values: [f64; 2]| Column::float(name, "rad", "", values.map(Some));
        let columns = vec![
            text("environment", &["spring", "spring"]),
            text("mode", &["active", "hybrid"]),
            text("unit_of_analysis", &[unit, unit]),
            Column::integer("n", "1", "", [Some(6), Some(5)]),
            float("mean_rad", [0.2, 0.1]),
            float("sd_rad", [0.012, 0.025]),
        ];
        Table::new("means", "Means by condition: angle past the wall", columns).unwrap()
    }

    fn differences(unit: &str, verdict: &str, p_adjusted: Option<f64>) -> Table {
        let float = |name, v: f64| Column::float(name, "rad", "", [Some(v)]);
        let mut columns = vec![
            text("environment", &["spring"]),
            text("contrast", &["hybrid − active"]),
            text("unit_of_analysis", &[unit]),
            Column::integer("n", "1", "", [Some(6)]),
            float("difference_rad", -0.1),
            float("difference_std_error_rad", 0.02),
            float("difference_ci_low_rad", -0.15),
            float("difference_ci_high_rad", -0.05),
            Column::float("p_adjusted", "1", "", [p_adjusted]),
            text("verdict", &[verdict]),
            Column::text("remark", "", [None::<String>]),
        ];
        if unit == "participants" {
            columns.push(Column::float("statistic", "1", "", [Some(-5.0)]));
            columns.push(Column::float("df", "1", "", [Some(5.0)]));
            columns.push(Column::float("d_av", "1", "", [Some(-1.25)]));
        }
        Table::new("contrasts", "Modes compared: angle past the wall", columns).unwrap()
    }

    fn texts_of(role: Role, contrasts_of: &Table) -> Vec<String> {
        let means = means("participants");
        let (name, contrasts_of) = ("past", contrasts_of);
        let metric = ComparedMetric { name, role, means: &means, contrasts: contrasts_of };
        contrasts(&study(), &[metric]).unwrap().into_iter().map(|found| found.text).collect()
    }

    fn texts(unit: &str, verdict: &str) -> Vec<String> {
        texts_of(Role::Primary, &differences(unit, verdict, Some(0.0123)))
    }

    #[test]
    fn the_matrix_has_mean_deviation_and_number_in_degrees_and_a_dash_where_nothing_is() {
        let means = means("participants");
        let contrasts = differences("participants", "different", Some(0.0123));
        let metric = ComparedMetric {
            name: "past",
            role: Role::Primary,
            means: &means,
            contrasts: &contrasts,
        };
        let matrix = matrix(&study(), &[metric]).unwrap();
        let row = MatrixRow {
            metric: "angle past the wall (°)".to_owned(),
            environment: "spring".parse().unwrap(),
            label: "Spring".to_owned(),
            cells: [Some("11.46 ± 0.69 (6)"), None, Some("5.7 ± 1.4 (5)")]
                .map(|cell| cell.map(str::to_owned))
                .to_vec(),
        };
        assert_eq!(matrix.rows, [row]);
        assert!(matrix.caption.contains("over participants"), "{}", matrix.caption);
    }

    #[test]
    fn a_difference_is_told_with_its_interval_its_n_and_its_unit_after_the_answer() {
        let found = texts("participants", "different");
        let answer = "The modes were shown to differ in the primary metric, angle past the wall (n = 6 participants).";
        assert_eq!(found[0], answer);
        assert_eq!(
            found[1],
            "Spring, Hybrid − Active: the difference in angle past the wall is −5.7° (interval −8.6 to −2.9, \
             n = 6 participants, t(5) = −5, adjusted p = 0.0123, d_av = −1.25): different."
        );
    }

    #[test]
    fn no_p_is_told_to_be_nothing() {
        let found = texts_of(Role::Primary, &differences("participants", "different", Some(0.0)));
        assert!(found[1].contains(", adjusted p < 0.001, "), "{}", found[1]);
    }

    #[test]
    fn a_metric_that_is_not_the_primary_one_is_not_called_so() {
        let differences = differences("participants", "different", Some(0.0123));
        for (role, words) in [
            (Role::Exploratory, "angle past the wall (exploratory: not the primary metric) ("),
            (
                Role::PrimaryByDefault,
                "the primary metric, angle past the wall (primary by default) (",
            ),
        ] {
            let found = texts_of(role, &differences);
            assert!(found[0].contains(words), "{}", found[0]);
        }
    }

    #[test]
    fn what_was_not_tested_is_not_told_as_a_difference_that_was_not_shown() {
        let untested = differences("trials of P01", "not tested", None);
        let answer = "Within P01, it was not tested whether the modes differ in the primary metric, \
                      angle past the wall: none of 1 contrasts has a test.";
        assert_eq!(texts_of(Role::Primary, &untested)[0], answer);
    }

    #[test]
    fn with_one_participant_it_is_said_within_whom() {
        let found = texts("trials of P01", "undecided");
        assert!(found[0].starts_with("Within P01, the modes were not shown to differ"));
        assert!(found[1].contains("n = 6 trials of P01"), "{}", found[1]);
    }
}
