//! What a study's tables say about a statement.

use crate::answers::{median, scored};
use crate::columns::STIFFNESS;
use crate::evidence::{Evidence, Verdict};
use crate::gallery::Shown;
use crate::thesis::estimate::{Estimated, difference, mean};
use crate::thesis::forces;
use crate::thesis::judged::{Derived, Judged, Stop, condition, counted, judged, people, trials};
use crate::thesis::rule::{Bound, Case, From, Quantity, Rule, Statement, is_as_in_the_thesis};
use crate::thesis::statements;
use std::collections::BTreeMap;
use zwidth_stats::power::clopper_pearson;
use zwidth_stats::superiority::{Repeats, superiority};
use zwidth_study::{
    AnswerValue, Coordinate, Environment, Mode, ModeLaw, ParticipantId, in_a_sentence,
};
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
) -> Result<Judged, TableError> {
    match apply(statement, before, derived) {
        Ok(judged) => Ok(judged),
        Err(Stop::Table(error)) => Err(error),
        Err(Stop::NotMeasured(why)) => Ok(Judged {
            evidence: Evidence {
                metric: String::new(),
                value: None,
                unit: String::new(),
                remark: why,
                verdict: Verdict::NotMeasured,
            },
            required: String::new(),
            interval: None,
            n: None,
            over: String::new(),
            shown: Shown::Statements,
        }),
    }
}

fn apply(
    statement: &Statement,
    before: &BTreeMap<&str, Verdict>,
    derived: &Derived,
) -> Result<Judged, Stop> {
    match (statement.rule, statement.case) {
        (Rule::All(parts), _) => all_of(parts, before),
        (Rule::Untold(why), _) => Err(Stop::NotMeasured(why.to_owned())),
        (Rule::Forces(force), _) => forces::judge(force, derived),
        (_, None) => Err(Stop::NotMeasured("no mode and environment are named".to_owned())),
        (rule, Some(case)) => judge_case(rule, case, statement.printed, derived),
    }
}

/// A rule of one condition.
fn judge_case(rule: Rule, case: Case, printed: bool, derived: &Derived) -> Result<Judged, Stop> {
    let (environment, mode) = condition(derived.known, case)?;
    if printed && !is_as_in_the_thesis(environment, mode) {
        let why = "the number is of the thesis' own spring and voltages, and these are others";
        return Err(Stop::NotMeasured(why.to_owned()));
    }
    match rule {
        Rule::Mean(quantity, bound) => {
            let estimated = mean(&people(derived, case, quantity)?, derived.level);
            in_range(quantity, estimated, bound, environment, derived)
        }
        Rule::Difference(quantity, other, bound) => {
            let own = people(derived, case, quantity)?;
            let less = people(derived, other, quantity)?;
            let estimated = difference(&own, &less, derived.level);
            let judged = in_range(quantity, estimated, bound, environment, derived)?;
            let less = condition(derived.known, other)?;
            Ok(less_another(judged, (environment, mode), less))
        }
        Rule::Every(words, column, word) => every(words, column, word, case, derived),
        Rule::Never(quantity) => never(quantity, case, derived),
        Rule::Some(quantity, above) => some(quantity, above, case, derived),
        Rule::Superior(over) => superior(case, over, derived),
        Rule::Median { favourable } => median_of(case, favourable, derived),
        Rule::All(_) | Rule::Untold(_) | Rule::Forces(_) => {
            Err(Stop::NotMeasured("it is of no single condition".to_owned()))
        }
    }
}

/// A mean against a range.
fn in_range(
    quantity: Quantity,
    estimated: Option<Estimated>,
    bound: Bound,
    environment: &Environment,
    derived: &Derived,
) -> Result<Judged, Stop> {
    let estimated = estimated
        .ok_or_else(|| Stop::NotMeasured(format!("no trial has a value: {}", quantity.words)))?;
    let coordinate = derived.known.study.coordinate;
    if quantity.unit == "rad" && coordinate != Coordinate::Rotational {
        let why = "it is of an angle, and this study's are lengths";
        return Err(Stop::NotMeasured(why.to_owned()));
    }
    let range = bound
        .range(environment)
        .ok_or_else(|| Stop::NotMeasured("the environment sets no bound".to_owned()))?;
    let shown = match quantity.from {
        From::Metrics => Shown::Modes(environment.id.clone()),
        From::Replays => Shown::Replays(environment.id.clone()),
    };
    Ok(judged(quantity, &estimated, &range, coordinate, shown))
}

/// The same, worded as a difference: by mode, or by environment where the mode is one.
fn less_another(
    judged: Judged,
    (environment, mode): (&Environment, &Mode),
    (other_environment, other_mode): (&Environment, &Mode),
) -> Judged {
    let [own, less] = if mode.id == other_mode.id {
        [&environment.label, &other_environment.label]
    } else {
        [&mode.label, &other_mode.label]
    };
    let pair = format!("{} − {}", in_a_sentence(own), in_a_sentence(less));
    let metric = format!("{}, {pair}", judged.evidence.metric);
    Judged { evidence: Evidence { metric, ..judged.evidence }, ..judged }
}

fn every(
    words: &str,
    column: &str,
    word: &str,
    case: Case,
    derived: &Derived,
) -> Result<Judged, Stop> {
    let trials = trials(derived, case, From::Metrics)?;
    let (some, all) = trials.count(column, word)?;
    if all == 0 {
        return Err(Stop::NotMeasured(format!("no trial has a value: {words}")));
    }
    counted(words, some, all, Verdict::of(some == all), "all trials", &trials)
}

fn never(quantity: Quantity, case: Case, derived: &Derived) -> Result<Judged, Stop> {
    let trials = trials(derived, case, quantity.from)?;
    let all = trials.floats(STIFFNESS)?.len();
    if all == 0 {
        return Err(Stop::NotMeasured("no trial has a line of force on angle".to_owned()));
    }
    let some = trials.floats(quantity.column)?.len();
    let words = format!("trials with a {}", quantity.words);
    counted(&words, some, all, Verdict::of(some == 0), "no trial", &trials)
}

/// Whether any trial has more. None among a few does not say that it never happens: that is
/// undecided. With one participant the share has its exact interval (Clopper & Pearson 1934).
fn some(quantity: Quantity, above: f64, case: Case, derived: &Derived) -> Result<Judged, Stop> {
    let trials = trials(derived, case, quantity.from)?;
    let people = trials.people(quantity.column, quantity.less)?;
    let values: Vec<f64> = people.values().flat_map(BTreeMap::values).flatten().copied().collect();
    let some = values.iter().filter(|value| **value > above).count();
    let all = values.len();
    if all == 0 {
        return Err(Stop::NotMeasured(format!("no trial has a value: {}", quantity.words)));
    }
    let verdict = if some > 0 { Verdict::Supported } else { Verdict::Undecided };
    let judged = counted(quantity.words, some, all, verdict, "at least one trial", &trials)?;
    // The interval supposes independent trials, which those of several people are not.
    let share = clopper_pearson(some, all, derived.level).ok().filter(|_| people.len() == 1);
    let shown = match quantity.from {
        From::Metrics => judged.shown,
        From::Replays => Shown::Replays(condition(derived.known, case)?.0.id.clone()),
    };
    let interval = share.map(|(low, high)| [100.0 * low, 100.0 * high]);
    Ok(Judged { interval, shown, ..judged })
}

/// P(A > B) + ½ P(A = B) of the answers in two modes.
fn superior((law, place): Case, over: ModeLaw, derived: &Derived) -> Result<Judged, Stop> {
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
    Ok(Judged {
        evidence: Evidence {
            metric: format!("{words}, {modes}"),
            value: Some(superiority.probability),
            unit: "1".to_owned(),
            remark: format!("{pairs} pairs{why}"),
            verdict: of_superiority(superiority.probability, interval),
        },
        required: required.to_owned(),
        interval,
        n: Some(n),
        over,
        shown: Shown::Answers,
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
fn median_of(case: Case, favourable: bool, derived: &Derived) -> Result<Judged, Stop> {
    let (environment, mode) = condition(derived.known, case)?;
    let none = || Stop::NotMeasured("nobody answered".to_owned());
    let tally = derived.tally.ok_or_else(none)?;
    let median = median(derived.known.study, tally, environment, mode).ok_or_else(none)?;
    let twice_the_middle = f64::from(median.scale.ends_together());
    // The two middle answers may lie on either side of the middle.
    let [low, high] = [median.low, median.high].map(|answer| 2.0 * answer.get() > twice_the_middle);
    let verdict = if low == high { Verdict::of(low == favourable) } else { Verdict::Undecided };
    let side = if favourable { "above" } else { "not above" };
    let people = match median.participants {
        1 => "answers of one participant".to_owned(),
        people => format!("answers of {people} participants"),
    };
    Ok(Judged {
        evidence: Evidence {
            metric: "median answer".to_owned(),
            value: (median.low == median.high).then_some(median.low.get()),
            unit: "1".to_owned(),
            remark: format!("{}; no interval", median.words()),
            verdict,
        },
        required: format!("{side} the middle of the scale"),
        interval: None,
        n: Some(median.answers),
        over: people,
        shown: Shown::Answers,
    })
}

/// Several statements together: one that is contradicted contradicts them, and else one that is
/// open leaves them open.
fn all_of(parts: &[&str], before: &BTreeMap<&str, Verdict>) -> Result<Judged, Stop> {
    let verdicts =
        parts.iter().map(|part| (*part, before.get(part).copied().unwrap_or(Verdict::NotMeasured)));
    let verdicts: Vec<(&str, Verdict)> = verdicts.collect();
    // The strongest objection first.
    let verdict = [Verdict::Contradicted, Verdict::NotMeasured, Verdict::Undecided]
        .into_iter()
        .find(|objection| verdicts.iter().any(|(_, verdict)| verdict == objection))
        .unwrap_or(Verdict::Supported);
    let remark = rests_on(&verdicts, verdict);
    if verdict == Verdict::NotMeasured {
        return Err(Stop::NotMeasured(remark));
    }
    Ok(Judged {
        evidence: Evidence {
            metric: "the statements it rests on".to_owned(),
            value: None,
            unit: String::new(),
            remark,
            verdict,
        },
        required: "all of them supported".to_owned(),
        interval: None,
        n: None,
        over: String::new(),
        shown: Shown::Statements,
    })
}

/// The statements of others that another one has its verdict from, in their own words.
fn rests_on(parts: &[(&str, Verdict)], verdict: Verdict) -> String {
    let all = parts.len();
    if verdict == Verdict::Supported {
        return format!("it rests on {all} other statements, all of them supported");
    }
    let decisive = parts.iter().filter(|(_, part)| *part == verdict).map(|(key, _)| {
        let statement = statements::ALL.iter().find(|statement| statement.key == *key);
        statement.map_or_else(|| (*key).to_owned(), |statement| format!("“{}”", statement.text))
    });
    let list: Vec<String> = decisive.collect();
    let word = verdict.as_str();
    let some = list.len();
    format!("it rests on {all} other statements, {some} of them {word}: {}", list.join(", "))
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
            Ok(judged) => judged.evidence.verdict,
            Err(_) => Verdict::NotMeasured,
        };
        use Verdict::{Contradicted, NotMeasured, Supported, Undecided};
        assert_eq!(of([Supported, Supported]), Supported);
        assert_eq!(of([Supported, Undecided]), Undecided);
        assert_eq!(of([NotMeasured, Undecided]), NotMeasured);
        assert_eq!(of([NotMeasured, Contradicted]), Contradicted);
    }
}
