//! The motion by which a run is judged, and what that motion does.

use super::model::Model;
use super::path::Path;
use super::run_verdict::RunVerdict;
use super::swings::{FEW, Swing, existing};
use crate::solve::Solver;
use crate::solve::adaptive::Tolerances;
use crate::solve::dormand_prince::DormandPrince;
use crate::solve::exact::Exact;
use crate::solve::tr_bdf2::TrBdf2;
use crate::system::transition::EventKind;
use crate::trajectory::Trajectory;

/// A swing of less than this does not exist, rad.
const SMALLEST_RAD: f64 = 1e-9;
/// Nor does one of less than so many times the error of the reference.
const ERRORS: f64 = 100.0;
/// Relative error of the exact solver (see [`Exact`]).
const EXACT: f64 = 1e-12;
/// Samples of a reference, between which it is a cubic; more where an input is fast.
const SAMPLES: f64 = 4000.0;

/// The motion of a model as it is known: by `exact`, or where that cannot run it by two independent
/// methods that agree. Made once for a model and any number of runs.
pub struct Reference<'a> {
    pub(super) model: &'a dyn Model,
    /// None if the motion is not known.
    pub(super) motion: Option<KnownMotion>,
    /// The same with the other rule for the command at rest, where there is one.
    pub(super) other_rule: Option<KnownMotion>,
}

/// A motion that is known.
pub(super) struct KnownMotion {
    pub(super) method: String,
    pub(super) path: Path,
    pub(super) swings: Vec<Swing>,
    /// Half the peak-to-peak angle from which on a swing exists, rad.
    pub(super) bound_rad: f64,
    /// What the motion itself is.
    pub(super) nature: RunVerdict,
}

impl<'a> Reference<'a> {
    /// Finds the motion of a model.
    pub fn of(model: &'a dyn Model) -> Self {
        let other = model.with_other_rest_rule();
        let other_rule = other.and_then(|other| KnownMotion::of(other.as_ref()));
        Self { model, motion: KnownMotion::of(model), other_rule }
    }
}

impl KnownMotion {
    fn of(model: &dyn Model) -> Option<Self> {
        let step_s = step_s(model);
        let exact = Exact::default();
        match model.run(&exact, step_s) {
            Ok(run) => {
                let path = Path::of(&run);
                let error_rad = EXACT * path.largest_rad();
                Some(Self::new(model, &run, path, error_rad, exact.name()))
            }
            Err(_) => Self::by_two_methods(model, step_s),
        }
    }

    fn new(
        model: &dyn Model,
        run: &Trajectory,
        path: Path,
        error_rad: f64,
        method: String,
    ) -> Self {
        let bound_rad = SMALLEST_RAD.max(ERRORS * error_rad);
        let swings = existing(run, bound_rad);
        let nature = nature(model, run, &path, &swings);
        Self { method, path, swings, bound_rad, nature }
    }

    /// Dormand–Prince and TR-BDF2, each with its step and half of it (by its tolerance). Their
    /// motions must agree.
    fn by_two_methods(model: &dyn Model, step_s: f64) -> Option<Self> {
        /// Tolerances of a step and of half a step: errors per step fall with h⁵ and with h³.
        const DORMAND_PRINCE: [f64; 2] = [3.2e-10, 1e-11];
        const TR_BDF2: [f64; 2] = [8e-8, 1e-8];
        /// Steps after which a method gives up: some seconds of work.
        const MOST_STEPS: u64 = 3_000_000;
        /// The two may differ by this share of the largest swing, or of the range.
        const AGREE: f64 = 0.05;
        let tolerances =
            |tolerance| Tolerances { most_steps: MOST_STEPS, ..Tolerances::of(tolerance) };
        let [coarse, fine] = DORMAND_PRINCE.map(|t| DormandPrince { tolerances: tolerances(t) });
        let [coarse_2, fine_2] = TR_BDF2.map(|t| TrBdf2 { tolerances: tolerances(t) });
        let first = Self::by_halving(model, step_s, &coarse, &fine)?;
        let second = Self::by_halving(model, step_s, &coarse_2, &fine_2)?;
        let largest = first.swings.iter().map(|swing| swing.amplitude_rad).fold(0.0, f64::max);
        let size = if largest > 0.0 { largest } else { first.path.range_rad() };
        let apart = first.path.distance_rad(&second.path);
        let agree = first.nature == second.nature && apart <= AGREE * size + second.bound_rad;
        agree.then(|| Self { method: format!("{} and {}", first.method, second.method), ..first })
    }

    /// The motion by a method with the finer of two steps; their difference is its error.
    fn by_halving(
        model: &dyn Model,
        step_s: f64,
        coarse: &dyn Solver,
        fine: &dyn Solver,
    ) -> Option<Self> {
        let coarse_path = Path::of(&model.run(coarse, step_s).ok()?);
        let run = model.run(fine, step_s).ok()?;
        let path = Path::of(&run);
        let error_rad = path.distance_rad(&coarse_path).max(EXACT * path.largest_rad());
        Some(Self::new(model, &run, path, error_rad, fine.name()))
    }
}

/// Time between samples of a reference: a share of the run, and of a period of the inputs.
fn step_s(model: &dyn Model) -> f64 {
    /// Samples in a period.
    const IN_A_PERIOD: f64 = 64.0;
    /// Most samples.
    const MOST: f64 = 400_000.0;
    let duration_s = model.plant().scene.duration_s;
    let fastest_s = periods(model).into_iter().fold(f64::INFINITY, f64::min);
    (duration_s / SAMPLES).min(fastest_s / IN_A_PERIOD).max(duration_s / MOST)
}

/// The periods of the inputs.
fn periods(model: &dyn Model) -> Vec<f64> {
    let scene = &model.plant().scene;
    let inputs = [Some(&scene.input), scene.terms.input()];
    inputs.into_iter().flatten().filter_map(|input| input.period_s()).collect()
}

/// What a motion is, by the motion itself.
fn nature(model: &dyn Model, run: &Trajectory, path: &Path, swings: &[Swing]) -> RunVerdict {
    /// Change of the amplitude from the first to the last third that counts.
    const FALLS: f64 = 0.9;
    const RISES: f64 = 1.1;
    if swings.len() < FEW {
        return RunVerdict::Smooth;
    }
    if periods(model).into_iter().any(|period_s| repeats(path, swings, period_s)) {
        return RunVerdict::Forced;
    }
    let Some([first, middle, last]) = thirds(&undisturbed(run, swings)) else {
        return RunVerdict::Transient; // a few swings after each jump of an input
    };
    let changes = !has_settled([first, middle, last]);
    if changes && last < FALLS * first {
        RunVerdict::Transient
    } else if changes && last > RISES * first {
        RunVerdict::Growing
    } else if model.is_conservative(run) {
        RunVerdict::FreeUndamped
    } else {
        RunVerdict::LimitCycle
    }
}

/// Whether a motion repeats, at its end, with a period or with 2 to 4 of them: two stretches of
/// that length differ by less than a tenth of the swings.
fn repeats(path: &Path, swings: &[Swing], period_s: f64) -> bool {
    const MOST_PERIODS: usize = 4;
    const ALIKE: f64 = 0.1;
    const ROUNDING: f64 = 1e-9;
    let end_s = path.end_s();
    (1..=MOST_PERIODS).map(|k| k as f64 * period_s).any(|stretch_s| {
        let from_s = end_s - stretch_s;
        let in_it = swings.iter().filter(|swing| swing.to_s > from_s);
        let size = in_it.map(|swing| swing.amplitude_rad).fold(0.0, f64::max);
        2.0 * stretch_s <= end_s * (1.0 + ROUNDING)
            && path.change_rad(from_s, stretch_s) < ALIKE * size
    })
}

/// The swings of the longest series that no jump of an input disturbs.
fn undisturbed(run: &Trajectory, swings: &[Swing]) -> Vec<Swing> {
    let jumps = run.events.iter().filter(|event| event.kind == EventKind::Input);
    let mut edges: Vec<f64> = jumps.map(|event| event.t_s).collect();
    edges.insert(0, f64::NEG_INFINITY);
    edges.push(f64::INFINITY);
    let series = edges.windows(2).map(|edge| -> Vec<Swing> {
        let swings = swings.iter();
        let inside = swings.filter(|swing| edge[0] <= swing.from_s && swing.to_s <= edge[1]);
        inside.copied().collect()
    });
    series.max_by_key(Vec::len).unwrap_or_default()
}

/// Mean amplitude, weighted by duration, of the swings in each third of the time they take; `None`
/// for fewer than an oscillation has.
fn thirds(swings: &[Swing]) -> Option<[f64; 3]> {
    let first = swings.first()?;
    let last = swings.last()?;
    let third_s = (last.to_s - first.from_s) / 3.0;
    if swings.len() < FEW {
        return None;
    }
    let mut sums = [(0.0, 0.0); 3];
    for swing in swings {
        let middle_s = 0.5 * (swing.from_s + swing.to_s) - first.from_s;
        let (sum, weight) = &mut sums[((middle_s / third_s) as usize).min(2)];
        *sum += swing.amplitude_rad * swing.duration_s();
        *weight += swing.duration_s();
    }
    Some(sums.map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 0.0 }))
}

/// Whether an amplitude that changed at first does so no longer: the way into a cycle from inside
/// or outside.
fn has_settled([first, middle, last]: [f64; 3]) -> bool {
    /// The later change, in its logarithm, is below this share of the earlier one, which an
    /// exponential keeps and a Coulomb decay exceeds.
    const SHARE: f64 = 0.25;
    let early = libm::log(middle / first).abs();
    let late = libm::log(last / middle).abs();
    late < SHARE * early
}
