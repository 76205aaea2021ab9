//! The notes below the tables: whom the tables are about, how claims were tested, who is missing.

use crate::cells::{Cell, Cells};
use crate::differences::of_everybody;
use crate::measure::Measure;
use crate::orders;
use crate::sessions::Changes;
use crate::split::Split;
use crate::trials::Trials;
use crate::{Groups, Parameters, contrasts, effects, groups};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{
    CovariateSlope, EffectDifference, FactorTest, GroupDifference, GroupModeDifference, Learning,
    Mean, MetricNote, ModeDifference, Model, NoteKind, Omnibus, OrderTest, RepeatMean, Row,
    SessionChange, TrialSlope, UnitOfAnalysis,
};
use zwidth_stats::{design_guard, sign_flip};
use zwidth_study::{Effect, Families, LevelId, OverTrials, counted};

/// A note, and what it is about.
type Note = (NoteKind, String);

/// Notes below the table of rows `R`.
pub(crate) fn below<R: Row>(measure: &Measure, notes: Vec<Note>) -> Vec<MetricNote> {
    let notes = notes.into_iter().map(|(kind, note)| MetricNote {
        metric: measure.parameters.metric.clone(),
        table: R::NAME.to_owned(),
        kind,
        note: note.into(),
    });
    notes.collect()
}

/// That a metric was chosen after the data.
fn chosen_after(measure: &Measure) -> Option<Note> {
    measure.parameters.chosen_after.clone().map(|why| (NoteKind::Care, why))
}

fn general(text: &str) -> Note {
    (NoteKind::General, text.to_owned())
}

/// Notes on means.
pub(crate) fn means(
    measure: &Measure,
    rows: &[Mean],
    split: Option<&Split>,
    unit: &UnitOfAnalysis,
) -> Vec<MetricNote> {
    let incomplete = rows.iter().filter(|row| row.trials_with_value < row.trials).map(|row| {
        let Mean { environment, mode, trials, trials_with_value, .. } = row;
        let text = format!(
            "{environment} × {mode}: {trials_with_value} of {trials} trials have the metric; the mean is \
             among those."
        );
        (NoteKind::Care, text)
    });
    let general = [general(&of_whom(unit))].into_iter().chain(split.map(weights));
    below::<Mean>(measure, general.chain(incomplete).collect())
}

/// How groups enter numbers over all people.
fn weights(split: &Split) -> Note {
    let Groups { compared, .. } = split.groups;
    let text = format!(
        "Each group ({}) has the same weight, however many people it has; intervals and standard deviations are of \
         people within groups.",
        compared.levels.iter().map(LevelId::as_str).collect::<Vec<_>>().join(", ")
    );
    general(&text)
}

/// Notes on whether any mode differs.
pub(crate) fn omnibus(measure: &Measure) -> Vec<MetricNote> {
    let note = general(
        "Over participants, each the mean of their sessions; only those who have every mode. Claims \
         rest on the table of contrasts.",
    );
    below::<Omnibus>(measure, vec![note])
}

/// Notes on mixed models.
pub(crate) fn models(measure: &Measure, rows: &[Model]) -> Vec<MetricNote> {
    let mut notes = vec![general(
        "REML over all trials, with the largest random structure that the design supports; \
         Kenward and Roger 1997. The claims rest on the table of contrasts.",
    )];
    let singular: Vec<&Model> = rows.iter().filter(|row| row.singular == Some(true)).collect();
    if !singular.is_empty() {
        // The degrees of freedom of the row where they are furthest apart.
        let pairs = singular.iter().filter_map(|row| Some([row.df?, row.df_satterthwaite?]));
        let furthest = pairs.max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
        let apart = furthest.map_or(String::new(), |[kenward_roger, satterthwaite]| {
            format!(" (here {kenward_roger:.1} and {satterthwaite:.1})")
        });
        let text = format!(
            "Where singular, a variance was estimated as zero. Satterthwaite's degrees of freedom take \
             this zero as certain, so that they count repeats as if each were another participant's, \
             while Kenward and Roger's keep the variance as unknown{apart}: p_value and the interval \
             are Kenward and Roger's, and they count."
        );
        notes.push((NoteKind::Care, text));
    }
    below::<Model>(measure, notes)
}

/// Notes on changes between sessions.
pub(crate) fn sessions(measure: &Measure, changes: &Changes) -> Vec<MetricNote> {
    let mut notes = Vec::new();
    if changes.rows.iter().any(|row| row.icc_a1_all.is_some()) {
        notes.push(general(
            "icc_a1_all is one number per condition: of all its sessions, by the mixed model with \
             participants and sessions as random effects (by its mean squares where nobody lacks a \
             session, which is the same).",
        ));
    }
    if changes.is_incomplete {
        notes.push(general(
            "Agreement takes in those who lack a session, by a mixed model of everybody's means, with \
             intervals by a parametric bootstrap (999); changes are of those who came to both.",
        ));
    }
    if changes.rows.iter().any(|row| {
        let all = [row.icc_a1, row.icc_c1, row.icc_ak, row.icc_ck, row.icc_a1_all];
        all.into_iter().flatten().any(|icc| icc < 0.0)
    }) {
        notes.push(general(
            "An ICC below 0 means that participants differed less from each other than from themselves \
             in another session (chance alone can do that where participants are alike): one session \
             tells nothing of another. It stands as it was computed; read it as 0.",
        ));
    }
    below::<SessionChange>(measure, notes)
}

/// Notes on lines over trials: that means are adjusted, and who has no line.
pub(crate) fn over_trials(
    cells: &Cells,
    trials: &Trials,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<MetricNote> {
    let Some(over) = parameters.over else { return Vec::new() };
    let over = match over {
        OverTrials::Trial => "the number of the trial",
        OverTrials::Repeat => "the repeat",
    };
    let text = format!(
        "Means are adjusted along everybody's own line over {over}, besides the modes, to the middle of each session in \
         an environment. Tests over orders, mixed models, learning and repeats are of the values as they are."
    );
    let places = cells.cells.iter().filter(|cell| cell.trials > 0);
    let places = places.map(|cell| [cell.participant, cell.environment]);
    let (nobody, lacking) =
        cells.lines.as_ref().map(|lines| lines.lacking(places)).unwrap_or_default();
    let left_out = (lacking > 0).then(|| {
        let who = counted(lacking, "participants");
        let text =
            format!("{who} without a line where others have one, each mode done once: left out.");
        (NoteKind::Care, text)
    });
    let as_they_are = nobody.into_iter().map(|place| {
        let environment = &parameters.environments[place];
        let text = format!(
            "{environment}: nobody has a line, each mode was done once in a session; means are not adjusted."
        );
        (NoteKind::Care, text)
    });
    let in_one_order = parameters.environments.iter().enumerate().filter_map(|(place, environment)| {
        trials.one_order(place).filter(|_| cells.unit() == UnitOfAnalysis::Participants)?;
        let text = format!(
            "{environment}: everybody had the modes in the same order, so that no claim is safe unless practice is a line. \
             Where it dies away, what the line leaves of it is found as a difference between modes in blocks that follow each \
             other in 7.1 % of studies of 20 people without one (of 12, in 6.1 %), more often with more people."
        );
        Some((NoteKind::Care, text))
    });
    let care: Vec<Note> = left_out.into_iter().chain(as_they_are).chain(in_one_order).collect();
    let notes = || [general(&text)].into_iter().chain(care.iter().cloned()).collect();
    let below_all = [
        below::<Mean>(measure, notes()),
        below::<ModeDifference>(measure, notes()),
        below::<EffectDifference>(measure, notes()),
        below::<FactorTest>(measure, notes()),
        below::<GroupDifference>(measure, notes()),
        below::<TrialSlope>(
            measure,
            vec![general(
                "Everybody's own line in each environment, least squares besides the means of the modes in each session; mean over \
             participants, Student's t. Exploratory: no claim is made from this table, and p is not adjusted.",
            )],
        ),
    ];
    below_all.concat()
}

/// A note on each environment in which all people had the modes in one order, so that practice and modes are not told
/// apart; none where means are adjusted for practice.
pub(crate) fn same_order(
    trials: &Trials,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<MetricNote> {
    if parameters.over.is_some() || *unit != UnitOfAnalysis::Participants {
        return Vec::new();
    }
    let mut notes = Vec::new();
    for (place, environment) in parameters.environments.iter().enumerate() {
        let Some(order) = trials.one_order(place) else { continue };
        let modes: Vec<&str> = order.iter().map(|mode| parameters.modes[*mode].as_str()).collect();
        let modes = modes.join(", ");
        // Nobody says of an import how its trials came by their numbers.
        let is_drawn = parameters.orders.iter().all(|session| session.drawn.is_some());
        let what = match is_drawn {
            true => format!("all had the modes in this order ({modes}): the difference"),
            false => format!(
                "by the trials' numbers all had the modes in this order ({modes}); if that is how they were done, the \
                 difference"
            ),
        };
        let text = format!(
            "{environment}: {what} may be learning. `covariates = [\"trial\"]` under [compare] of study.toml sets \
             practice apart as far as the order lets it."
        );
        notes.push((NoteKind::Limit, text));
    }
    match parameters.contrasts.is_empty() {
        false => below::<ModeDifference>(measure, notes),
        true => below::<EffectDifference>(measure, notes),
    }
}

/// Notes on differences over numbers of people.
pub(crate) fn covariates(measure: &Measure) -> Vec<MetricNote> {
    let note = "Least squares over participants, n − 2 degrees of freedom. Exploratory: no claim is made from this table, \
                and p is not adjusted.";
    below::<CovariateSlope>(measure, vec![general(note)])
}

/// Notes on changes from repeat to repeat.
pub(crate) fn learning(measure: &Measure) -> Vec<MetricNote> {
    below::<Learning>(measure, vec![general("Exploratory: no claim is made from this table.")])
}

/// Notes on means at each repeat.
pub(crate) fn repeats(measure: &Measure, unit: &UnitOfAnalysis) -> Vec<MetricNote> {
    let note = general(match unit {
        UnitOfAnalysis::Participants => {
            "Mean over participants, whiskers: its interval; no claim is made about single repeats."
        }
        UnitOfAnalysis::TrialsOf(_) => {
            "One participant: each dot is one trial, or the mean of the sessions."
        }
    });
    below::<RepeatMean>(measure, vec![note])
}

/// Notes on tests over orders.
pub(crate) fn order_tests(measure: &Measure) -> Vec<MetricNote> {
    let note = format!(
        "The sharp null: no trial of anyone depended on mode, carry-over included. Not a test of an \
         average effect. {} orders redrawn by the design's rules, for all participants together.",
        orders::SAMPLING.draws
    );
    below::<OrderTest>(measure, vec![general(&note)])
}

/// How the claims of a metric are adjusted for each other.
fn adjusted(is_primary: bool, parameters: &Parameters) -> String {
    match parameters.curve_claims {
        claims if claims > 0 && is_primary => format!(
            "adjusted after Holm, and after Bonferroni for {} on primary curves",
            counted(claims, "claims")
        ),
        _ => "adjusted after Holm".to_owned(),
    }
}

/// Notes on contrasts.
pub(crate) fn contrasts(
    rows: &[contrasts::Row],
    cells: &Cells,
    split: Option<&Split>,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<MetricNote> {
    let is_primary = measure.parameters.primary;
    let are_several = parameters.has_several_primary();
    let role = match (is_primary, are_several) {
        (true, false) => "Primary metric.",
        (true, true) => "A primary metric.",
        (false, false) => "Exploratory: not the primary metric.",
        (false, true) => "Exploratory: not a primary metric.",
    };
    let together = match parameters.families {
        Families::Environment => "The rows of one environment are one family of claims",
        Families::Study if is_primary && are_several => {
            "The rows of this table and of every other primary metric's are one family of claims"
        }
        Families::Metric | Families::Study => "The rows of this table are one family of claims",
    };
    let beside = match (split.is_some(), parameters.effects.is_empty()) {
        (false, true) => "",
        (true, true) => ", those of the table of groups among them",
        (false, false) => ", those of the table of effects among them",
        (true, false) => ", those of the tables of groups and of effects among them",
    };
    let adjusted = adjusted(is_primary, parameters);
    let family = format!("{role} {together}{beside}, {adjusted}; intervals are not adjusted.");
    let test = match unit {
        UnitOfAnalysis::Participants if split.is_some() => {
            "Test: the participants' differences, t with Satterthwaite's degrees of freedom, because groups \
             may scatter differently. A claim takes four people in each group. The sharp null beside it: \
             that no trial of anyone depended on mode, by other orders that the design could have drawn."
        }
        UnitOfAnalysis::Participants => {
            "Test: Student's t of the participants' differences, n − 1 degrees of freedom. The \
             sharp null beside it: that no trial of anyone depended on mode, by other orders that \
             the design could have drawn; it is no test of the average difference."
        }
        UnitOfAnalysis::TrialsOf(_) => {
            "Test: the sharp null, that no trial depended on mode, by other orders that the design \
             could have drawn. Intervals: Welch's, sessions as strata, as a description."
        }
    };
    let general = [of_whom(unit), test.to_owned(), family];
    let general =
        general.into_iter().map(|text| (NoteKind::General, text)).chain(split.map(weights));
    let plan = measure.parameters.preregistered.as_ref();
    let plan = plan.map(|plan| plan.note(cells.participants.len()));
    let notes = general
        .chain(
            jnd(rows.iter().any(|row| row.jnd.is_some()), "mode compared with", measure)
                .into_iter()
                .flatten(),
        )
        .chain(plan)
        .chain(chosen_after(measure))
        .chain(reached(rows, parameters.alpha))
        .chain(guard(rows, unit, parameters).filter(|_| split.is_none()))
        .chain(
            rows.iter().filter_map(|row| zeros(row, unit, parameters)).filter(|_| split.is_none()),
        )
        .chain(not_randomised(rows, parameters))
        .chain(without_rows(rows, cells, split, parameters))
        .chain(rows.iter().filter_map(|row| left_out(row, cells, split, measure, parameters)));
    below::<ModeDifference>(measure, notes.collect())
}

/// Notes on differences between groups.
pub(crate) fn groups(cells: &Cells, split: Option<&Split>, measure: &Measure) -> Vec<MetricNote> {
    let Some(split) = split else { return Vec::new() };
    let Groups { compared, blocks, .. } = split.groups;
    let within = if blocks.is_empty() { "" } else { " within the blocks of the drawing" };
    let meaning = match compared.assigned {
        true => format!("the column {} changed nobody's value", compared.column),
        false => format!(
            "the labels of {} could be any others, as if groups were exchangeable",
            compared.column
        ),
    };
    let mut notes = vec![
        general("n counts participants; a group's value is the mean of its people's."),
        general(
            "Test: Welch's t, because groups may scatter differently. A claim takes four people in each \
             group; with four that scatter three times as much as eight others it finds an effect in 5.9 % of \
             studies without one. Of several modes, claims are of the mean over them and of the differences between them, \
             one family with the contrasts of modes; single modes are a description.",
        ),
        general(&format!(
            "p_permuted: that {meaning}, by the share of arrangements{within} with a larger |t|."
        )),
    ];
    if !compared.assigned {
        notes.push(general(
            "Nobody's group was drawn by chance: people of two groups may differ in more than their group.",
        ));
    }
    notes.extend(chosen_after(measure));
    let without = groups::without_group(split, cells);
    if !without.is_empty() {
        let text = format!("Without {} (no {}).", without.join(", "), compared.column);
        notes.push((NoteKind::LeftOut, text));
    }
    for (level, people) in
        compared.levels.iter().zip(split.by_level((0..cells.participants.len()).map(|i| (i, ()))))
    {
        if people.is_empty() {
            notes.push((
                NoteKind::LeftOut,
                format!("Nobody who took part is of the group {level}."),
            ));
        }
    }
    let notes = below::<GroupDifference>(measure, notes);
    let of_contrasts = "Within each group: Student's t of its people's differences, n − 1 degrees of freedom. A \
                        description: that groups differ is claimed from the table of groups alone.";
    notes
        .into_iter()
        .chain(below::<GroupModeDifference>(measure, vec![general(of_contrasts)]))
        .collect()
}

/// Notes on effects of factors, and on their analysis of variance.
pub(crate) fn effects(
    rows: &[effects::Row],
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<MetricNote> {
    let claimed: Vec<&Effect> = parameters.effects.iter().filter(|own| own.is_claimed).collect();
    if claimed.is_empty() {
        return Vec::new();
    }
    let has_factors = claimed.iter().any(|effect| !effect.levels.is_empty());
    let what = if has_factors {
        "An effect is a later level of a factor less the first (of a dose its slope), the other factors averaged; of an \
         interaction, how far that depends on the other factor. "
    } else {
        ""
    };
    let sessions = match claimed.iter().any(|effect| effect.is_by_session()) {
        true => "of sessions that are levels each by itself, of others with equal weight",
        false => "sessions with equal weight",
    };
    let role = if measure.parameters.primary { "" } else { "Exploratory: not a primary metric. " };
    let together = match parameters.families {
        Families::Environment => {
            "The effects and contrasts of one environment are one family of claims, and so are those over several"
        }
        Families::Study if measure.parameters.primary && parameters.has_several_primary() => {
            "The effects and contrasts of all primary metrics are one family of claims"
        }
        Families::Metric | Families::Study => "Effects and contrasts are one family of claims",
    };
    let adjusted = adjusted(measure.parameters.primary, parameters);
    let mut notes = vec![
        general(&format!(
            "{what}Everybody has one value, of the means of their repeats, {sessions}; n counts participants."
        )),
        general(match split {
            None => {
                "Test: Student's t of participants' effects, n − 1 degrees of freedom, each with its own \
                 variance."
            }
            Some(_) => {
                "Test: t with the same weight for each group, Satterthwaite's degrees of freedom."
            }
        }),
        general(&format!("{role}{together}, {adjusted}; intervals are not adjusted.")),
    ];
    notes.extend(chosen_after(measure));
    notes.extend(split.map(weights));
    let has_jnd = rows.iter().any(effects::Row::has_jnd);
    notes.extend(jnd(has_jnd, "conditions that are subtracted", measure).into_iter().flatten());
    let of_variance = "Within participants, each effect with its own error (effect × participant), over those \
                       who have all of its conditions; an effect of which the design lacks a condition has no line. With \
                       more than one degree of freedom p is that after Greenhouse and Geisser. A description: \
                       claims rest on the effects alone.";
    let notes = below::<EffectDifference>(measure, notes);
    notes.into_iter().chain(below::<FactorTest>(measure, vec![general(of_variance)])).collect()
}

/// The just noticeable difference, if it is known, of the mean of what is compared with; and how sizes are
/// called.
fn jnd(is_known: bool, of: &str, measure: &Measure) -> Option<[Note; 2]> {
    let noticed = measure.parameters.noticed.as_ref().filter(|_| is_known)?;
    let source = noticed.perception.source(&measure.unit)?;
    let from = match noticed.commanded.iter().any(Option::is_some) {
        true => ", from the commanded value".to_owned(),
        false if matches!(&*measure.unit, "rad" | "m") => String::new(),
        false => format!(", from the mean of the {of}"),
    };
    let jnd = format!("JND, the difference that is just noticed: {source}{from}.");
    let sizes = "An interval wholly beyond ± 1 JND is called felt, one wholly within it below what is \
                 felt, any other one may be felt: a description, no claim.";
    Some([(NoteKind::Jnd, jnd), (NoteKind::General, sizes.to_owned())])
}

/// The limit of the exact tests with so few participants.
fn guard(rows: &[contrasts::Row], unit: &UnitOfAnalysis, parameters: &Parameters) -> Option<Note> {
    let fewest = rows.iter().map(|row| row.differences.len()).min()?;
    if *unit != UnitOfAnalysis::Participants {
        return None;
    }
    let claims = rows.iter().map(|row| row.claim.together).max().unwrap_or_default();
    let reached = design_guard::check(fewest, claims, parameters.alpha);
    reached.err().map(|why| (NoteKind::Limit, format!("Exact tests: {why}")))
}

/// How far differences of zero raise the smallest p value of the exact tests.
fn zeros(row: &contrasts::Row, unit: &UnitOfAnalysis, parameters: &Parameters) -> Option<Note> {
    let (n, zeros) = (row.differences.len(), row.zeros());
    if *unit != UnitOfAnalysis::Participants || zeros == 0 {
        return None;
    }
    let [without, with] = [n, n - zeros].map(|n| sign_flip::smallest_p(n).to_string());
    let environment = &parameters.environments[row.claim.environment];
    let contrast = &row.contrast;
    let text = format!(
        "{environment}, {contrast}: {zeros} of {n} differences {} 0, and a zero has no sign. So no \
         exact test (sign flip, signed rank) has a p below {with}; without zeros it could be {without}.",
        if zeros == 1 { "is" } else { "are" }
    );
    Some((NoteKind::Limit, text))
}

/// The smallest p value that the design's orders reach, and the claims that they cannot carry.
fn reached(rows: &[contrasts::Row], alpha: f64) -> Vec<Note> {
    let tests = rows.iter().filter_map(|row| row.sharp_null.as_ref().ok());
    let Some(smallest) = tests.map(|test| test.smallest_p).min_by(f64::total_cmp) else {
        return Vec::new();
    };
    let adjusted =
        rows.iter().filter_map(|row| row.claim.smallest_p_adjusted).min_by(f64::total_cmp);
    let adjusted = adjusted.map(|p| format!(", {p:.4} after Holm")).unwrap_or_default();
    let text =
        format!("Sharp null: the design's orders reach p = {smallest:.4} at best{adjusted}.");
    let refused = rows.iter().filter(|row| row.claim.out_of_reach(alpha).is_some()).count();
    let refusal = (refused > 0).then(|| {
        let text = format!(
            "No claim can be made of {refused} of {} contrasts: however large the effect, the \
             design's orders bring no adjusted p below {alpha}. More repeats, or order = \
             \"constrained\" in study.toml, would give more orders.",
            rows.len()
        );
        (NoteKind::Limit, text)
    });
    [(NoteKind::General, text)].into_iter().chain(refusal).collect()
}

/// Environments without a test of the sharp null, and why.
fn not_randomised(rows: &[contrasts::Row], parameters: &Parameters) -> Vec<Note> {
    let mut notes = Vec::new();
    for rows in rows.chunk_by(|a, b| a.claim.environment == b.claim.environment) {
        // Orders that cannot be redrawn void all contrasts of an environment alike: said once.
        let is_whole = rows.iter().all(|row| row.sharp_null.is_err());
        for row in rows.iter().take(if is_whole { 1 } else { rows.len() }) {
            let Err(why) = &row.sharp_null else { continue };
            let environment = &parameters.environments[row.claim.environment];
            let which = if is_whole { String::new() } else { format!(", {}", row.contrast) };
            let note = format!("{environment}{which}: no test of the sharp null: {why}.");
            notes.push((NoteKind::Care, note));
        }
    }
    notes
}

/// The contrasts without a row although either mode is there: an empty table says why.
fn without_rows(
    rows: &[contrasts::Row],
    cells: &Cells,
    split: Option<&Split>,
    parameters: &Parameters,
) -> Vec<Note> {
    let mut notes = Vec::new();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for contrast in &parameters.contrasts {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            let [first, second] = modes
                .map(|mode| cells.people_in(e, mode).map(|(who, _)| who).collect::<BTreeSet<_>>());
            let has_row =
                rows.iter().any(|row| row.claim.environment == e && row.contrast == *contrast);
            if has_row || first.is_empty() || second.is_empty() {
                continue;
            }
            let has_pairs = !of_everybody(cells, e, modes, parameters.level).is_empty();
            let why = match split {
                Some(split) if has_pairs => {
                    format!("nobody who has both has a {}", split.groups.compared.column)
                }
                _ if !first.is_disjoint(&second) => "nobody has both in one session".to_owned(),
                _ => format!(
                    "nobody has both ({} participants have the one, {} the other). Conditions of different \
                     people are groups: name them as a column of people ([[people]] and compare.groups of \
                     study.toml)",
                    first.len(),
                    second.len()
                ),
            };
            notes.push((NoteKind::LeftOut, format!("{environment}, {contrast}: {why}.")));
        }
    }
    notes
}

/// The participants who do not have both modes of a contrast, with what each of them lacks.
fn left_out(
    row: &contrasts::Row,
    cells: &Cells,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Option<Note> {
    let compared: BTreeSet<usize> = row.differences.iter().map(|one| one.participant).collect();
    // Those who lack the same stand together.
    let mut lacking: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (participant, name) in cells.participants.iter().enumerate() {
        if !compared.contains(&participant) {
            let without = split.filter(|split| split.level(participant).is_none());
            let what = match without {
                Some(split) => format!("no {}", split.groups.compared.column),
                None => lacks(participant, row, cells, measure, parameters)?,
            };
            lacking.entry(what).or_default().push(name.as_str());
        }
    }
    let environment = &parameters.environments[row.claim.environment];
    let contrast = &row.contrast;
    let groups: Vec<String> =
        lacking.iter().map(|(what, names)| format!("{} ({what})", names.join(", "))).collect();
    (!groups.is_empty()).then(|| {
        let text = format!("{environment}, {contrast}: without {}.", groups.join("; "));
        (NoteKind::LeftOut, text)
    })
}

/// What a participant lacks of a contrast; `None` for modes that the study does not have.
fn lacks(
    participant: usize,
    row: &contrasts::Row,
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Option<String> {
    let mut missing = Vec::new();
    for mode in parameters.modes_of(&row.contrast)? {
        let own = cells.of_condition(row.claim.environment, mode);
        let own: Vec<&Cell> = own.filter(|cell| cell.participant == participant).collect();
        let name = &parameters.modes[mode];
        if own.iter().map(|cell| cell.trials).sum::<usize>() == 0 {
            missing.push(format!("no trial of {name}"));
        } else if own.iter().all(|cell| cell.mean.is_none()) {
            missing.push(format!("no trial of {name} with {}", measure.parameters.metric));
        }
    }
    // A difference is within a session, so both modes are not enough.
    if missing.is_empty() {
        missing.push("no session with both modes".to_owned());
    }
    Some(missing.join(", "))
}

/// States what n counts in a table.
pub(crate) fn of_whom(unit: &UnitOfAnalysis) -> String {
    match unit {
        UnitOfAnalysis::Participants => {
            "n counts participants: each one's repeats are averaged, then their sessions with equal \
             weight."
                .to_owned()
        }
        UnitOfAnalysis::TrialsOf(who) => format!(
            "Within {who}: n counts trials, and nothing is said of anybody else."
        ),
    }
}
