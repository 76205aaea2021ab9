//! The analysis of variance of factors, and what the line over a dose leaves of it.

use crate::Parameters;
use crate::cells::Cells;
use crate::measure::Measure;
use crate::split::Split;
use crate::weighed::{Condition, Placed, averaged, of_people, placed};
use zwidth_numerics::dense::dot;
use zwidth_results::FactorTest;
use zwidth_stats::{FTest, hotelling, rm_anova};
use zwidth_study::{Effect, LevelContrast};

/// A contrast of which less than this share is left beside others says nothing more.
const NOTHING_LEFT: f64 = 1e-9;

/// What the line over a dose, or its parabola, leaves of the differences between its levels, of which `contrasts` weigh
/// people's means in `conditions`: all contrasts that are orthogonal to its trend, tested together.
fn lack_of_fit(
    table: &[Vec<f64>],
    contrasts: &[Vec<f64>],
    conditions: &[Condition],
    dose: &Effect,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<FTest> {
    let is_trend = |effect: &&Effect| {
        (&effect.term, &effect.environment) == (&dose.term, &dose.environment)
            && matches!(effect.levels[..], [LevelContrast::Trend(_)])
    };
    let trends = parameters.effects.iter().filter(is_trend).map(|effect| {
        let weights = placed(&effect.weights, cells, parameters)?;
        let of = |condition: &Condition| weights.iter().find(|w| w.0 == *condition);
        Some(conditions.iter().map(|condition| of(condition).map_or(0.0, |w| w.1)).collect())
    });
    let trends: Vec<Vec<f64>> = trends.collect::<Option<_>>()?;
    if trends.is_empty() {
        return None;
    }
    // After Gram and Schmidt: what a trend explains, then what is left of each contrast.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for vector in trends.iter().chain(contrasts) {
        let mut left = vector.clone();
        for own in &basis {
            let along = dot(own, vector);
            left.iter_mut().zip(own).for_each(|(left, own)| *left -= along * own);
        }
        let [size, whole] = [dot(&left, &left).sqrt(), dot(vector, vector).sqrt()];
        if size > NOTHING_LEFT * whole {
            left.iter_mut().for_each(|left| *left /= size);
            basis.push(left);
        }
    }
    let rest = basis.get(trends.len()..)?;
    let left = |row: &Vec<f64>| rest.iter().map(|vector| dot(vector, row)).collect();
    hotelling::test(&table.iter().map(left).collect::<Vec<Vec<f64>>>()).ok()
}

/// The analysis of variance: a line for each factor and interaction, over the participants who have every
/// condition of it, each the mean of their complete sessions.
pub(crate) fn tests(
    cells: &Cells,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<FactorTest> {
    let mut lines = Vec::new();
    let same = |a: &Effect, b: &Effect| (&a.term, &a.environment) == (&b.term, &b.environment);
    for effects in parameters.effects.chunk_by(same) {
        // All levels less the first; of a dose its trend is claimed, which is less than all of it.
        let is_of_pairs = |effect: &&Effect| {
            effect.levels.iter().all(|level| matches!(level, LevelContrast::Pair(_)))
        };
        let effects: Vec<&Effect> = effects.iter().filter(is_of_pairs).collect();
        let Some(first) = effects.first() else { continue };
        let weights: Option<Vec<Vec<Placed>>> =
            effects.iter().map(|effect| placed(&effect.weights, cells, parameters)).collect();
        // Where the design lacks a condition, the rest is no analysis of that effect.
        let is_whole = effects.iter().all(|e| e.lacks.is_none() && !e.levels.is_empty());
        let Some(weights) = weights.filter(|_| is_whole) else { continue };
        let mut conditions: Vec<Condition> = weights.iter().flatten().map(|w| w.0).collect();
        conditions.sort_unstable();
        conditions.dedup();
        let contrasts: Vec<Vec<f64>> = weights
            .iter()
            .map(|weights| {
                let of = |condition: &Condition| weights.iter().find(|w| w.0 == *condition);
                conditions.iter().map(|condition| of(condition).map_or(0.0, |w| w.1)).collect()
            })
            .collect();
        let people = averaged(&of_people(cells, first.is_by_session()), |own| {
            conditions.iter().map(|condition| own.get(condition).copied()).collect()
        });
        // As of the effects: of groups nobody speaks who has none.
        let speaks = |who: &usize| split.is_none_or(|split| split.level(*who).is_some());
        let table: Vec<Vec<f64>> =
            people.into_iter().filter(|(who, _)| speaks(who)).map(|(_, row)| row).collect();
        let Ok(found) = rm_anova::effect(&table, &contrasts) else { continue };
        let explained = found.test.statistic * found.test.df_num;
        let lack = lack_of_fit(&table, &contrasts, &conditions, first, cells, parameters);
        lines.push(FactorTest {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: first.environment.clone(),
            effect: first.term.clone(),
            n: table.len(),
            f: found.test.statistic,
            df_effect: found.test.df_num,
            df_error: found.test.df_den,
            p_f: found.test.p_value,
            epsilon_gg: found.greenhouse_geisser,
            p_gg: found.p_greenhouse_geisser,
            eta_squared_partial: explained / (explained + found.test.df_den),
            f_lack_of_fit: lack.map(|test| test.statistic),
            df_lack_of_fit: lack.map(|test| test.df_num),
            df_lack_of_fit_error: lack.map(|test| test.df_den),
            p_lack_of_fit: lack.map(|test| test.p_value),
        });
    }
    lines
}
