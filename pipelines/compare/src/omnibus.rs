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

/// The tests of every environment that several participants have in several modes.
pub(crate) fn tests(cells: &Cells, measure: &Measure, parameters: &Parameters) -> Vec<Omnibus> {
    let environments = 0..parameters.environments.len();
    environments.filter_map(|e| in_environment(cells, e, measure, parameters)).collect()
}

fn in_environment(
    cells: &Cells,
    environment: usize,
    measure: &Measure,
    parameters: &Parameters,
) -> Option<Omnibus> {
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
    if modes < 2 || people.len() < 2 {
        return None;
    }
    let complete: Vec<Vec<f64>> = people
        .values()
        .filter(|own| own.len() == modes)
        .map(|own| own.values().map(|s| s.iter().sum::<f64>() / s.len() as f64).collect())
        .collect();
    let rows: Vec<&[f64]> = complete.iter().map(Vec::as_slice).collect();
    let friedman = friedman::test(&rows, SAMPLING);
    let anova = rm_anova(&complete);
    let remark = remark(&friedman, &anova);
    let (friedman, anova) = (friedman.ok(), anova.ok());
    let f = anova.as_ref().map(|anova| &anova.test);
    Some(Omnibus {
        metric: measure.parameters.metric.clone(),
        environment: parameters.environments[environment].clone(),
        modes,
        n: complete.len(),
        friedman: friedman.as_ref().map(|test| test.statistic),
        kendall_w: friedman.as_ref().map(|test| test.concordance),
        p_friedman: friedman.as_ref().map(|test| test.p_value),
        f: f.map(|test| test.statistic),
        df_modes: f.map(|test| test.df_num),
        df_error: f.map(|test| test.df_den),
        p_f: f.map(|test| test.p_value),
        epsilon_gg: anova.as_ref().map(|test| test.greenhouse_geisser),
        p_gg: anova.as_ref().map(|test| test.p_greenhouse_geisser),
        epsilon_hf: anova.as_ref().map(|test| test.huynh_feldt),
        p_hf: anova.as_ref().map(|test| test.p_huynh_feldt),
        remark: Some(remark.into()),
    })
}

/// How Friedman's p value was found, and why a test is missing.
fn remark(
    friedman: &Result<Friedman, Unestimable>,
    anova: &Result<RmAnova, Unestimable>,
) -> String {
    let friedman = match friedman.as_ref().map(|test| test.null) {
        Ok(Null::Exact) => "Friedman: exact".to_owned(),
        Ok(Null::Sampled { draws }) => format!("Friedman: {draws} orders drawn"),
        Ok(Null::Normal) => "Friedman: approximate".to_owned(),
        Err(why) => format!("no Friedman: {why}"),
    };
    match anova {
        Ok(_) => friedman,
        Err(why) => format!("{friedman}; no ANOVA: {why}"),
    }
}
