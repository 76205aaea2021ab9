//! Whether any mode differs from another: one row per environment, over complete participants.

use crate::cells::{Cells, whole};
use crate::measure::Measure;
use crate::{CompareError, Parameters, columns};
use std::collections::BTreeMap;
use zwidth_stats::friedman::{self, Friedman};
use zwidth_stats::null::{Null, Sampling};
use zwidth_stats::rm_anova::{RmAnova, rm_anova};
use zwidth_stats::{FTest, Unestimable};
use zwidth_tables::{Column, Table};

/// Orders that are drawn where there are too many participants to count all (with three modes from
/// 130 on): enough for a test that stands beside the claims.
const SAMPLING: Sampling = Sampling { draws: 999, seed: 1 };

/// One environment.
struct Row {
    environment: usize,
    /// The modes in which anybody has the metric.
    modes: usize,
    /// Participants who have it in all of them.
    n: usize,
    friedman: Result<Friedman, Unestimable>,
    anova: Result<RmAnova, Unestimable>,
}

impl Row {
    fn of(cells: &Cells, environment: usize, parameters: &Parameters) -> Option<Self> {
        let mut people: BTreeMap<usize, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
        for mode in 0..parameters.modes.len() {
            for cell in cells.of_condition(environment, mode) {
                let Some(mean) = cell.mean else { continue };
                people.entry(cell.participant).or_default().entry(mode).or_default().push(mean);
            }
        }
        let modes = (0..parameters.modes.len())
            .filter(|mode| people.values().any(|of| of.contains_key(mode)))
            .count();
        let complete: Vec<Vec<f64>> = people
            .values()
            .filter(|of| of.len() == modes)
            .map(|of| of.values().map(|s| s.iter().sum::<f64>() / s.len() as f64).collect())
            .collect();
        let rows: Vec<&[f64]> = complete.iter().map(Vec::as_slice).collect();
        (modes > 1 && people.len() > 1).then(|| Self {
            environment,
            modes,
            n: complete.len(),
            friedman: friedman::test(&rows, SAMPLING),
            anova: rm_anova(&complete),
        })
    }

    /// How Friedman's p value was found, and why a test is missing.
    fn remark(&self) -> Option<String> {
        let null = self.friedman.as_ref().ok().map(|test| match test.null {
            Null::Exact => "Friedman: exact".to_owned(),
            Null::Sampled { draws } => format!("Friedman: {draws} orders drawn"),
            Null::Normal => "Friedman: approximate".to_owned(),
        });
        let no_friedman = self.friedman.as_ref().err().map(|why| format!("no Friedman: {why}"));
        let no_anova = self.anova.as_ref().err().map(|why| format!("no ANOVA: {why}"));
        let all: Vec<String> = [null, no_friedman, no_anova].into_iter().flatten().collect();
        (!all.is_empty()).then(|| all.join("; "))
    }
}

/// The tests of every environment that several participants have in several modes, as a table.
pub(crate) fn table(
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let environments = 0..parameters.environments.len();
    let rows: Vec<Row> = environments.filter_map(|e| Row::of(cells, e, parameters)).collect();
    let count = |name, description, of: fn(&Row) -> usize| {
        Column::integer(name, "1", description, rows.iter().map(|row| whole(of(row))))
    };
    let rank = |name, description, of: fn(&Friedman) -> f64| {
        let values = rows.iter().map(|row| row.friedman.as_ref().ok().map(of));
        Column::float(name, "1", description, values)
    };
    let anova = |name, description, of: fn(&RmAnova) -> f64| {
        let values = rows.iter().map(|row| row.anova.as_ref().ok().map(of));
        Column::float(name, "1", description, values)
    };
    let f = |name, description, of: fn(&FTest) -> f64| {
        let values = rows.iter().map(|row| row.anova.as_ref().ok().map(|anova| of(&anova.test)));
        Column::float(name, "1", description, values)
    };
    let all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        count("modes", "modes in which the metric is there", |row| row.modes),
        count("n", "participants who have it in all of these", |row| row.n),
        rank("friedman", "Friedman's χ², ties corrected", |test| test.statistic),
        rank("kendall_w", "Kendall's W: 0 no common order, 1 all alike", |t| t.concordance),
        rank("p_friedman", "p value of no common order", |test| test.p_value),
        f("f", "F of the repeated-measures analysis of variance", |test| test.statistic),
        f("df_modes", "its degrees of freedom", |test| test.df_num),
        f("df_error", "its degrees of freedom for error", |test| test.df_den),
        f("p_f", "its p value, where differences of all pairs scatter alike", |test| test.p_value),
        anova("epsilon_gg", "Greenhouse–Geisser ε", |test| test.greenhouse_geisser),
        anova("p_gg", "p value with it", |test| test.p_greenhouse_geisser),
        anova("epsilon_hf", "Huynh–Feldt ε", |test| test.huynh_feldt),
        anova("p_hf", "p value with it", |test| test.p_huynh_feldt),
        Column::text(
            "remark",
            "how p was found, and why a test is missing",
            rows.iter().map(Row::remark),
        ),
    ];
    let title = format!("Any difference between modes: {}", measure.description);
    let table = Table::new(&format!("omnibus_{}", measure.name), &title, all)?;
    Ok(table.with_note(
        "Over participants, each the mean of their sessions; only those who have every mode. Claims \
         rest on the table of contrasts.",
    ))
}
