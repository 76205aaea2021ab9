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
    /// The bounds of what a person can feel.
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
        // Of equal ones the first, which `max_by` would not give.
        all.reduce(|most, next| if next.1 > most.1 { next } else { most })
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
        let smaller = set.terms().filter_map(|term| self.rung(set.without(term)));
        smaller.min_by(|a, b| {
            let [a, b] = [a, b].map(|rung| rung.furthest().map_or(0.0, |(_, off)| off));
            a.total_cmp(&b)
        })
    }

    /// The switch of a term in [`Quantity::variance`]; `None` for one that was not offered.
    pub fn switch(&self, term: LadderTerm) -> Option<usize> {
        self.offered.terms().position(|offered| offered == term)
    }
}

/// The comparison of all models at one point.
struct AtPoint {
    /// By rung.
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
    let period_s = settings.looped.period_s;
    let duration_s = scene.duration_s;
    let fits = period_s > 0.0 && (1.0..=MOST_PERIODS as f64).contains(&(duration_s / period_s));
    let frame = fits.then(|| Frame::of(duration_s, period_s)).filter(|frame| frame.steps > 0);
    let frame = frame.ok_or(LadderError::Period { period_s, duration_s, most: MOST_PERIODS })?;
    // In the order of their numbers, as `SwitchVariance` expects the values.
    let sets = (0..TermSet::COUNT).map(TermSet::of_number);
    let sets: Vec<TermSet> = sets.filter(|set| set.is_within(settings.offered)).collect();
    let compared: Vec<Result<AtPoint, LadderError>> = Point::sobol(points)?
        .into_par_iter()
        .enumerate()
        .map(|(i, point)| {
            let compared = at_point(scene, settings, &frame, &sets, &point, measure);
            progress();
            let scene = scene.name.clone();
            compared.map_err(|error| LadderError::Fullest { scene, point: i, error })
        })
        .collect();
    // All points first, then the first error in their order: rayon would give any of several.
    let compared = compared.into_iter().collect::<Result<Vec<_>, _>>()?;
    let rungs = sets.iter().enumerate().map(|(i, set)| rung(*set, i, &compared)).collect();
    // The variances of all points together.
    let mut of_points = compared.into_iter().map(|point| point.quantities);
    let mut quantities = of_points.next().unwrap_or_default();
    for others in of_points {
        for (quantity, other) in quantities.iter_mut().zip(&others) {
            quantity.variance.merge(&other.variance);
        }
    }
    Ok(Ladder {
        scene: scene.name.clone(),
        points,
        offered: settings.offered,
        in_scene: in_scene(scene),
        quantities,
        rungs,
    })
}

/// The set with number `at` among those compared, over all points.
fn rung(set: TermSet, at: usize, points: &[AtPoint]) -> Rung {
    let costs: Vec<Cost> = points.iter().filter_map(|point| point.costs[at]).collect();
    let mean = |count: fn(&Cost) -> u64| {
        costs.iter().map(|cost| count(cost) as f64).sum::<f64>() / costs.len().max(1) as f64
    };
    let quantities = points.first().map_or(0, |point| point.off[at].len());
    let worst = (0..quantities).map(|q| {
        points.iter().filter_map(|point| point.off[at].get(q).copied()).fold(0.0, f64::max)
    });
    Rung {
        set,
        evaluations: mean(Cost::in_evaluations),
        counts: [
            mean(|c| c.work.steps),
            mean(|c| c.work.evaluations),
            mean(|c| c.work.factorisations),
            mean(|c| c.decisions),
        ],
        worst: worst.collect(),
    }
}

/// The run of a model.
struct Ran {
    course: Course,
    numbers: Vec<Measured>,
    cost: Cost,
}

fn at_point(
    scene: &ModelScene,
    settings: &Settings,
    frame: &Frame,
    sets: &[TermSet],
    point: &Point,
    measure: &(dyn Fn(&Course) -> Vec<Measured> + Sync),
) -> Result<AtPoint, zwidth_dynamics::DynamicsError> {
    let ran = |set: TermSet| {
        let model = model(scene, set, point, settings.looped.period_s);
        let (course, cost) = run(&model, &settings.looped, frame)?;
        let numbers = measure(&course);
        Ok(Ran { course, numbers, cost })
    };
    let Ran { course, numbers, .. } = ran(settings.offered)?;
    let full = Full::new(course);
    let mut costs = Vec::with_capacity(sets.len());
    let mut off = Vec::with_capacity(sets.len());
    let mut runs = Vec::with_capacity(sets.len());
    for set in sets {
        // A model that does not run is infinitely far off, and no error: only the fullest must run.
        let ran = ran(*set).ok();
        costs.push(ran.as_ref().map(|ran| ran.cost));
        off.push(match &ran {
            Some(ran) => ran.off(&full, &numbers, &settings.bounds),
            None => vec![f64::INFINITY; 2 + numbers.len()],
        });
        runs.push(ran);
    }
    Ok(AtPoint { costs, off, quantities: quantities(&runs, &numbers, settings.offered) })
}

impl Ran {
    /// How far θ, the force and the numbers are off; what no bound is known for is off by nothing.
    fn off(&self, full: &Full, full_numbers: &[Measured], bounds: &Perception) -> Vec<f64> {
        let mut off = off_course(&self.course, full, bounds).to_vec();
        for (i, full) in full_numbers.iter().enumerate() {
            let value = self.numbers.get(i).and_then(|number| number.value);
            let share = bounds.off(value, full.value, &full.unit, self.course.lever_m);
            off.push(share.unwrap_or(0.0));
        }
        off
    }
}

/// Each quantity, and how much the terms change it; by nothing where a model did not run.
fn quantities(runs: &[Option<Ran>], numbers: &[Measured], offered: TermSet) -> Vec<Quantity> {
    let mut quantities = Vec::with_capacity(2 + numbers.len());
    for name in ["theta_rad", "feedback_n"] {
        let mut variance = SwitchVariance::none(offered.len());
        let signals = runs.iter().map(|ran| {
            let course = &ran.as_ref()?.course;
            Some(if name == "theta_rad" { &course.theta_rad[..] } else { &course.feedback_n })
        });
        let courses: Option<Vec<&[f64]>> = signals.collect();
        let courses = courses.unwrap_or_default();
        let samples = courses.iter().map(|course| course.len()).min().unwrap_or(0);
        for i in 0..samples {
            let values: Vec<f64> = courses.iter().map(|course| course[i]).collect();
            variance.add(&values);
        }
        quantities.push(Quantity { name: name.to_owned(), is_judged: true, variance });
    }
    for (i, measured) in numbers.iter().enumerate() {
        let mut variance = SwitchVariance::none(offered.len());
        let values: Option<Vec<f64>> =
            runs.iter().map(|ran| ran.as_ref()?.numbers.get(i)?.value).collect();
        if let Some(values) = values {
            variance.add(&values);
        }
        let is_judged = Perception::default().bound(0.0, &measured.unit, 1.0).is_some();
        quantities.push(Quantity { name: measured.name.clone(), is_judged, variance });
    }
    quantities
}
