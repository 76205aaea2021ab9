//! Compares every set of terms with the fullest model, at every point.

use crate::error::LadderError;
use crate::model::{Loop, model};
use crate::quantities::{Full, off_course};
use crate::ranges::Point;
use crate::run::{Cost, Course, Frame, run};
use crate::terms::in_scene;
use rayon::prelude::*;
use zwidth_dynamics::ModelScene;
use zwidth_results::{LadderTerm, TermSet};
use zwidth_stats::sensitivity::SwitchVariance;
use zwidth_study::{Measured, Perception};

/// Most points of a ladder.
pub const MOST_POINTS: usize = 4096;
/// Points of a ladder by default.
pub const DEFAULT_POINTS: usize = 64;
/// Most periods of the loop in a scene.
pub const MOST_PERIODS: usize = 100_000;

/// The parts of a ladder besides its scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The digital loop.
    pub looped: Loop,
    /// Number of points of the parameters.
    pub points: usize,
    /// What a person can feel.
    pub bounds: Perception,
    /// The terms that are offered; the fullest model has them all.
    pub offered: TermSet,
}

/// A quantity by which models are compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name, which ends in its unit.
    pub name: String,
    /// Whether a bound is known for its unit: else it judges nothing.
    pub is_judged: bool,
    /// How much each term changes it: parts of the variance that switching terms on and off makes,
    /// added up over the points (and over time for a course).
    pub variance: SwitchVariance,
}

/// A set of terms: what it costs and how far it is off the fullest model.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// The terms.
    pub set: TermSet,
    /// Evaluations of a run ([`Cost::in_evaluations`]), mean over the points.
    pub evaluations: f64,
    /// Steps, products with a flow, exponentials and decisions of a run, mean over the points.
    pub counts: [f64; 4],
    /// Largest difference of each quantity over its bound, over the points; infinite where the
    /// model does not run.
    pub worst: Vec<f64>,
}

impl Rung {
    /// The quantity that is furthest off, by its place, and how far over its bound.
    pub fn furthest(&self) -> Option<(usize, f64)> {
        let all = self.worst.iter().copied().enumerate();
        all.fold(
            None,
            |most, at| if most.is_none_or(|m: (usize, f64)| at.1 > m.1) { Some(at) } else { most },
        )
    }

    /// Whether nobody could feel the difference to the fullest model, at any point.
    pub fn is_enough(&self) -> bool {
        self.worst.iter().all(|off| *off <= 1.0)
    }
}

/// The ladder of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// The scene's name.
    pub scene: String,
    /// Number of points.
    pub points: usize,
    /// The terms that were offered.
    pub offered: TermSet,
    /// The terms whose numbers the scene gives, and those of the digital loop.
    pub in_scene: TermSet,
    /// The quantities; first θ and the force against time.
    pub quantities: Vec<Quantity>,
    /// Every set of the offered terms, in the order of their numbers.
    pub rungs: Vec<Rung>,
}

impl Ladder {
    /// The rung of a set.
    pub fn rung(&self, set: TermSet) -> Option<&Rung> {
        self.rungs.iter().find(|rung| rung.set == set)
    }

    /// The cheapest model that nobody could tell from the fullest, at any point; among equally
    /// cheap ones, that with fewer terms.
    pub fn choice(&self) -> Option<&Rung> {
        let enough = self.rungs.iter().filter(|rung| rung.is_enough());
        enough.min_by(|a, b| {
            let cost = a.evaluations.total_cmp(&b.evaluations);
            cost.then(a.set.len().cmp(&b.set.len()))
        })
    }

    /// The model whose error decides whether a choice has a term. Of a term that it has: the choice
    /// without it. Of one that it does not have: the fullest model without it, or, where that is
    /// off by more than can be felt, the choice itself.
    pub fn deciding<'a>(&'a self, choice: &'a Rung, term: LadderTerm) -> Option<&'a Rung> {
        if choice.set.has(term) {
            return self.rung(choice.set.without(term));
        }
        let alone = self.rung(self.offered.without(term)).filter(|alone| alone.is_enough());
        Some(alone.unwrap_or(choice))
    }

    /// The model with one term less than a set that is least far off.
    pub fn next_smaller(&self, set: TermSet) -> Option<&Rung> {
        let off = |rung: &Rung| rung.furthest().map_or(0.0, |(_, off)| off);
        let smaller = set.terms().filter_map(|term| self.rung(set.without(term)));
        smaller.min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// What one point gives.
struct AtPoint {
    costs: Vec<Option<Cost>>,
    /// By rung, then by quantity.
    off: Vec<Vec<f64>>,
    quantities: Vec<Quantity>,
}

/// The ladder of a scene. `measure` gives further numbers of a course, always the same ones; its
/// angles, forces, stiffnesses, works and viscosities judge too. `progress` is called after each
/// point. Points run side by side; the result has the same bits on any number of threads.
///
/// # Errors
/// A scene, a period or a number of points that makes no sense; a fullest model that does not run.
pub fn ladder(
    scene: &ModelScene,
    settings: &Settings,
    measure: &(dyn Fn(&Course) -> Vec<Measured> + Sync),
    progress: &(dyn Fn() + Sync),
) -> Result<Ladder, LadderError> {
    let points = settings.points;
    if !(1..=MOST_POINTS).contains(&points) {
        return Err(LadderError::Points { points, most: MOST_POINTS });
    }
    let frame = frame(scene, settings.looped.period_s)?;
    let sets = subsets(settings.offered);
    let at = |(i, point): (usize, Point)| {
        let found = at_point(scene, settings, &frame, &sets, &point, measure);
        progress();
        found.map_err(|error| LadderError::Fullest { scene: scene.name.clone(), point: i, error })
    };
    let found: Vec<Result<AtPoint, LadderError>> =
        Point::sobol(points)?.into_par_iter().enumerate().map(at).collect();
    let found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(Ladder {
        scene: scene.name.clone(),
        points,
        offered: settings.offered,
        in_scene: in_scene(scene),
        rungs: sets.iter().enumerate().map(|(i, set)| rung(*set, i, &found)).collect(),
        quantities: added_up(found),
    })
}

/// Every set of the offered terms, in the order of their numbers.
fn subsets(offered: TermSet) -> Vec<TermSet> {
    (0..TermSet::COUNT).map(TermSet::of_number).filter(|set| set.is_within(offered)).collect()
}

fn frame(scene: &ModelScene, period_s: f64) -> Result<Frame, LadderError> {
    let duration_s = scene.duration_s;
    let periods = duration_s / period_s;
    let fits = period_s > 0.0 && (1.0..=MOST_PERIODS as f64).contains(&periods);
    let frame = fits.then(|| Frame::of(duration_s, period_s)).filter(|frame| frame.steps > 0);
    frame.ok_or(LadderError::Period { period_s, duration_s, most: MOST_PERIODS })
}

fn rung(set: TermSet, at: usize, found: &[AtPoint]) -> Rung {
    let ran: Vec<Cost> = found.iter().filter_map(|point| point.costs[at]).collect();
    let mean = |of: fn(&Cost) -> u64| {
        ran.iter().map(|cost| of(cost) as f64).sum::<f64>() / ran.len().max(1) as f64
    };
    let quantities = found.first().map_or(0, |point| point.off[at].len());
    let at_points = |q: usize| found.iter().filter_map(move |point| point.off[at].get(q).copied());
    let worst = |q: usize| at_points(q).fold(0.0, f64::max);
    Rung {
        set,
        evaluations: mean(Cost::in_evaluations),
        counts: [
            mean(|c| c.work.steps),
            mean(|c| c.work.evaluations),
            mean(|c| c.work.factorisations),
            mean(|c| c.decisions),
        ],
        worst: (0..quantities).map(worst).collect(),
    }
}

/// The variances of all points together.
fn added_up(found: Vec<AtPoint>) -> Vec<Quantity> {
    let mut all = found.into_iter().map(|point| point.quantities);
    let mut sum = all.next().unwrap_or_default();
    for quantities in all {
        for (sum, more) in sum.iter_mut().zip(&quantities) {
            sum.variance.merge(&more.variance);
        }
    }
    sum
}

/// A model that ran: its course, its numbers and what it took.
type Ran = (Course, Vec<Measured>, Cost);

fn at_point(
    scene: &ModelScene,
    settings: &Settings,
    frame: &Frame,
    sets: &[TermSet],
    point: &Point,
    measure: &(dyn Fn(&Course) -> Vec<Measured> + Sync),
) -> Result<AtPoint, zwidth_dynamics::DynamicsError> {
    let one = |set: TermSet| {
        let model = model(scene, set, point, settings.looped.period_s);
        let (course, cost) = run(&model, &settings.looped, frame)?;
        let numbers = measure(&course);
        Ok((course, numbers, cost))
    };
    let (course, numbers, _) = one(settings.offered)?;
    let full = Full::new(course);
    let runs: Vec<Option<Ran>> =
        sets.iter().map(|set| one(*set).ok()).collect::<Vec<Option<Ran>>>();
    let bounds = &settings.bounds;
    let off = |ran: &Option<Ran>| match ran {
        Some((course, found, _)) => off(course, found, &full, &numbers, bounds),
        None => vec![f64::INFINITY; 2 + numbers.len()],
    };
    Ok(AtPoint {
        costs: runs.iter().map(|ran| ran.as_ref().map(|(_, _, cost)| *cost)).collect(),
        off: runs.iter().map(off).collect(),
        quantities: quantities(&runs, &numbers, settings.offered),
    })
}

/// θ, force, and the numbers; what no bound is known for is off by nothing.
fn off(
    course: &Course,
    found: &[Measured],
    full: &Full,
    numbers: &[Measured],
    bounds: &Perception,
) -> Vec<f64> {
    let numbers = numbers.iter().enumerate().map(|(i, full)| {
        let value = found.get(i).and_then(|found| found.value);
        bounds.off(value, full.value, &full.unit, course.lever_m).unwrap_or(0.0)
    });
    off_course(course, full, bounds).into_iter().chain(numbers).collect()
}

fn quantities(runs: &[Option<Ran>], numbers: &[Measured], offered: TermSet) -> Vec<Quantity> {
    let course = |name: &str, of: fn(&Course) -> &[f64]| Quantity {
        name: name.to_owned(),
        is_judged: true,
        variance: over_time(runs, of, offered),
    };
    let number = |(i, measured): (usize, &Measured)| {
        let is_judged = Perception::default().bound(0.0, &measured.unit, 1.0).is_some();
        let values =
            runs.iter().map(|ran| ran.as_ref()?.1.get(i)?.value).collect::<Option<Vec<f64>>>();
        let mut variance = SwitchVariance::none(offered.len());
        if let Some(values) = values {
            variance.add(&values);
        }
        Quantity { name: measured.name.clone(), is_judged, variance }
    };
    let courses = [
        course("theta_rad", |course| &course.theta_rad),
        course("feedback_n", |course| &course.feedback_n),
    ];
    courses.into_iter().chain(numbers.iter().enumerate().map(number)).collect()
}

/// Variances of a signal at each of its samples, added up; none where a model did not run.
fn over_time(runs: &[Option<Ran>], of: fn(&Course) -> &[f64], offered: TermSet) -> SwitchVariance {
    let mut variance = SwitchVariance::none(offered.len());
    let Some(signals) =
        runs.iter().map(|ran| ran.as_ref().map(|(c, _, _)| of(c))).collect::<Option<Vec<_>>>()
    else {
        return variance;
    };
    let samples = signals.iter().map(|signal| signal.len()).min().unwrap_or(0);
    for i in 0..samples {
        let values: Vec<f64> = signals.iter().map(|signal| signal[i]).collect();
        variance.add(&values);
    }
    variance
}

impl Ladder {
    /// The switch of a term in [`Quantity::variance`]; `None` for one that was not offered.
    pub fn switch(&self, term: LadderTerm) -> Option<usize> {
        self.offered.terms().position(|offered| offered == term)
    }
}
