//! How often intervals hold the truth where levels follow from the answers, or where people set them.

use crate::drawn::normal;
use crate::judged::{Asked, Judged, LEVEL, Said, judge};
use crate::thresholds::{JND, MIDDLE, Person, STEP, covered};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use zwidth_stats::interval;
use zwidth_stats::psychometric::adjustment::{self, Wish, Wished};
use zwidth_stats::psychometric::quest::{self, Quest};
use zwidth_stats::psychometric::staircase::{self, Scale, Staircase};
use zwidth_stats::psychometric::{Asks, Curve, Sigmoid};

/// Staircases of a person that take turns: their spread gives the interval of their mean.
const STAIRCASES: usize = 4;
/// The share of guesses of who has to say which of two it was.
const GUESS: f64 = 0.5;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Procedure {
    /// One up and two down, of who says which of two it was; each ends after so many reversals.
    Staircases { reversals: usize },
    /// QUEST+ of so many trials, of who says which was more.
    QuestPlus { trials: usize },
    /// So many settings, by steps of half a JND.
    Settings { settings: usize },
}

/// People with the same curve, but for their threshold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    procedure: Procedure,
    lapse: f64,
    /// η, as of constant stimuli.
    scatter: f64,
}

pub(crate) fn kinds() -> Vec<Kind> {
    let answers = [(0.0, 0.0), (0.02, 0.0), (0.05, 0.0), (0.02, 0.1), (0.02, 0.2), (0.02, 0.3)];
    let staircases = [4, 8, 16, 40].map(|reversals| Procedure::Staircases { reversals });
    let quests = [40, 80, 160, 400].map(|trials| Procedure::QuestPlus { trials });
    let answered = [staircases, quests]
        .concat()
        .into_iter()
        .flat_map(|procedure| answers.map(|(lapse, scatter)| Kind { procedure, lapse, scatter }));
    let settings = [5, 10, 20, 40].map(|settings| Procedure::Settings { settings });
    let set = settings.map(|procedure| Kind { procedure, lapse: 0.0, scatter: 0.0 });
    answered.chain(set).collect()
}

impl Kind {
    pub(crate) fn name(&self) -> String {
        let Self { procedure, lapse, scatter } = self;
        match procedure {
            Procedure::Staircases { reversals } => {
                format!(
                    "{STAIRCASES} staircases of {reversals} reversals, λ = {lapse}, η = {scatter}"
                )
            }
            Procedure::QuestPlus { trials } => {
                format!("QUEST+ of {trials} trials, λ = {lapse}, η = {scatter}")
            }
            Procedure::Settings { settings } => format!("{settings} settings"),
        }
    }
}

/// Intervals of the PSE or threshold, and of the JND. What few answers cannot show, or answers that scatter far, is shown
/// and not promised.
pub(crate) fn tests(kind: Kind, studies: usize) -> Vec<Judged> {
    let coverage = match kind.procedure {
        // A first step from far off is still in the mean of few reversals.
        Procedure::Staircases { reversals } => (reversals >= 8).then_some([0.9, 0.98]),
        // Too wide, and not better, of people who never lapse: λ has a prior up to 0.06.
        Procedure::QuestPlus { trials } => (trials >= 80).then_some([0.92, 0.995]),
        Procedure::Settings { .. } => Some([0.93, 0.98]),
    };
    let asked = match coverage.filter(|_| kind.scatter < 0.15) {
        Some(coverage) => Asked::Approximate { most: 1.0, coverage },
        None => Asked::Nothing,
    };
    let tests = [("PSE or threshold", asked), ("JND", asked)];
    judge(studies, tests, |study| {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        match kind.procedure {
            Procedure::Staircases { reversals } => staircases(kind, reversals, &mut rng),
            Procedure::QuestPlus { trials } => quest_plus(kind, trials, &mut rng),
            Procedure::Settings { settings } => settings_of(settings, &mut rng),
        }
    })
}

fn staircases(kind: Kind, reversals: usize, rng: &mut ChaCha8Rng) -> [Said; 2] {
    let mut person = Person::new(GUESS, kind.lapse, kind.scatter, rng);
    let down_over_up = staircase::DOWN_OVER_UP[1];
    let plan = Staircase {
        up_after: 1,
        down_after: 2,
        scale: Scale::Linear,
        up: STEP,
        down: (down_over_up * STEP).round(),
        start: MIDDLE + 4.0 * STEP,
        bounds: [0.0, 2.0 * MIDDLE],
        reversals,
        most_trials: 1000,
        of_last: reversals / 4 * 3,
    };
    let target = staircase::target(1, 2, plan.down / plan.up).unwrap();
    let truth = level_at(&person.curve, target);
    let thresholds = (0..STAIRCASES).map(|_| {
        let mut answers = Vec::new();
        loop {
            let track = staircase::track(&plan, &answers).unwrap();
            let Some(level) = track.next else { return track.threshold.unwrap() };
            answers.push(person.says(level, rng));
        }
    });
    let thresholds: Vec<f64> = thresholds.collect();
    let interval = interval::mean(&thresholds, LEVEL).unwrap().interval.unwrap();
    let [low, high] = [interval.ci_low, interval.ci_high];
    [covered(Some([Some(low), Some(high)]), truth), Said::default()]
}

/// The level at which the curve has a share, by halving.
fn level_at(curve: &Curve, share: f64) -> f64 {
    let [mut low, mut high] = [0.0, 2.0 * MIDDLE];
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if curve.share(middle) < share { low = middle } else { high = middle }
    }
    low
}

fn quest_plus(kind: Kind, trials: usize, rng: &mut ChaCha8Rng) -> [Said; 2] {
    let mut person = Person::new(kind.lapse, kind.lapse, kind.scatter, rng);
    let along = |from: f64, step: f64, places: usize| -> Vec<f64> {
        (0..places).map(|place| from + step * place as f64).collect()
    };
    let plan = quest::Plan {
        asks: Asks::WhichWasMore,
        sigmoid: Sigmoid::Norm,
        levels: along(180.0, 10.0, 25),
        thresholds: along(210.0, 5.0, 37),
        scales: along(15.0, 5.0, 22),
        lapses: along(0.0, 0.02, 4),
    };
    thread_local! {
        // What follows from the plan alone takes longer than many steps.
        static QUEST: std::cell::OnceCell<Quest> = const { std::cell::OnceCell::new() };
    }
    let mut quest = QUEST.with(|quest| quest.get_or_init(|| Quest::new(&plan).unwrap()).clone());
    for _ in 0..trials {
        let level = quest.next_level();
        let place = quest.place_of(level).unwrap();
        quest.answer(place, person.says(level, rng)).unwrap();
    }
    let posterior = quest::posterior(&plan, &person.answers(), LEVEL).unwrap();
    let [threshold, jnd] = [posterior.threshold, posterior.jnd];
    [
        covered(Some([Some(threshold.ci_low), Some(threshold.ci_high)]), person.curve.threshold()),
        covered(Some([Some(jnd.ci_low), Some(jnd.ci_high)]), JND),
    ]
}

fn settings_of(number: usize, rng: &mut ChaCha8Rng) -> [Said; 2] {
    let curve = Person::new(0.0, 0.0, 0.0, rng).curve;
    let plan = adjustment::Plan {
        starts: [MIDDLE - 4.0 * STEP, MIDDLE + 4.0 * STEP],
        step: JND / 2.0,
        bounds: [0.0, 2.0 * MIDDLE],
        settings: number,
    };
    let mut wishes = Vec::new();
    let mut place = curve.location + curve.scale * normal(rng);
    let settings = loop {
        let found = adjustment::settings(&plan, &wishes).unwrap();
        let Some(level) = found.next else { break found.levels };
        let wish = if (level - place).abs() <= plan.step / 2.0 {
            Wish::Right
        } else if level < place {
            Wish::More
        } else {
            Wish::Less
        };
        wishes.push(Wished { level, wish });
        if wish == Wish::Right {
            place = curve.location + curve.scale * normal(rng);
        }
    };
    let found = adjustment::adjustment(&settings, LEVEL).unwrap();
    let [low, high] = found.jnd_interval;
    [
        covered(
            Some([Some(found.threshold.ci_low), Some(found.threshold.ci_high)]),
            curve.location,
        ),
        covered((found.jnd > 0.0).then_some([Some(low), Some(high)]), JND),
    ]
}
