//! What a study's tables say about a statement.

use crate::answers::{median, question_of, scored};
use crate::columns::STIFFNESS;
use crate::evidence::{Derived, Stop, Verdict};
use crate::gallery::Shown;
use crate::thesis::estimate::{Estimated, difference, mean};
use crate::thesis::judged::{condition, judged, not_measured, people, trials, unjudged};
use crate::thesis::rule::{
    Bound, Case, From, Quantity, Rule, Statement, Test, is_as_in_the_thesis,
};
use crate::thesis::statements;
use crate::trials::Trials;
use std::collections::BTreeMap;
use zwidth_results::JudgedStatement;
use zwidth_stats::power::clopper_pearson;
use zwidth_stats::superiority::{Repeats, superiority};
use zwidth_study::{AnswerValue, Coordinate, Environment, ModeLaw, ParticipantId, in_a_sentence};
use zwidth_tables::TableError;

/// Above this share of pairs with the higher answer, and below one less it, a difference counts
/// that no interval tells: 0.56, a small effect (Vargha & Delaney 2000, J. Educ. Behav. Stat.
/// 25:101).
const SMALL_EFFECT: f64 = 0.56;

/// The verdict on a statement; `before` are those judged so far, by key.
pub(crate) fn judge(
    statement: &Statement,
    before: &BTreeMap<&str, Verdict>,
    derived: &Derived,
) -> Result<JudgedStatement, TableError> {
    let judged = match statement.rule {
        Rule::In(case, test) => judge_case(test, case, statement.printed, derived),
        Rule::All(parts) => all_of(parts, before).map(|judged| JudgedStatement {
            shown: Some(derived.gallery.file(&Shown::Statements)),
            ..judged
        }),
        Rule::Forces(judge) => judge(derived),
        Rule::Untold(why) => not_measured(why),
    };
    let judged = match judged {
        Ok(judged) => judged,
        Err(Stop::Table(error)) => return Err(error),
        Err(Stop::NotMeasured(why)) => JudgedStatement { remark: Some(why.into()), ..unjudged() },
    };
    Ok(JudgedStatement {
        key: statement.key.to_owned(),
        source: statement.source.to_owned(),
        statement: statement.text.to_owned(),
        ..judged
    })
}

/// A test of one condition.
fn judge_case(
    test: Test,
    case: Case,
    printed: bool,
    derived: &Derived,
) -> Result<JudgedStatement, Stop> {
    let (environment, mode) = condition(derived.known, case)?;
    if printed && !is_as_in_the_thesis(environment, mode) {
        let why = "the number is of the thesis' own spring and voltages, and these are others";
        return not_measured(why);
    }
    match test {
        Test::Mean(quantity, bound) => {
            let estimated = mean(&people(derived, case, quantity)?, derived.level);
            in_range(quantity, estimated, bound, environment, derived)
        }
        Test::Difference(quantity, other, bound) => {
            let own = people(derived, case, quantity)?;
            let less = people(derived, other, quantity)?;
            let estimated = difference(&own, &less, derived.level);
            let judged = in_range(quantity, estimated, bound, environment, derived)?;
            let (other_environment, other_mode) = condition(derived.known, other)?;
            // By mode, or by environment where the mode is one.
            let [own, less] = if mode.id == other_mode.id {
                [&environment.label, &other_environment.label]
            } else {
                [&mode.label, &other_mode.label]
            };
            let pair = format!(", {} − {}", in_a_sentence(own), in_a_sentence(less));
            Ok(JudgedStatement { metric: judged.metric.map(|words| words + &pair), ..judged })
        }
        Test::Every(words, column, word) => {
            let trials = trials(derived, case, From::Metrics)?;
            let (some, all) = trials.count(column, word)?;
            if all == 0 {
                return not_measured(format!("no trial has a value: {words}"));
            }
            Ok(JudgedStatement {
                verdict: Verdict::of(some == all),
                ..counted(words, [some, all], "all trials", &trials, derived)
            })
        }
        Test::Never(quantity) => {
            let trials = trials(derived, case, quantity.from)?;
            let all = trials.floats(STIFFNESS)?.len();
            if all == 0 {
                return not_measured("no trial has a line of force on angle");
            }
            let some = trials.floats(quantity.column)?.len();
            let words = format!("trials with a {}", quantity.words);
            Ok(JudgedStatement {
                verdict: Verdict::of(some == 0),
                ..counted(&words, [some, all], "no trial", &trials, derived)
            })
        }
        Test::Some(quantity, above) => some(quantity, above, case, derived),
        Test::Superior(over) => superior(case, over, derived),
        Test::Median { favourable } => median_of(case, favourable, derived),
    }
}

/// A mean against a range.
fn in_range(
    quantity: Quantity,
    estimated: Option<Estimated>,
    bound: Bound,
    environment: &Environment,
    derived: &Derived,
) -> Result<JudgedStatement, Stop> {
    let Some(estimated) = estimated else {
        return not_measured(format!("no trial has a value: {}", quantity.words));
    };
    let coordinate = derived.known.study.coordinate;
    if quantity.unit == "rad" && coordinate != Coordinate::Rotational {
        return not_measured("it is of an angle, and this study's are lengths");
    }
    let Some(range) = bound.range(environment) else {
        return not_measured("the environment sets no bound");
    };
    let shown = match quantity.from {
        From::Metrics => Shown::Modes(environment.id.clone()),
        From::Replays => Shown::Replays(environment.id.clone()),
    };
    Ok(JudgedStatement {
        shown: Some(derived.gallery.file(&shown)),
        ..judged(quantity, &estimated, &range, coordinate)
    })
}

/// Some of all trials.
fn counted(
    metric: &str,
    [some, all]: [usize; 2],
    required: &str,
    trials: &Trials,
    derived: &Derived,
) -> JudgedStatement {
    JudgedStatement {
        metric: Some(metric.to_owned()),
        value: Some(100.0 * some as f64 / all as f64),
        unit: Some("%".to_owned()),
        n: Some(all),
        unit_of_analysis: Some(trials.whose()),
        asked: Some(required.into()),
        shown: Some(derived.gallery.file(&Shown::Metrics)),
        remark: Some(format!("{some} of {all} trials").into()),
        ..unjudged()
    }
}

/// Whether any trial has more. None among a few does not say that it never happens: that is
/// undecided. With one participant the share has its exact interval (Clopper & Pearson 1934).
fn some(
    quantity: Quantity,
    above: f64,
    case: Case,
    derived: &Derived,
) -> Result<JudgedStatement, Stop> {
    let trials = trials(derived, case, quantity.from)?;
    let people = trials.people(quantity.column, quantity.less)?;
    let values: Vec<f64> = people.values().flat_map(BTreeMap::values).flatten().copied().collect();
    let some = values.iter().filter(|value| **value > above).count();
    let all = values.len();
    if all == 0 {
        return not_measured(format!("no trial has a value: {}", quantity.words));
    }
    let judged = counted(quantity.words, [some, all], "at least one trial", &trials, derived);
    // The interval supposes independent trials, which those of several people are not.
    let share = clopper_pearson(some, all, derived.level).ok().filter(|_| people.len() == 1);
    let shown = match quantity.from {
        From::Metrics => judged.shown,
        From::Replays => {
            let (environment, _) = condition(derived.known, case)?;
            Some(derived.gallery.file(&Shown::Replays(environment.id.clone())))
        }
    };
    Ok(JudgedStatement {
        verdict: if some > 0 { Verdict::Supported } else { Verdict::Undecided },
        ci_low: share.map(|(low, _)| 100.0 * low),
        ci_high: share.map(|(_, high)| 100.0 * high),
        shown,
        ..judged
    })
}

/// P(A > B) + ½ P(A = B) of the answers in two modes.
fn superior((law, place): Case, over: ModeLaw, derived: &Derived) -> Result<JudgedStatement, Stop> {
    let (environment, a) = condition(derived.known, (law, place))?;
    let (_, b) = condition(derived.known, (over, place))?;
    let none = || Stop::NotMeasured("nobody answered in both modes".to_owned());
    let answers = derived.answers.ok_or_else(none)?;
    let study = derived.known.study;
    let [of_a, of_b] = [a, b].map(|mode| scored(study, answers, environment, mode));
    let both: Vec<(&ParticipantId, Repeats<AnswerValue>)> =
        of_a.iter().filter_map(|(who, a)| Some((*who, Repeats { a, b: of_b.get(who)? }))).collect();
    let (who, first) = *both.first().ok_or_else(none)?;
    let repeats: Vec<Repeats<AnswerValue>> = both.iter().map(|(_, repeats)| *repeats).collect();
    let superiority = superiority(&repeats, derived.level).map_err(|_| none())?;
    let pairs: usize = repeats.iter().map(|person| person.a.len() * person.b.len()).sum();
    let (interval, why) = match superiority.interval {
        Ok((low, high)) => (Some([low, high]), String::new()),
        Err(_) if repeats.len() == 1 => (None, ", no interval: one participant".to_owned()),
        Err(why) => (None, format!(", no interval: {why}")),
    };
    let (n, over) = match repeats.len() {
        1 => (first.a.len() + first.b.len(), format!("answers of {who}")),
        n => (n, "participants".to_owned()),
    };
    let words = "share of pairs with the higher answer (ties half)";
    let modes = format!("{} over {}", in_a_sentence(&a.label), in_a_sentence(&b.label));
    let required = match interval {
        Some(_) => "above 0.5: higher more often than lower",
        None => "above 0.56: a small effect (Vargha & Delaney 2000)",
    };
    Ok(JudgedStatement {
        verdict: of_superiority(superiority.probability, interval),
        metric: Some(format!("{words}, {modes}")),
        value: Some(superiority.probability),
        ci_low: interval.map(|ends| ends[0]),
        ci_high: interval.map(|ends| ends[1]),
        unit: Some("1".to_owned()),
        n: Some(n),
        unit_of_analysis: Some(over),
        asked: Some(required.into()),
        shown: Some(derived.gallery.file(&Shown::Answers)),
        remark: Some(format!("{pairs} pairs{why}").into()),
        ..unjudged()
    })
}

fn of_superiority(probability: f64, interval: Option<[f64; 2]>) -> Verdict {
    match interval {
        Some([low, _]) if low > 0.5 => Verdict::Supported,
        Some([_, high]) if high < 0.5 => Verdict::Contradicted,
        None if probability > SMALL_EFFECT => Verdict::Supported,
        None if probability < 1.0 - SMALL_EFFECT => Verdict::Contradicted,
        _ => Verdict::Undecided,
    }
}

/// The median answer against the middle of its scale.
fn median_of(case: Case, favourable: bool, derived: &Derived) -> Result<JudgedStatement, Stop> {
    let (environment, mode) = condition(derived.known, case)?;
    let question = question_of(derived.known.study, environment);
    let median = derived
        .tally
        .zip(question)
        .and_then(|(tally, question)| median(tally, environment, mode, question));
    let Some(median) = median else { return not_measured("nobody answered") };
    let twice_the_middle = f64::from(median.scale.ends_together());
    // The two middle answers may lie on either side of the middle.
    let [low, high] = [median.low, median.high].map(|answer| 2.0 * answer.get() > twice_the_middle);
    let verdict = if low == high { Verdict::of(low == favourable) } else { Verdict::Undecided };
    let side = if favourable { "above" } else { "not above" };
    let people = match median.participants {
        1 => "answers of one participant".to_owned(),
        people => format!("answers of {people} participants"),
    };
    Ok(JudgedStatement {
        verdict,
        metric: Some("median answer".to_owned()),
        value: (median.low == median.high).then_some(median.low.get()),
        unit: Some("1".to_owned()),
        n: Some(median.answers),
        unit_of_analysis: Some(people),
        asked: Some(format!("{side} the middle of the scale").into()),
        shown: Some(derived.gallery.file(&Shown::Answers)),
        remark: Some(format!("{}; no interval", median.words()).into()),
        ..unjudged()
    })
}

/// Several statements together: one that is contradicted contradicts them, and else one that is
/// open leaves them open. The remark has the decisive ones in their own words.
fn all_of(parts: &[&str], before: &BTreeMap<&str, Verdict>) -> Result<JudgedStatement, Stop> {
    let verdicts: Vec<Verdict> = parts
        .iter()
        .map(|part| before.get(part).copied().unwrap_or(Verdict::NotMeasured))
        .collect();
    // The strongest objection first.
    let verdict = [Verdict::Contradicted, Verdict::NotMeasured, Verdict::Undecided]
        .into_iter()
        .find(|objection| verdicts.contains(objection))
        .unwrap_or(Verdict::Supported);
    let decisive = parts.iter().zip(&verdicts).filter(|(_, part)| **part == verdict);
    let list = decisive.map(|(key, _)| {
        let statement = statements::ALL.iter().find(|statement| statement.key == *key);
        statement.map_or_else(|| (*key).to_owned(), |statement| format!("“{}”", statement.text))
    });
    let list: Vec<String> = list.collect();
    let all = parts.len();
    let some = list.len();
    let word = verdict.as_str();
    let remark = match verdict {
        Verdict::Supported => format!("it rests on {all} other statements, all of them supported"),
        _ => format!(
            "it rests on {all} other statements, {some} of them {word}: {}",
            list.join(", ")
        ),
    };
    if verdict == Verdict::NotMeasured {
        return not_measured(remark);
    }
    Ok(JudgedStatement {
        verdict,
        metric: Some("the statements it rests on".to_owned()),
        asked: Some("all of them supported".into()),
        remark: Some(remark.into()),
        ..unjudged()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_without_an_interval_differ_from_a_small_effect_on() {
        assert_eq!(of_superiority(0.57, None), Verdict::Supported);
        assert_eq!(of_superiority(0.55, None), Verdict::Undecided);
        assert_eq!(of_superiority(0.43, None), Verdict::Contradicted);
        assert_eq!(of_superiority(0.6, Some([0.49, 0.7])), Verdict::Undecided);
        assert_eq!(of_superiority(0.6, Some([0.51, 0.7])), Verdict::Supported);
        assert_eq!(of_superiority(0.4, Some([0.3, 0.49])), Verdict::Contradicted);
    }

    #[test]
    fn statements_together_are_as_good_as_their_worst() {
        let of = |verdicts: [Verdict; 2]| match all_of(
            &["a", "b"],
            &["a", "b"].into_iter().zip(verdicts).collect(),
        ) {
            Ok(judged) => judged.verdict,
            Err(_) => Verdict::NotMeasured,
        };
        use Verdict::{Contradicted, NotMeasured, Supported, Undecided};
        assert_eq!(of([Supported, Supported]), Supported);
        assert_eq!(of([Supported, Undecided]), Undecided);
        assert_eq!(of([NotMeasured, Undecided]), NotMeasured);
        assert_eq!(of([NotMeasured, Contradicted]), Contradicted);
    }
}
