//! How many trials a procedure takes until its estimate is within 10 % of a simulated person's truth, beside PsychoPy's
//! handlers on the same people.

use crate::ask;
use crate::people::{FIRST_TRIAL, detecting, uniform};
use anyhow::Context as _;
use std::time::Instant;
use zwidth_numerics::order::upper_median;
use zwidth_stats::psychometric::fit::{LAPSE, Model, fit};
use zwidth_stats::psychometric::quest::{self, Quest};
use zwidth_stats::psychometric::staircase::{self, Scale, Staircase};
use zwidth_stats::psychometric::{Asks, Curve, LevelAnswers, Sigmoid};

/// People, and the most trials of each.
const PEOPLE: u64 = 60;
const TRIALS: usize = 240;
/// An estimate is looked at after so many trials, and every so many more.
const EVERY: usize = 10;
const CONFIDENCE: f64 = 0.95;
/// Within this of the truth.
const WITHIN: f64 = 0.1;
/// Reversals of which a staircase's estimate is the mean, all but these first ones, as PsychoPy's guide advises.
const FIRST_REVERSALS: usize = 2;
/// Equal steps between levels, in ln, of constant stimuli and of QUEST+; from 0.02 to 0.32 N.
const STEP: f64 = 0.115_129_254_649_702_28; // a twentieth of a decade

/// A procedure: the estimates of one person after 10, 20, … trials, each with its truth; an estimate that is not there
/// yet is none.
type Procedure = fn(&Person) -> anyhow::Result<Vec<Option<f64>>>;

/// A person, whose answers follow from the level and the trial.
struct Person {
    number: u64,
    curve: Curve,
}

impl Person {
    fn is_right(&self, trial: usize, level: f64) -> bool {
        uniform(self.number, FIRST_TRIAL + trial as u64) < self.curve.share(level)
    }

    /// The level at which a share of answers is right.
    fn level_at(&self, share: f64) -> f64 {
        let below = (share - 0.5) / (0.5 - self.curve.lapse);
        libm::exp(self.curve.location + libm::log(-libm::log1p(-below)) * self.curve.scale)
    }

    /// The level at F = ½.
    fn threshold(&self) -> f64 {
        self.curve.threshold()
    }
}

fn levels() -> Vec<f64> {
    // From 0.02 on, 1.2 decades, in millionths as records hold them.
    (0..=24).map(|place| (0.02 * libm::exp(STEP * f64::from(place)) * 1e6).round() / 1e6).collect()
}

fn error_of(estimate: Option<f64>, truth: f64) -> Option<f64> {
    estimate.map(|estimate| (estimate / truth - 1.0).abs())
}

/// Constant stimuli at seven levels, a fifth of a decade apart, fitted by maximum likelihood.
fn constant(person: &Person) -> anyhow::Result<Vec<Option<f64>>> {
    let shown: Vec<f64> = levels().into_iter().skip(2).step_by(3).take(7).collect();
    let mut answers: Vec<LevelAnswers> =
        shown.iter().map(|level| LevelAnswers { level: *level, trials: 0, positive: 0 }).collect();
    let model = Model {
        asks: Asks::RightOrWrong,
        sigmoid: Sigmoid::Weibull,
        lapse: LAPSE,
        is_constant: true,
    };
    let mut found = Vec::new();
    for trial in 0..TRIALS {
        let own = &mut answers[trial % shown.len()];
        own.trials += 1;
        own.positive += u64::from(person.is_right(trial, own.level));
        if (trial + 1) % EVERY == 0 {
            let fitted = fit(&answers, &model, CONFIDENCE)?.fitted;
            found.push(error_of(fitted.map(|f| f.threshold.estimate), person.threshold()));
        }
    }
    Ok(found)
}

fn of_staircase(person: &Person, plan: &Staircase, share: f64) -> anyhow::Result<Vec<Option<f64>>> {
    let (mut answers, mut found) = (Vec::new(), Vec::new());
    let mut track = staircase::track(plan, &answers)?;
    for trial in 0..TRIALS {
        let level = track.next.context("a staircase ended")?;
        answers.push(person.is_right(trial, level));
        track = staircase::track(plan, &answers)?;
        if (trial + 1) % EVERY == 0 {
            let later = track.reversals.get(FIRST_REVERSALS..).unwrap_or_default();
            let sum: f64 = later.iter().map(|level| libm::log(*level)).sum();
            let estimate = (later.len() > 1).then(|| libm::exp(sum / later.len() as f64));
            found.push(error_of(estimate, person.level_at(share)));
        }
    }
    Ok(found)
}

fn plan(down_after: usize, down_over_up: f64) -> Staircase {
    let up = libm::log(1.25);
    Staircase {
        up_after: 1,
        down_after,
        scale: Scale::Logarithmic,
        up,
        down: up * down_over_up,
        start: 0.24,
        bounds: [0.005, 0.5],
        reversals: TRIALS,
        most_trials: TRIALS + 1,
        of_last: TRIALS,
    }
}

fn two_down(person: &Person) -> anyhow::Result<Vec<Option<f64>>> {
    let ratio = staircase::DOWN_OVER_UP[1];
    of_staircase(person, &plan(2, ratio), staircase::target(1, 2, ratio)?)
}

fn three_down(person: &Person) -> anyhow::Result<Vec<Option<f64>>> {
    let ratio = staircase::DOWN_OVER_UP[2];
    of_staircase(person, &plan(3, ratio), staircase::target(1, 3, ratio)?)
}

fn weighted(person: &Person) -> anyhow::Result<Vec<Option<f64>>> {
    of_staircase(person, &plan(1, staircase::weighted(0.75)?), 0.75)
}

/// Thresholds at all levels, slopes β of 1 to 5, λ of 2 %.
fn quest_plan() -> quest::Plan {
    quest::Plan {
        asks: Asks::RightOrWrong,
        sigmoid: Sigmoid::Weibull,
        levels: levels(),
        thresholds: levels(),
        scales: [5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.0].map(f64::recip).to_vec(),
        lapses: vec![0.02],
    }
}

fn quest_plus(person: &Person) -> anyhow::Result<Vec<Option<f64>>> {
    let mut quest = Quest::new(&quest_plan())?;
    let mut found = Vec::new();
    for trial in 0..TRIALS {
        step(&mut quest, person, trial)?;
        if (trial + 1) % EVERY == 0 {
            found.push(error_of(Some(quest.track().threshold), person.threshold()));
        }
    }
    Ok(found)
}

/// An answer, and the level that follows from it.
fn step(quest: &mut Quest, person: &Person, trial: usize) -> anyhow::Result<f64> {
    let level = quest.next_level();
    let place = quest.place_of(level).context("a level beside the grid")?;
    quest.answer(place, person.is_right(trial, level))?;
    Ok(quest.next_level())
}

pub(crate) fn measure(peer: [&str; 2]) -> anyhow::Result<()> {
    let procedures: [(&str, Procedure); 5] = [
        ("zwidth: constant stimuli, 7 levels, maximum likelihood", constant),
        ("zwidth: 1 up 2 down, steps by García-Pérez", two_down),
        ("zwidth: 1 up 3 down, steps by García-Pérez", three_down),
        ("zwidth: weighted, 75 %", weighted),
        ("zwidth: QUEST+", quest_plus),
    ];
    let mut lines: Vec<(String, Vec<Vec<Option<f64>>>)> = Vec::new();
    for (name, procedure) in procedures {
        let people =
            (0..PEOPLE).map(|number| procedure(&Person { number, curve: detecting(number) }));
        lines.push((name.to_owned(), people.collect::<anyhow::Result<_>>()?));
    }
    let (people, trials, every) = (PEOPLE.to_string(), TRIALS.to_string(), EVERY.to_string());
    for line in ask(peer, &["trials", &people, &trials, &every])? {
        let (name, errors) = line.split_first().context("a name")?;
        let errors = errors.iter().map(|error| error.parse().ok()).collect();
        match lines.iter_mut().find(|(known, _)| known == name) {
            Some((_, all)) => all.push(errors),
            None => lines.push((name.clone(), vec![errors])),
        }
    }
    println!(
        "| procedure | trials until the median error is at most 10 %, and stays | median error after 40 | 80 | 160 | 240 |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (name, people) in &lines {
        let at = |place: usize| {
            // Who has no estimate yet is as far off as can be.
            let errors = people.iter().map(|own| own[place].unwrap_or(f64::INFINITY));
            upper_median(errors).unwrap_or(f64::INFINITY)
        };
        let medians: Vec<f64> = (0..TRIALS / EVERY).map(at).collect();
        let last_beyond = medians.iter().rposition(|error| *error > WITHIN);
        let within = match last_beyond {
            None => EVERY.to_string(),
            Some(place) if place + 1 == medians.len() => format!("more than {TRIALS}"),
            Some(place) => ((place + 2) * EVERY).to_string(),
        };
        let shown = [40, 80, 160, 240].map(|trials| match medians[trials / EVERY - 1] {
            error if error.is_finite() => format!("{:.1} %", 100.0 * error),
            _ => "none yet".to_owned(),
        });
        println!("| {name} | {within} | {} |", shown.join(" | "));
    }
    steps()
}

/// The time of a step of QUEST+, from an answer to the next level, on the grid above and on finer ones.
fn steps() -> anyhow::Result<()> {
    let person = Person { number: 0, curve: detecting(0) };
    let scales =
        |number: usize| (0..number).map(move |place| 0.2 + 0.8 * place as f64 / number as f64);
    println!("\n| levels × curves | a step of QUEST+ in the middle | 95 of 100 | at most |");
    println!("| --- | --- | --- | --- |");
    for (number, lapses) in [
        (7, vec![0.02]),
        (15, vec![0.0, 0.02, 0.04, 0.06]),
        (80, vec![0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09]),
    ] {
        let plan = quest::Plan { scales: scales(number).collect(), lapses, ..quest_plan() };
        let mut quest = Quest::new(&plan)?;
        let mut all = Vec::new();
        for trial in 0..TRIALS {
            let began = Instant::now();
            std::hint::black_box(step(&mut quest, &person, trial)?);
            all.push(1e3 * began.elapsed().as_secs_f64());
        }
        all.sort_by(f64::total_cmp);
        println!(
            "| {} × {} | {:.3} ms | {:.3} ms | {:.3} ms |",
            plan.levels.len(),
            plan.thresholds.len() * plan.scales.len() * plan.lapses.len(),
            all[all.len() / 2],
            all[all.len() * 95 / 100],
            all[all.len() - 1]
        );
    }
    Ok(())
}
