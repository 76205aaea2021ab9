//! Every setting on a scene: verdict, errors, work, and the first gate that it fails.

use crate::TradeError;
use crate::measured::{MetricChange, Metrics, changes};
use crate::setting::{Fineness, Setting};
use zwidth_dynamics::{
    ExistingSwings, Grid, Judgement, ModelScene, Reference, RunVerdict, Solver, System, Trajectory,
    WorkCounts,
};
use zwidth_judge::{EXACT, Errors, SAMPLE_S, Yardstick, errors};
use zwidth_results::Gate;

/// More samples are not kept.
pub(crate) const MOST_SAMPLES: usize = 5_000_000;

/// The first gate that a run does not pass.
fn gate(judgement: &Judgement, errors: Option<&Errors>) -> Gate {
    let Some(felt) = errors.map(|errors| errors.felt).filter(|_| is_sound(judgement)) else {
        return Gate::Verdict;
    };
    if is_above(felt.force_share) {
        Gate::Force
    } else if is_above(felt.angle_share) {
        Gate::Angle
    } else if felt.vibration_share.is_none_or(is_above) {
        Gate::Vibration
    } else {
        Gate::Passed
    }
}

/// Whether a person feels it; what could not be compared counts as felt.
fn is_above(share: f64) -> bool {
    share > 1.0 || share.is_nan()
}

fn is_sound(judgement: &Judgement) -> bool {
    let unsound = [
        RunVerdict::Failed,
        RunVerdict::UnstableStep,
        RunVerdict::NumericalChattering,
        RunVerdict::NumericalCreep,
        RunVerdict::DependsOnRestRule,
        RunVerdict::CannotTell,
    ];
    !unsound.contains(&judgement.verdict) && judgement.shows_the_reference
}

/// A setting on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The setting.
    pub setting: Setting,
    /// What the run is worth.
    pub judgement: Judgement,
    /// How far it is from the right answer; `None` for a run that failed.
    pub errors: Option<Errors>,
    /// Work counts of the run, sampled with the scene's own step.
    pub work: WorkCounts,
    /// The same as one number ([`WorkCounts::in_evaluations`]).
    pub evaluations: u64,
    /// Sign changes of θ̇ between samples.
    pub reversals: usize,
    /// The first gate that it does not pass.
    pub gate: Gate,
    /// The study's own metrics beside those of the right run; empty for a run that failed, without
    /// a study, or for the exact solver beside itself. They do not affect the judgement.
    pub metrics: Vec<MetricChange>,
}

impl Cell {
    /// The metric that changes most relative to what is just felt.
    pub fn furthest_metric(&self) -> Option<(&MetricChange, f64)> {
        let shares = self.metrics.iter().filter_map(|metric| Some((metric, metric.felt_share?)));
        shares.reduce(|most, next| if next.1 > most.1 { next } else { most })
    }
}

/// The settings of one solver, from the finest to the coarsest.
pub(crate) fn cells(
    scene: &ModelScene,
    yardstick: &Yardstick,
    reference: &Reference,
    settings: &[Setting],
    metrics: Option<&Metrics<'_>>,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Cell>, TradeError> {
    let mut earlier: Vec<(f64, ExistingSwings)> = Vec::new();
    let mut cells = Vec::new();
    for setting in settings {
        cells.push(cell(scene, yardstick, reference, *setting, metrics, &mut earlier)?);
        progress();
    }
    Ok(cells)
}

/// Runs and judges a setting. `earlier` holds the swings of the runs with finer steps, each after
/// its step (s), to which this one's are added.
pub(crate) fn cell(
    scene: &ModelScene,
    yardstick: &Yardstick,
    reference: &Reference,
    setting: Setting,
    metrics: Option<&Metrics<'_>>,
    earlier: &mut Vec<(f64, ExistingSwings)>,
) -> Result<Cell, TradeError> {
    let solver = setting.solver();
    let system = &yardstick.system;
    // A solver without a step is sampled finely enough for its errors, whatever the scene's step.
    let step_s = setting.step_s().unwrap_or(scene.step_s.min(SAMPLE_S));
    let judged_s = setting.step_s().unwrap_or(scene.step_s);
    let run = match solver.run(system, &grid(scene, step_s)?) {
        Ok(run) => run,
        Err(_) => return Ok(failed(setting, reference.judge(solver.as_ref(), judged_s))),
    };
    let own = reference.swings(&run);
    let finer = finer(system, reference, setting, &own, earlier, solver.as_ref());
    let judgement = reference.judge_with(solver.as_ref(), step_s, &run, [&finer[0], &finer[1]]);
    if let Some(step_s) = setting.step_s() {
        earlier.push((step_s, own));
    }
    let mut errors = errors(yardstick, &run)?;
    let is_yardstick = setting.solver == EXACT && yardstick.by == EXACT;
    if is_yardstick {
        // It would be compared with itself: what is known of it is how far another solver is.
        let apart_rad = yardstick.apart_rad.unwrap_or(f64::INFINITY);
        (errors.theta_rad.largest, errors.theta_rad.rms) = (apart_rad, apart_rad);
        errors.event_s = yardstick.apart_s;
    }
    let metrics = metrics.filter(|_| !is_yardstick);
    let metrics = metrics.map(|metrics| changes(yardstick, &run, metrics)).transpose()?;
    let work = work(setting, scene, system, &run, solver.as_ref());
    Ok(Cell {
        setting,
        gate: gate(&judgement, Some(&errors)),
        judgement,
        errors: Some(errors),
        work,
        evaluations: work.in_evaluations(&run.layout),
        reversals: run.reversals(),
        metrics: metrics.unwrap_or_default(),
    })
}

fn failed(setting: Setting, judgement: Judgement) -> Cell {
    Cell {
        setting,
        judgement: Judgement { verdict: RunVerdict::Failed, ..judgement },
        errors: None,
        work: WorkCounts::default(),
        evaluations: 0,
        reversals: 0,
        gate: Gate::Verdict,
        metrics: Vec::new(),
    }
}

/// The work of a run that is sampled with the scene's own step; the exact solver's depends on it.
fn work(
    setting: Setting,
    scene: &ModelScene,
    system: &System,
    run: &Trajectory,
    solver: &dyn Solver,
) -> WorkCounts {
    match setting.fineness {
        Fineness::StepS(_) => run.work,
        // The run at hand may be sampled more finely than the scene, so that its errors are known.
        Fineness::None | Fineness::Tolerance(_) => {
            let again = solver.run(system, &Grid::filling(scene.duration_s, scene.step_s));
            again.map_or(run.work, |run| run.work)
        }
    }
}

/// The swings with half and a quarter of the step: of runs that were made, or made here. An
/// adaptive solver's step is its own, so that halving the samples' changes nothing.
fn finer(
    system: &System,
    reference: &Reference,
    setting: Setting,
    own: &ExistingSwings,
    earlier: &[(f64, ExistingSwings)],
    solver: &dyn Solver,
) -> [ExistingSwings; 2] {
    let Some(step_s) = setting.step_s() else { return [own.clone(), own.clone()] };
    [0.5, 0.25].map(|share| {
        let wanted = share * step_s;
        // A step that was halved is its half but for rounding.
        let same = earlier.iter().find(|(step, _)| (step / wanted - 1.0).abs() < 1e-9);
        if let Some((_, swings)) = same {
            return swings.clone();
        }
        // Below the finest step of the fan nothing is run: what it would show shows with this one.
        let is_run = earlier.first().is_none_or(|(finest, _)| wanted >= *finest);
        let run = is_run.then(|| {
            grid(system.scene(), wanted).ok().and_then(|grid| solver.run(system, &grid).ok())
        });
        run.flatten().map_or_else(|| own.clone(), |run| reference.swings(&run))
    })
}

/// The grid that fills a scene, if it is not too long.
pub(crate) fn grid(scene: &ModelScene, step_s: f64) -> Result<Grid, TradeError> {
    let duration_s = scene.duration_s;
    if duration_s / step_s >= MOST_SAMPLES as f64 {
        return Err(TradeError::TooLong { duration_s, step_s, most: MOST_SAMPLES });
    }
    Ok(Grid::filling(duration_s, step_s))
}
