//! Every peer is tuned alike: of all its tolerances and largest steps whose error stays below the
//! target the fastest is kept. Then all are timed in rounds, one after the other, so that a busy
//! moment hits them all.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use zwidth_dynamics::{DormandPrince, Grid, System, Tolerances, TrBdf2};

use crate::diffsol_peer::{self, Method};
use crate::dopri::{self, Aim};
use crate::ode_solvers_peer;
use crate::ours;
use crate::scene::{STICKING, Samples};
use crate::swept;

/// Largest error of θ over the samples that a tuned peer may have, rad.
const TARGETS_RAD: [f64; 2] = [1e-6, 1e-10];
/// Tolerances tried.
pub(crate) const TOLERANCES: [f64; 23] = [
    1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 3e-9, 1e-9,
    3e-10, 1e-10, 3e-11, 1e-11, 3e-12, 1e-12, 3e-13, 1e-13,
];
/// Largest steps tried, s. An explicit method of order 5 is stable up to about 17 ms on this scene.
pub(crate) const LARGEST_STEPS_S: [f64; 10] =
    [f64::INFINITY, 0.018, 0.016, 0.014, 0.012, 0.01, 0.008, 0.006, 0.004, 0.002];
/// Time spent on one trial of a setting.
const TRIAL: Duration = Duration::from_millis(3);
/// Time spent on one peer in one round, and the number of rounds in a pass.
const ROUND: Duration = Duration::from_millis(80);
const ROUNDS: usize = 6;
/// Slower settings are not tried any further.
const TOO_SLOW: Duration = Duration::from_millis(400);

/// A run of a peer with its setting fixed.
pub(crate) type Run<'a> = Box<dyn FnMut(&mut Samples) -> Result<u64, String> + 'a>;
/// Makes such runs.
type Make<'a> = Box<dyn Fn(Aim) -> Result<Run<'a>, String> + 'a>;

struct Peer<'a> {
    name: &'static str,
    method: &'static str,
    /// Whether it has a largest step to tune.
    steps: bool,
    /// Whether the sine may join the state: the forms tried.
    forms: &'static [bool],
    make: Make<'a>,
}

/// A peer at its best setting for a target.
pub(crate) struct Tuned<'a> {
    pub(crate) name: &'static str,
    pub(crate) method: &'static str,
    pub(crate) target_rad: f64,
    pub(crate) aim: Option<Aim>,
    pub(crate) error_rad: f64,
    pub(crate) evaluations: u64,
    /// Scenes per run.
    pub(crate) scenes: u32,
    /// The run in one or several parts, each timed by itself.
    pub(crate) parts: Vec<Run<'a>>,
}

fn diffsol(method: Method, aim: Aim) -> Result<Run<'static>, String> {
    Ok(if aim.sine_joins {
        Box::new(diffsol_peer::prepare::<4>(method, aim)?)
    } else {
        Box::new(diffsol_peer::prepare::<2>(method, aim)?)
    })
}

fn peers(system: &System) -> Vec<Peer<'_>> {
    let by_hand = |forms| Peer {
        name: "hand-coded Rust",
        method: "DP5(4)",
        steps: true,
        forms,
        make: Box::new(|aim| {
            Ok(Box::new(move |out: &mut Samples| Ok(dopri::run(&STICKING, aim, out))))
        }),
    };
    let diffsol_by = |method, name| Peer {
        name: "diffsol 0.18",
        method: name,
        steps: false,
        forms: &[false, true],
        make: Box::new(move |aim: Aim| diffsol(method, aim)),
    };
    vec![
        Peer {
            name: "zwidth DormandPrince",
            method: "DP5(4), general",
            steps: false,
            forms: &[true],
            make: Box::new(move |aim| {
                let solver = DormandPrince { tolerances: Tolerances::of(aim.tolerance) };
                Ok(Box::new(move |out: &mut Samples| ours::general(&solver, system, out)))
            }),
        },
        Peer {
            name: "zwidth TrBdf2",
            method: "TR-BDF2, general",
            steps: false,
            forms: &[true],
            make: Box::new(move |aim| {
                let solver = TrBdf2 { tolerances: Tolerances::of(aim.tolerance) };
                Ok(Box::new(move |out: &mut Samples| ours::general(&solver, system, out)))
            }),
        },
        by_hand(&[false]),
        by_hand(&[true]),
        Peer {
            name: "ode_solvers 0.6",
            method: "Dopri5, restarted",
            steps: true,
            forms: &[false, true],
            make: Box::new(|aim| {
                Ok(Box::new(move |out: &mut Samples| ode_solvers_peer::run(aim, out)))
            }),
        },
        diffsol_by(Method::Bdf, "BDF"),
        diffsol_by(Method::TrBdf2, "TR-BDF2"),
        diffsol_by(Method::Esdirk34, "ESDIRK34"),
        diffsol_by(Method::Tsit45, "Tsit45"),
    ]
}

/// Largest difference of θ, rad; infinite if a sample is missing or not a number.
pub(crate) fn error(out: &Samples, reference: &[f64]) -> f64 {
    let differences = || out.theta.iter().zip(reference).map(|(a, b)| (a - b).abs());
    let whole = out.theta.len() == reference.len() && out.theta_dot.len() == reference.len();
    if whole && differences().all(f64::is_finite) {
        differences().fold(0.0, f64::max)
    } else {
        f64::INFINITY
    }
}

/// The shortest of the runs that fit into a time, at least two.
fn best(run: &mut Run<'_>, time: Duration, out: &mut Samples) -> Duration {
    let (begin, mut best, mut runs) = (Instant::now(), Duration::MAX, 0);
    while runs < 2 || begin.elapsed() < time {
        let start = Instant::now();
        let done = run(std::hint::black_box(out));
        best = best.min(start.elapsed());
        std::hint::black_box(done.is_ok());
        runs += 1;
    }
    best
}

/// Every setting a peer may have, the coarsest tolerance first.
fn settings(peer: &Peer<'_>) -> Vec<Aim> {
    let steps = if peer.steps { &LARGEST_STEPS_S[..] } else { &LARGEST_STEPS_S[..1] };
    let with = |tolerance, largest_step_s| {
        peer.forms.iter().map(move |&sine_joins| Aim { tolerance, largest_step_s, sine_joins })
    };
    TOLERANCES
        .iter()
        .flat_map(|&tolerance| steps.iter().flat_map(move |&step| with(tolerance, step)))
        .collect()
}

fn tune<'a>(
    peer: &Peer<'a>,
    target_rad: f64,
    reference: &[f64],
    out: &mut Samples,
) -> Option<Tuned<'a>> {
    let mut found: Option<(Duration, Tuned<'a>)> = None;
    for aim in settings(peer) {
        let Ok(mut run) = (peer.make)(aim) else { continue };
        let start = Instant::now();
        let Ok(evaluations) = run(out) else { continue };
        let error_rad = error(out, reference);
        if start.elapsed() > TOO_SLOW {
            break;
        }
        let time = if error_rad <= target_rad { best(&mut run, TRIAL, out) } else { Duration::MAX };
        if time < found.as_ref().map_or(Duration::MAX, |(least, _)| *least) {
            let Peer { name, method, .. } = *peer;
            found = Some((
                time,
                Tuned {
                    name,
                    method,
                    target_rad,
                    aim: Some(aim),
                    error_rad,
                    evaluations,
                    scenes: 1,
                    parts: vec![run],
                },
            ));
        }
    }
    found.map(|(_, tuned)| tuned)
}

/// The exact solver, ready and from nothing: it has nothing to tune.
fn exact<'a>(
    system: &'a System,
    grid: &'a Grid,
    out: &mut Samples,
) -> Result<Vec<Tuned<'a>>, String> {
    let mut prepared = ours::prepare(system)?;
    let [mut first, mut second] = [ours::room(grid)?, ours::room(grid)?];
    let ready: Run<'a> = Box::new(move |_| ours::exact(prepared.as_mut(), grid, &mut first));
    let fresh: Run<'a> =
        Box::new(move |_| ours::exact(ours::prepare(system)?.as_mut(), grid, &mut second));
    let mut all = Vec::new();
    for (name, method, mut run) in
        [("zwidth exact", "ready", ready), ("zwidth exact", "first run", fresh)]
    {
        let evaluations = run(out)?;
        all.push(Tuned {
            name,
            method,
            target_rad: 0.0,
            aim: None,
            error_rad: 0.0,
            evaluations,
            scenes: 1,
            parts: vec![run],
        });
    }
    Ok(all)
}

/// Tunes and times all; one tab-separated row a peer and target: name, method, form of the sine,
/// target, tolerance, largest step, error, evaluations, seconds in the first and second pass,
/// remark.
pub(crate) fn measure() -> Result<String, String> {
    let (system, grid, reference) = (ours::system(&STICKING)?, ours::grid(), ours::reference()?);
    let mut out = Samples::default();
    let mut all = exact(&system, &grid, &mut out)?;
    let mut rows = String::new();
    for peer in peers(&system) {
        for target in TARGETS_RAD {
            match tune(&peer, target, &reference, &mut out) {
                Some(tuned) => all.push(tuned),
                None => writeln!(
                    rows,
                    "{}\t{}\t\t{target:e}\t\t\t\t\t\t\tnot reached",
                    peer.name, peer.method
                )
                .map_err(|error| error.to_string())?,
            }
        }
    }
    let one = tuned_by_hand(&all);
    all.extend(swept::peers(&grid, one, &mut out)?);
    let passes = [pass(&mut all, &mut out), pass(&mut all, &mut out)];
    for (i, tuned) in all.iter().enumerate() {
        writeln!(rows, "{}", row(tuned, passes[0][i], passes[1][i]))
            .map_err(|error| error.to_string())?;
    }
    Ok(rows)
}

/// The setting of Dormand–Prince by hand for the one scene and the coarser target.
fn tuned_by_hand(all: &[Tuned<'_>]) -> Option<Aim> {
    let by_hand = |tuned: &&Tuned<'_>| {
        tuned.name == "hand-coded Rust"
            && tuned.target_rad.to_bits() == TARGETS_RAD[0].to_bits()
            && tuned.aim.is_some_and(|aim| aim.sine_joins)
    };
    all.iter().find(by_hand).and_then(|tuned| tuned.aim)
}

/// Times the exact solver, Dormand–Prince by hand and the sweep alone: the rows of a quick look.
pub(crate) fn sweep() -> Result<String, String> {
    let (system, grid, reference) = (ours::system(&STICKING)?, ours::grid(), ours::reference()?);
    let mut out = Samples::default();
    let mut all = exact(&system, &grid, &mut out)?;
    let peers = peers(&system);
    let by_hand =
        peers.iter().filter(|peer| peer.name == "hand-coded Rust" && peer.forms == [true]);
    all.extend(by_hand.filter_map(|peer| tune(peer, TARGETS_RAD[0], &reference, &mut out)));
    let one = tuned_by_hand(&all);
    all.extend(swept::peers(&grid, one, &mut out)?);
    let passes = [pass(&mut all, &mut out), pass(&mut all, &mut out)];
    Ok(all
        .iter()
        .enumerate()
        .map(|(i, tuned)| row(tuned, passes[0][i], passes[1][i]) + "\n")
        .collect())
}

/// The shortest run of each over all rounds; of a run in parts the sum of the parts' shortest.
fn pass(all: &mut [Tuned<'_>], out: &mut Samples) -> Vec<Duration> {
    let mut least: Vec<Vec<Duration>> =
        all.iter().map(|tuned| vec![Duration::MAX; tuned.parts.len()]).collect();
    for _ in 0..ROUNDS {
        for (tuned, least) in all.iter_mut().zip(&mut least) {
            let time = ROUND / tuned.parts.len() as u32;
            for (run, least) in tuned.parts.iter_mut().zip(least) {
                *least = (*least).min(best(run, time, out));
            }
        }
    }
    least.iter().map(|parts| parts.iter().sum()).collect()
}

fn row(tuned: &Tuned<'_>, first: Duration, second: Duration) -> String {
    let Tuned { name, method, target_rad, error_rad, evaluations, scenes, .. } = tuned;
    let sine =
        tuned.aim.map_or("", |aim| if aim.sine_joins { "in the state" } else { "evaluated" });
    let tolerance = tuned.aim.map_or_else(String::new, |aim| format!("{:e}", aim.tolerance));
    let step = tuned.aim.map(|aim| aim.largest_step_s).filter(|step| step.is_finite());
    let step = step.map_or_else(String::new, |step| step.to_string());
    let (first, second) =
        (first.as_secs_f64() / f64::from(*scenes), second.as_secs_f64() / f64::from(*scenes));
    format!(
        "{name}\t{method}\t{sine}\t{target_rad:e}\t{tolerance}\t{step}\t{error_rad:e}\t{evaluations}\t{first:e}\t{second:e}\t"
    )
}
