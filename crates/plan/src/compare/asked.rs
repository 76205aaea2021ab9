//! What a study asks to be compared: its metrics, how many claims that makes, and what is asked in vain.

use super::chosen::chosen_after;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::{Signal, StudyData};
use zwidth_study::{
    Bound, Curve, Effect, Environment, Families, MetricId, OutsideMetric, ParticipantId, Study,
};

/// The metrics that a study compares, where it does not say which, besides the primary one and the
/// one that is primary by default.
const OTHERS: [&str; 6] = [
    "wall_past_max_rad",
    "stiffness_n_per_rad",
    "loop_area_j",
    "force_rms_error_n",
    "returned_energy_share",
    "duration_s",
];

/// The same in a study with axes.
const IN_SPACE: [&str; 3] = ["path_m", "completion_s", "force_magnitude_mean_n"];

/// The metrics that are compared: those that trials of this study can have, the primary ones first.
/// Empty in a study with one mode, unless groups of people or factors are compared.
pub fn compared(data: &StudyData) -> Vec<String> {
    let of_answers = data.answers.iter().map(|answer| &answer.condition.mode);
    let has_modes = are_several(data.counting().map(|trial| &trial.meta.mode).chain(of_answers));
    if !has_modes && !has_group_differences(data) && data.study.effects().is_empty() {
        return Vec::new();
    }
    let mut metrics = requested_metrics(&data.study);
    metrics.retain(|metric| is_possible(data, metric));
    // Primary ones come first, and these are none.
    metrics.sort_by_key(|metric| chosen_after(data, metric).is_some());
    metrics
}

/// Whether people of several groups took part, and the study compares them.
pub(crate) fn has_group_differences(data: &StudyData) -> bool {
    let Some(groups) = &data.study.compare.groups else { return false };
    are_several(
        took_part(data).into_iter().filter_map(|who| data.people.level(who, &groups.column)),
    )
}

/// Whether two items differ.
pub(crate) fn are_several<T: PartialEq>(mut all: impl Iterator<Item = T>) -> bool {
    all.next().is_some_and(|first| all.any(|other| other != first))
}

/// Whether some trial of the study can have a metric.
fn is_possible(data: &StudyData, metric: &str) -> bool {
    if let Some(score) = zwidth_metrics::score_of(&data.study, metric) {
        return data.answers.iter().any(|answer| score.questions.contains(&answer.question));
    }
    if data.study.task_metric(metric).is_some() {
        return crate::thresholds::has_answers(data, metric);
    }
    if data.study.device.lever_m.is_none() && zwidth_metrics::needs_lever(metric) {
        return false;
    }
    if OutsideMetric::is_named(metric) && !zwidth_metrics::is_number(&data.study, metric) {
        return false;
    }
    data.counting().any(|trial| {
        let environment = data.study.environment(&trial.meta.environment);
        environment.is_some_and(|e| {
            zwidth_metrics::is_possible(&data.study, metric, &e.scene, &trial.said.signals)
        })
    })
}

/// The metrics that a study asks for, the primary ones first, each once. Without a list of the others: a
/// few of zwidth's, and the study's own.
fn requested_metrics(study: &Study) -> Vec<String> {
    let others: Vec<String> = match &study.compare.metrics {
        Some(metrics) => metrics.iter().map(ToString::to_string).collect(),
        None => {
            let default = MetricId::primary().to_string();
            let own = zwidth_metrics::own_metrics(study).map(|own| own.id.to_string());
            let outside = zwidth_metrics::outside_metrics(study).map(|own| own.column.to_string());
            let scores = zwidth_metrics::scores(study).map(|(metric, _)| metric.to_string());
            let tasks = study.task_metrics().map(|(metric, ..)| metric.to_string());
            let in_space = IN_SPACE.into_iter().filter(|_| study.axes.is_some());
            let zwidths = OTHERS.into_iter().chain(in_space).map(str::to_owned);
            let all = std::iter::once(default).chain(zwidths);
            all.chain(own).chain(outside).chain(scores).chain(tasks).collect()
        }
    };
    let mut requested: Vec<String> =
        study.compare.primary.metrics().map(ToString::to_string).collect();
    for metric in others {
        if !requested.contains(&metric) {
            requested.push(metric);
        }
    }
    requested
}

/// How many claims are adjusted together with one of a metric or curve, itself among them. As many as there
/// can be: a plan is made before it is known what every mode can have.
pub fn claims(study: &Study, name: &str) -> usize {
    match study.compare.families {
        Families::Environment => families_of(study, name).into_iter().max().unwrap_or(0),
        Families::Study if study.compare.primary.has(name) => {
            let names = study.compare.primary.names().iter();
            names.flat_map(|name| families_of(study, name.as_str())).sum()
        }
        Families::Metric | Families::Study => families_of(study, name).into_iter().sum(),
    }
}

/// How many claims on primary curves are one family with those of primary metrics, and the other way round.
pub(crate) fn claims_of_both(study: &Study) -> [usize; 2] {
    let primary = &study.compare.primary;
    if study.compare.families != Families::Study {
        return [0; 2];
    }
    let of_curves = primary.curves().flat_map(|curve| families_of(study, curve.as_str()));
    let of_metrics = primary.metrics().flat_map(|metric| families_of(study, metric.as_str()));
    [of_curves.sum(), of_metrics.sum()]
}

/// The claims of a metric or curve: of each environment that can have it, then those over several.
fn families_of(study: &Study, name: &str) -> Vec<usize> {
    let compare = &study.compare;
    let is_curve = Curve::from_word(name).is_some();
    let signals: Vec<Signal> = Signal::all().collect();
    let is_claimed = |effect: &Effect| effect.is_claimed && !effect.weights.is_empty();
    let effects: Vec<Effect> = study.effects().into_iter().filter(is_claimed).collect();
    // Of groups in the mean over modes and in each contrast; in the mode, if there is one. Curves of groups are described.
    let groups = compare.groups.as_ref().filter(|_| !is_curve);
    let of_groups = groups.map_or(0, |groups| groups.contrasts.len());
    let in_groups = if study.modes.len() > 1 { compare.contrasts.len() + 1 } else { 1 };
    let can_have = |environment: &Environment| {
        if is_curve {
            return environment.scene.pushes_back();
        }
        if let Some(score) = zwidth_metrics::score_of(study, name) {
            // Answers that are imported need not be asked for anywhere.
            let asks = |place: &Environment| {
                score.questions.iter().all(|id| place.questions().any(|own| own == id))
            };
            return asks(environment) || !study.environments.iter().any(asks);
        }
        if let Some((task, _)) = study.task_metric(name) {
            return task.environment == environment.id;
        }
        zwidth_metrics::is_possible(study, name, &environment.scene, &signals)
    };
    let in_each = study.environments.iter().filter(|own| can_have(own)).map(|environment| {
        let id = Some(&environment.id);
        let own = effects.iter().filter(|effect| effect.environment.as_ref() == id).count();
        compare.contrasts.len() + own + of_groups * (in_groups + own)
    });
    let over_several = effects.iter().filter(|effect| effect.environment.is_none());
    let over_several = over_several.filter(|effect| {
        let mut all = effect.weights.iter();
        all.all(|weight| study.environment(&weight.environment).is_some_and(can_have))
    });
    in_each.chain([over_several.count() * (1 + of_groups)]).collect()
}

/// The environments in which several people, or the study's one, have a course of a movement, in several modes unless
/// groups are compared, or an effect weighs the one over environments or sessions.
pub(crate) fn environments_of_curves(data: &StudyData) -> impl Iterator<Item = &Environment> {
    let has_groups = data.study.compare.groups.is_some();
    let effects = data.study.effects();
    let of_one = is_of_one(data);
    data.study.environments.iter().filter(move |environment| {
        let own = data.counting().filter(|trial| trial.meta.environment == environment.id);
        let (people, modes): (BTreeSet<_>, BTreeSet<_>) =
            own.map(|trial| (&trial.meta.participant, &trial.meta.mode)).unzip();
        let is_weighed = || {
            let mut claimed = effects.iter().filter(|effect| effect.is_claimed);
            claimed.any(|effect| {
                let mut weights = effect.weights.iter();
                weights.any(|weight| weight.environment == environment.id)
            })
        };
        let is_compared = match of_one {
            true => modes.len() > 1,
            false => people.len() > 1 && (has_groups || modes.len() > 1 || is_weighed()),
        };
        environment.scene.pushes_back() && is_compared
    })
}

/// Whether one participant has trials: these are compared then, and say nothing of others.
pub(crate) fn is_of_one(data: &StudyData) -> bool {
    let mut people = data.counting().map(|trial| &trial.meta.participant);
    people.next().is_some_and(|first| people.all(|own| own == first))
}

/// Whether there are curves to compare.
pub(crate) fn compares_curves(data: &StudyData) -> bool {
    let compare = &data.study.compare;
    let of_modes = data.study.modes.len() > 1 && !compare.contrasts.is_empty();
    let of_people = compare.groups.is_some() || !data.study.effects().is_empty();
    let is_any = of_modes || of_people && !is_of_one(data);
    is_any && !compare.curves.is_empty() && environments_of_curves(data).next().is_some()
}

/// Remarks on metrics in study.toml that do not exist, and on bounds that have no effect.
pub fn asked_in_vain(study: &Study) -> Vec<String> {
    let mut remarks: Vec<String> = zwidth_metrics::taken(study)
        .map(|id| {
            format!(
                "[[metrics]] of study.toml: '{id}' is a column of the tables already; give the metric another \
                 id; it is left out"
            )
        })
        .collect();
    for (stage, given) in &study.from_stages {
        if study.from_tables.iter().any(|own| own.column == given.column) {
            remarks.push(format!(
                "the stage {stage} of study.toml gives '{}', which a table of `zwidth metric` gives too: the stage counts, and \
                 the table does not; give the metric of one of them another id, or withdraw the table",
                given.column
            ));
        }
    }
    let mut are_unknown = false;
    for metric in requested_metrics(study) {
        if zwidth_metrics::is_number(study, &metric) {
            continue;
        }
        if OutsideMetric::is_named(&metric) {
            remarks.push(format!(
                "[compare] of study.toml: no values of '{metric}' are there; give a table of them with `zwidth metric`; it is \
                 left out"
            ));
            continue;
        }
        // A slide shows millimetres on its figures, but its metrics are named in radians like all.
        let in_radians = metric.replace("_per_mm", "_per_rad").replace("_mm", "_rad");
        let hint = match zwidth_metrics::is_number(study, &in_radians) {
            true => format!(": write {in_radians}, also on a slide"),
            false => String::new(),
        };
        are_unknown = true;
        remarks.push(format!(
            "[compare] of study.toml: there is no metric '{metric}' that is a number{hint}; \
             it is left out"
        ));
    }
    if are_unknown {
        let names: Vec<String> = zwidth_metrics::names(study).collect();
        remarks.push(format!("[compare] of study.toml: the metrics are {}", names.join(", ")));
    }
    let claims_of = |curve: Curve| families_of(study, curve.as_str()).into_iter().sum::<usize>();
    if study.compare.primary.curves().any(|curve| claims_of(curve) == 0) {
        remarks.push(
            "[compare] primary of study.toml: a whole curve makes no claim here. It takes an environment with \
             something to move against, and two modes or an effect of factors; differences between groups are described"
                .to_owned(),
        );
    }
    for (metric, bound) in &study.compare.bounds {
        let is_commanded = study
            .environments
            .iter()
            .any(|e| zwidth_metrics::commanded(metric.as_str(), &e.scene).is_some());
        if matches!(bound, Bound::Weber(_)) && !is_commanded {
            remarks.push(format!(
                "the bound of '{metric}' in study.toml is a Weber fraction, but no environment \
                 commands a value of it: give a number in its unit"
            ));
        }
    }
    remarks
}

/// The squared standard error of a mean over the study's groups with equal weight, times its people, over the variance of
/// one of them: Σ n/(n_g G²), which is 1 where groups are as large as each other, or are not compared.
pub fn inflation_by_groups(data: &StudyData) -> f64 {
    let Some(groups) = &data.study.compare.groups else { return 1.0 };
    let level = |who| data.people.level(who, &groups.column);
    let mut sizes = BTreeMap::new();
    for level in took_part(data).into_iter().filter_map(level) {
        *sizes.entry(level).or_insert(0.0) += 1.0;
    }
    let n: f64 = sizes.values().sum();
    let number = sizes.len() as f64;
    if sizes.is_empty() { 1.0 } else { sizes.values().map(|own| n / (own * number * number)).sum() }
}

/// Who took part: who has a trial that counts, or an answer.
pub(crate) fn took_part(data: &StudyData) -> BTreeSet<&ParticipantId> {
    let of_trials = data.counting().map(|trial| &trial.meta.participant);
    of_trials.chain(data.answers.iter().map(|answer| &answer.participant)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{
        Better, Factor, FactorId, FactorOf, GroupsCompared, LevelId, OwnMetric, Primary, Statistic,
        Term, TrialPart, Weight, Weighted,
    };

    #[test]
    fn a_primary_metric_that_there_is_not_is_told_with_those_that_there_are() {
        let mut study = crate::tests::data().study;
        assert!(asked_in_vain(&study).is_empty());
        study.compare.primary = Primary::One("softness_n".parse().unwrap());
        let told = asked_in_vain(&study);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("there is no metric 'softness_n'"), "{told:?}");
        assert!(told[1].contains("the metrics are ") && told[1].contains("wall_past_max_rad"));
    }

    #[test]
    fn a_metric_of_the_studys_own_is_asked_for_unless_its_name_is_taken() {
        let mut study = crate::tests::data().study;
        let own = |id: &str| OwnMetric {
            id: id.parse().unwrap(),
            of: "force_ex_n".to_owned(),
            statistic: Statistic::Max,
            over: TrialPart::Movement,
            label: "largest push".to_owned(),
            unit: "N".to_owned(),
            better: Better::Lower,
        };
        study.metrics = vec![own("push_n"), own("wall_dwell_s"), own("participant")];
        assert_eq!(requested_metrics(&study).last().unwrap(), "push_n");
        assert_eq!(zwidth_metrics::better(&study, "push_n"), Better::Lower);
        assert_eq!(zwidth_metrics::better(&study, "wall_dwell_s"), Better::Neither);
        let told = asked_in_vain(&study);
        let taken = |id| format!("'{id}' is a column of the tables already");
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(
            told[0].contains(&taken("wall_dwell_s")) && told[1].contains(&taken("participant"))
        );
    }

    #[test]
    fn a_claim_shares_alpha_with_every_other_of_its_family() {
        let mut study = crate::tests::data().study;
        let (environments, contrasts) = (study.environments.len(), study.compare.contrasts.len());
        assert!(environments > 1 && contrasts > 1);
        assert_eq!(claims(&study, "duration_s"), environments * contrasts);
        let walls = study.environments.iter().filter(|e| e.scene.wall_rad().is_some()).count();
        assert_eq!(claims(&study, "wall_past_max_rad"), walls * contrasts);
        let both = ["duration_s", "wall_past_max_rad"].map(|metric| metric.parse().unwrap());
        study.compare.primary = Primary::Several(both.to_vec());
        study.compare.families = Families::Study;
        assert_eq!(claims(&study, "duration_s"), (environments + walls) * contrasts);
        assert_eq!(claims(&study, "loop_area_j"), environments * contrasts);
        study.compare.families = Families::Environment;
        assert_eq!(claims(&study, "duration_s"), contrasts);
        // Each environment has a course that can be compared as a whole.
        assert!(study.environments.iter().all(|own| own.scene.pushes_back()));
        assert_eq!(claims(&study, "force_over_angle"), contrasts);
        assert_eq!(claims_of_both(&study), [0, 0]);
        study.compare.families = Families::Study;
        assert_eq!(claims(&study, "force_over_angle"), environments * contrasts);
        let with_curve =
            ["wall_past_max_rad", "force_over_angle"].map(|name| name.parse().unwrap());
        study.compare.primary = Primary::Several(with_curve.to_vec());
        let [of_curves, of_metrics] = claims_of_both(&study);
        assert_eq!([of_curves, of_metrics], [environments * contrasts, walls * contrasts]);
        assert_eq!(claims(&study, "force_over_angle"), of_curves + of_metrics);
        assert_eq!(claims(&study, "wall_past_max_rad"), of_curves + of_metrics);
        study.environments[0].scene = zwidth_study::Scene::Free;
        assert_eq!(claims_of_both(&study)[0], (environments - 1) * contrasts);
    }

    #[test]
    fn effects_are_claims_of_their_environment_and_a_weighted_contrast_of_its_own() {
        let mut study = crate::tests::data().study;
        let levels = ["low", "mid", "high"].map(|level| level.parse::<LevelId>().unwrap());
        let id: FactorId = "force".parse().unwrap();
        for (mode, level) in study.modes.iter_mut().zip(&levels) {
            mode.factors.insert(id.clone(), level.clone());
        }
        let of = FactorOf::Modes;
        study.factors = vec![Factor { id: id.clone(), levels: levels.to_vec(), unit: None, of }];
        study.compare.effects = vec![Term(vec![id])];
        study.compare.contrasts = Vec::new();
        assert_eq!((study.environments.len(), study.modes.len()), (2, 3));
        assert_eq!(claims(&study, "duration_s"), 2 * 2);
        // Of the wall alone.
        assert_eq!(claims(&study, "wall_dwell_s"), 2);
        let weight = |environment: usize, mode: usize, weight: f64| Weight {
            session: None,
            environment: study.environments[environment].id.clone(),
            mode: study.modes[mode].id.clone(),
            weight,
        };
        let within = vec![weight(0, 0, 1.0), weight(0, 1, -1.0)];
        let across = vec![weight(0, 0, 1.0), weight(1, 0, -1.0)];
        study.compare.weighted = [("within", within), ("across", across)]
            .map(|(id, weights)| Weighted { id: id.parse().unwrap(), weights })
            .to_vec();
        assert_eq!(claims(&study, "duration_s"), 2 * 2 + 1 + 1);
        // A metric of one environment has no contrast across both.
        assert_eq!(claims(&study, "wall_dwell_s"), 2);
        study.compare.families = Families::Environment;
        assert_eq!(claims(&study, "duration_s"), 3);
        // Two groups differ in the mean over modes, in each effect, and in the contrast across both.
        study.compare.families = Families::Metric;
        let levels = ["few", "many"].map(|id| id.parse().unwrap()).to_vec();
        study.compare.groups = Some(GroupsCompared {
            column: "group".parse().unwrap(),
            contrasts: vec!["many − few".parse().unwrap()],
            levels,
            assigned: false,
        });
        assert_eq!(claims(&study, "duration_s"), (2 * 2 + 1 + 1) * 2 + 2);
    }
}
