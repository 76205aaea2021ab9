//! The experiment's results in sentences, made from the numbers (thesis §5.3.3).

use crate::answers::{median, question_of};
use crate::columns::{
    ACTUATOR_STEP, HOLD_RIGIDITY, PAST_WALL, RETURNED, RIGIDITY, RIGIDITY_AT_LEAST, SATURATION,
    SMOOTH, STABILITY, STIFFNESS, USER_STEP,
};
use crate::evidence::NOTHING_RETURNED;
use crate::gallery::Shown;
use crate::people::simulated;
use crate::trials::Trials;
use std::collections::BTreeSet;
use zwidth_results::{AnswerTally, Sentence};
use zwidth_study::{
    Coordinate, Environment, Mode, ParticipantId, SessionId, Setup, counted, in_a_sentence,
};
use zwidth_tables::{Measured, TableError, given, quantity};

/// One sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The sentence, plain text.
    pub text: Sentence,
    /// Where its numbers can be seen.
    pub shown: Shown,
    /// Whether it is an answer that the study was made for: the page begins with these.
    pub is_answer: bool,
}

impl Finding {
    /// A sentence, and where its numbers can be seen.
    pub(crate) fn new(text: impl Into<Sentence>, shown: Shown) -> Self {
        Self { text: text.into(), shown, is_answer: false }
    }
}

/// Trials, each by its participant, session and number.
pub type TrialNames = BTreeSet<(ParticipantId, SessionId, u32)>;

/// What the trials of a study show, in sentences: for each environment what each mode did, then the
/// comparison of modes, then the answers. The sentences are descriptive: they give means over
/// trials, and make no statement about anybody who did not take part. `tally` is that of the
/// answers; `doubted` are the trials whose clock, angle or velocity is to be read with care.
///
/// # Errors
/// A table that lacks a column.
pub fn findings(
    study: &Setup,
    metrics: &Measured,
    tally: Option<&[AnswerTally]>,
    doubted: &TrialNames,
) -> Result<Vec<Finding>, TableError> {
    let mut findings = Vec::new();
    for environment in &study.environments {
        let modes = study.modes.iter();
        let tried: Vec<(&Mode, Trials)> = modes
            .map(|mode| (mode, Trials::of(metrics, Some(&environment.id), &mode.id)))
            .filter(|(_, trials)| trials.len() > 0)
            .collect();
        let mut texts = Vec::new();
        for (mode, trials) in &tried {
            texts.extend(spring_by_mode(environment, mode, trials, study.coordinate)?);
        }
        texts.extend(wall_by_mode(environment, &tried, study.coordinate)?);
        let shown = Shown::Modes(environment.id.clone());
        findings.extend(texts.into_iter().map(|text| Finding::new(text, shown.clone())));
    }
    findings.extend(both(study, metrics)?);
    findings.extend(steadiness(study, metrics, doubted)?);
    if let Some(tally) = tally {
        findings.extend(answers(study, tally, simulated(metrics)));
    }
    Ok(findings)
}

/// What one mode made of the environment's spring.
fn spring_by_mode(
    environment: &Environment,
    mode: &Mode,
    trials: &Trials,
    coordinate: Coordinate,
) -> Result<Option<String>, TableError> {
    let Some(spring) = environment.scene.spring() else { return Ok(None) };
    let mut parts = Vec::new();
    if let Some(stiffness) = trials.mean(STIFFNESS)? {
        parts.push(format!(
            "compressing gave {} where {} were asked for ({})",
            quantity(stiffness.mean, "N/rad", coordinate),
            given(spring.stiffness_n_per_rad, "N/rad", coordinate),
            stiffness.words()
        ));
    }
    parts.push(match trials.mean(SATURATION)? {
        Some(force) => format!(
            "the force flattened at {} in {} of {} trials",
            quantity(force.mean, "N", coordinate),
            force.trials,
            trials.len()
        ),
        None => "no flattening of the force was found".to_owned(),
    });
    if let Some(step) = trials.mean(USER_STEP)? {
        let actuators = trials.mean(ACTUATOR_STEP)?;
        let of_these = actuators
            .map(|a| format!(" (the actuators': {})", quantity(a.mean, "N", coordinate)))
            .unwrap_or_default();
        let step = quantity(step.mean, "N", coordinate);
        parts.push(format!("extrapolated to the reversal, the user's force was {step} larger on the way in than on the way back{of_these}"));
    }
    match trials.mean(RETURNED)?.map(|share| share.mean) {
        Some(share) if share <= NOTHING_RETURNED => {
            parts.push(
                "none of the work put in came back: there was no spring on the way back".to_owned(),
            );
        }
        Some(share) => parts.push(format!("{:.0} % of the work put in came back", 100.0 * share)),
        None => {}
    }
    let mode = in_a_sentence(&mode.label);
    Ok(Some(format!("{}, {mode}: {}.", environment.label, parts.join("; "))))
}

/// How far each mode let the lever past the wall, the least first.
fn wall_by_mode(
    environment: &Environment,
    tried: &[(&Mode, Trials)],
    coordinate: Coordinate,
) -> Result<Option<String>, TableError> {
    let mut past = Vec::new();
    for (mode, trials) in tried {
        let Some(rad) = trials.mean(PAST_WALL)? else { continue };
        let mut rigidity = String::new();
        if let Some(mean) = trials.mean(RIGIDITY)? {
            // A mean of lower bounds and values is a lower bound.
            let sign = if trials.any(RIGIDITY_AT_LEAST)? { "≥ " } else { "" };
            rigidity += &format!(", rigidity {sign}{}", given(mean.mean, "N/rad", coordinate));
        }
        if let Some(mean) = trials.mean(HOLD_RIGIDITY)? {
            rigidity += &format!(", ≥ {} once held", given(mean.mean, "N/rad", coordinate));
        }
        let text = format!(
            "{} with {} (reached in {} of {} trials{rigidity})",
            quantity(rad.mean, "rad", coordinate),
            in_a_sentence(&mode.label),
            rad.trials,
            trials.len()
        );
        past.push((rad.mean, text));
    }
    past.sort_by(|a, b| a.0.total_cmp(&b.0));
    let list: Vec<String> = past.into_iter().map(|(_, text)| text).collect();
    Ok((!list.is_empty()).then(|| {
        let list = list.join(", ");
        format!("{}: past the wall the lever went, on average, {list}.", environment.label)
    }))
}

/// Of the modes that gave work back, the one that let the lever least far past a wall: what the
/// thesis' §5.3.3 asks of a mode is both. None unless at least two modes met a wall.
fn both(study: &Setup, metrics: &Measured) -> Result<Option<Finding>, TableError> {
    let mut past = Vec::new();
    let mut gave = Vec::new();
    for mode in &study.modes {
        let trials = Trials::of(metrics, None, &mode.id);
        let returned = trials.mean(RETURNED)?.is_some_and(|share| share.mean > NOTHING_RETURNED);
        let label = in_a_sentence(&mode.label);
        let mean = trials.mean(PAST_WALL)?;
        past.extend(mean.map(|rad| (rad.mean, label.clone(), returned)));
        gave.extend(returned.then_some(label));
    }
    past.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The best of a single mode would be no comparison.
    let best = past.iter().find(|(.., returned)| *returned).filter(|_| past.len() > 1);
    Ok(best.map(|(rad, label, _)| Finding::new(format!(
            "Work came back with {}; of these, {label} let the lever least far past the wall, {}.",
            gave.join(", "),
            quantity(*rad, "rad", study.coordinate)
        ), Shown::Conditions)))
}

/// Whether any mode swung. A swing in a trial that is to be read with care may be its noise.
fn steadiness(
    study: &Setup,
    metrics: &Measured,
    doubted: &TrialNames,
) -> Result<Option<Finding>, TableError> {
    let mut smooth = 0;
    let mut all = 0;
    let mut swung = Vec::new();
    for mode in &study.modes {
        let (still, n) = Trials::of(metrics, None, &mode.id).count(STABILITY, SMOOTH)?;
        (smooth, all) = (smooth + still, all + n);
        if still < n {
            swung.push(format!("{} of {n} with {}", n - still, in_a_sentence(&mode.label)));
        }
    }
    // Of the trials with a verdict, those that are to be read with care.
    let verdicts = metrics.words(STABILITY)?;
    let trials = metrics.trials().iter().zip(verdicts).filter(|(trial, _)| {
        doubted.contains(&(trial.participant.clone(), trial.session.clone(), trial.trial))
    });
    let verdicts: Vec<&str> = trials.filter_map(|(_, verdict)| verdict).collect();
    let doubtful = verdicts.len();
    let doubtful_swung = verdicts.iter().filter(|verdict| **verdict != SMOOTH).count();
    let n = all - smooth;
    let swung = swung.join(", ");
    let care = "listed under “Read with care” for clock, angle or velocity";
    let text = match (all, n) {
        (0, _) => return Ok(None),
        (_, 0) => {
            let but = match doubtful {
                0 => String::new(),
                _ => format!(" Of these, {doubtful} {} {care}.", is_are(doubtful)),
            };
            let spoken_of = match (all, metrics.trials().len() - all) {
                (1, 0) => "the one trial; it was smooth".to_owned(),
                (1, others) => format!(
                    "the one trial of {} in which it can be told; it was smooth",
                    1 + others
                ),
                (_, 0) => format!("any of {all} trials; all {all} were smooth"),
                (_, others) => format!(
                    "any of the {all} trials of {} in which it can be told; all {all} were smooth",
                    all + others
                ),
            };
            format!("No fast oscillation was found in {spoken_of}.{but}")
        }
        _ if doubtful_swung == n => format!(
            "The lever seems to swing fast in {n} of {all} trials: {swung}. All of these are {care}: \
             the swing may be noise."
        ),
        _ => {
            let but = match doubtful_swung {
                0 => String::new(),
                some => format!(
                    " Of these, {some} {} {care}: there the swing may be noise.",
                    is_are(some)
                ),
            };
            format!("The lever swung fast in {n} of {all} trials: {swung}.{but}")
        }
    };
    Ok(Some(Finding::new(text, Shown::Metrics)))
}

fn is_are(n: usize) -> &'static str {
    if n == 1 { "is" } else { "are" }
}

/// The median answer of each mode, one sentence per environment.
fn answers(study: &Setup, tally: &[AnswerTally], simulated: bool) -> Vec<Finding> {
    let mut findings = Vec::new();
    for environment in &study.environments {
        let mut list = Vec::new();
        let Some(question) = question_of(study, environment) else { continue };
        for mode in &study.modes {
            let Some(median) = median(tally, environment, mode, question) else { continue };
            let median = median.turned_back(question);
            let whose = match median.participants {
                0 | 1 => String::new(),
                people => format!(" of {people} participants"),
            };
            list.push(format!(
                "{} with {} ({}{whose})",
                median.words(),
                in_a_sentence(&mode.label),
                counted(median.answers, "answers")
            ));
        }
        let whose = if simulated { "simulated answer" } else { "answer" };
        if !list.is_empty() {
            let text =
                format!("{}: the median {whose} was {}.", environment.label, list.join(", "));
            findings.push(Finding::new(text, Shown::Answers));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answers::testing::tallied;
    use crate::trials::testing::{MetricsRow, metrics, row};

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    /// The sentences on a study whose trials of these numbers are in doubt.
    fn texts_of(
        study: &Setup,
        rows: &[MetricsRow],
        tally: Option<&[AnswerTally]>,
        doubted: &[u32],
    ) -> Vec<String> {
        let name = |trial: &u32| ("P01".parse().unwrap(), "S01".parse().unwrap(), *trial);
        let doubted = doubted.iter().map(name).collect();
        let found = findings(study, &metrics(rows), tally, &doubted).unwrap();
        found.into_iter().map(|finding| finding.text.to_string()).collect()
    }

    fn texts(rows: &[MetricsRow], tally: Option<&[AnswerTally]>) -> Vec<String> {
        texts_of(&study(), rows, tally, &[])
    }

    #[test]
    fn what_a_mode_made_of_the_spring_is_one_sentence_from_its_numbers() {
        let active = || MetricsRow {
            stiffness: Some(4.05),
            saturation: Some(4.43),
            returned: Some(0.79),
            ..row("spring", "active")
        };
        let found = texts(&[active(), active(), row("spring", "passive")], None);
        assert_eq!(
            found[0],
            "Spring, active: compressing gave 4.05\u{a0}N/rad where 4\u{a0}N/rad were asked for (mean of 2 trials); the force \
             flattened at 4.43\u{a0}N in 2 of 2 trials; 79 % of the work put in came back."
        );
        assert!(found[1].ends_with("no spring on the way back."), "{}", found[1]);
        assert_eq!(
            found[2],
            "No fast oscillation was found in any of 3 trials; all 3 were smooth."
        );
    }

    #[test]
    fn a_swing_of_a_trial_in_doubt_carries_the_mark() {
        let swung = || MetricsRow { stability: "limit cycle", ..row("spring", "active") };
        let rows = [swung(), swung(), row("spring", "active")];
        let last = |rows: &[MetricsRow], doubted: &[u32]| {
            texts_of(&study(), rows, None, doubted).pop().unwrap()
        };
        let plain = "The lever swung fast in 2 of 3 trials: 2 of 3 with active.";
        assert_eq!(last(&rows, &[]), plain);
        assert_eq!(last(&rows, &[3]), plain, "the trial in doubt did not swing");
        let care = "listed under “Read with care” for clock, angle or velocity";
        assert_eq!(
            last(&rows, &[1]),
            format!("{plain} Of these, 1 is {care}: there the swing may be noise.")
        );
        let all = format!(
            "The lever seems to swing fast in 2 of 3 trials: 2 of 3 with active. All of these are {care}: \
             the swing may be noise."
        );
        assert_eq!(last(&rows, &[1, 2]), all);
        let smooth = last(&[row("spring", "active")], &[1]);
        let one = "found in the one trial; it was smooth.";
        assert!(smooth.ends_with(&format!("{one} Of these, 1 is {care}.")), "{smooth}");
    }

    /// 292.75 N/rad on a slide whose L is 1 m are 0.293 N/mm.
    #[test]
    fn a_slide_is_told_in_newtons_per_millimetre() {
        let mut study = study();
        study.coordinate = Coordinate::Linear { lever_m: 1.0 };
        let rows = [MetricsRow { stiffness: Some(292.75), ..row("spring", "active") }];
        let found = texts_of(&study, &rows, None, &[]);
        let start =
            "Spring, active: compressing gave 0.293\u{a0}N/mm where 0.004\u{a0}N/mm were asked for";
        assert!(found[0].starts_with(start), "{}", found[0]);
    }

    #[test]
    fn the_modes_stand_in_the_order_in_which_the_wall_held() {
        let past = |mode, deg: f64| MetricsRow {
            past_rad: Some(deg.to_radians()),
            ..row("spring_wall", mode)
        };
        let rows = [past("active", 16.0), past("passive", 0.25), row("spring_wall", "passive")];
        let found = texts(&rows, None);
        let expect = "past the wall the lever went, on average, 0.250° with passive (reached in 1 of 2 trials), 16.0° \
                      with active (reached in 1 of 1 trials).";
        assert!(found[2].ends_with(expect), "{}", found[2]);
    }

    #[test]
    fn the_mode_that_does_both_gives_work_back_and_holds_the_wall_best_of_those() {
        let of = |mode, returned, past| MetricsRow {
            returned: Some(returned),
            past_rad: Some(f64::to_radians(past)),
            ..row("spring_wall", mode)
        };
        let found = texts(
            &[of("active", 0.8, 16.0), of("passive", 0.0, 0.25), of("hybrid", 0.4, 0.3)],
            None,
        );
        let expect = "Work came back with active, hybrid; of these, hybrid let the lever least far past the wall, 0.300°.";
        assert!(found.iter().any(|f| f == expect), "{found:?}");
        let none = texts(&[of("passive", 0.0, 0.25), of("active", 0.0, 1.0)], None);
        assert!(!none.iter().any(|f| f.starts_with("Work came back")), "{none:?}");
    }

    #[test]
    fn an_oscillating_trial_is_told_with_its_mode() {
        let rows = [
            MetricsRow { stability: "oscillating", ..row("spring", "hybrid") },
            row("spring", "hybrid"),
        ];
        let found = texts(&rows, None);
        assert_eq!(found[1], "The lever swung fast in 1 of 2 trials: 1 of 2 with hybrid.");
    }

    #[test]
    fn answers_of_the_twin_are_called_simulated() {
        let tally = [AnswerTally { n: 6, ..tallied("spring", "active", "felt_spring", 4) }];
        // The tally turns answers to a reversed question; the sentence has them as they were given.
        let mut turned = study();
        turned.questions.iter_mut().for_each(|question| question.reversed = true);
        let found = texts_of(&turned, &[row("spring", "active")], Some(&tally), &[]);
        assert!(found[2].contains("answer was 2 (disagree) with active"), "{}", found[2]);
        let of = |source| {
            texts(&[MetricsRow { source, ..row("spring", "active") }], Some(&tally))[2].clone()
        };
        assert_eq!(
            of("recorded"),
            "Spring: the median answer was 4 (agree) with active (6 answers)."
        );
        assert!(of("twin").contains("the median simulated answer was"));
    }
}
