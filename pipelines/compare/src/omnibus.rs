//! Whether any mode differs from another: one row per environment, over complete participants.

use crate::Parameters;
use crate::cells::Cells;
use crate::measure::Measure;
use std::collections::BTreeMap;
use zwidth_results::Omnibus;
use zwidth_stats::Unestimable;
use zwidth_stats::friedman::{self, Friedman};
use zwidth_stats::null::{Null, Sampling};
use zwidth_stats::rm_anova::{RmAnova, rm_anova};

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
        // A mode in which nobody has the metric would leave no participant complete.
        let modes = (0..parameters.modes.len())
            .filter(|mode| people.values().any(|own| own.contains_key(mode)))
            .count();
        let complete: Vec<Vec<f64>> = people
            .values()
            .filter(|own| own.len() == modes)
            .map(|own| own.values().map(|s| s.iter().sum::<f64>() / s.len() as f64).collect())
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

/// The tests of every environment that several participants have in several modes.
pub(crate) fn tests(cells: &Cells, measure: &Measure, parameters: &Parameters) -> Vec<Omnibus> {
    let environments = 0..parameters.environments.len();
    let rows = environments.filter_map(|e| Row::of(cells, e, parameters));
    rows.map(|row| {
        let (friedman, anova) = (row.friedman.as_ref().ok(), row.anova.as_ref().ok());
        let f = anova.map(|anova| &anova.test);
        Omnibus {
            metric: measure.parameters.metric.clone(),
            environment: parameters.environments[row.environment].clone(),
            modes: row.modes,
            n: row.n,
            friedman: friedman.map(|test| test.statistic),
            kendall_w: friedman.map(|test| test.concordance),
            p_friedman: friedman.map(|test| test.p_value),
            f: f.map(|test| test.statistic),
            df_modes: f.map(|test| test.df_num),
            df_error: f.map(|test| test.df_den),
            p_f: f.map(|test| test.p_value),
            epsilon_gg: anova.map(|test| test.greenhouse_geisser),
            p_gg: anova.map(|test| test.p_greenhouse_geisser),
            epsilon_hf: anova.map(|test| test.huynh_feldt),
            p_hf: anova.map(|test| test.p_huynh_feldt),
            remark: row.remark().map(Into::into),
        }
    })
    .collect()
}
