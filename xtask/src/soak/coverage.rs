//! Does a 95 % interval contain the truth 95 times in a hundred? Sessions of the simulated device,
//! whose truth is known, are recorded and identified as users do it, one per seed.

use super::{RATE, STUDY, fresh, most_hits, of_seeds, run, twin};
use crate::shell::{program, scratch};
use anyhow::{Context as _, ensure};
use std::path::Path;
use zwidth_device::TwinParameters;
use zwidth_results::{Identifiability, PlantEstimate, PlantParameter, Row, ThresholdBracket};
use zwidth_stats::power::clopper_pearson;
use zwidth_store::Layout;
use zwidth_study::Control;
use zwidth_tables::{Measured, Table};

/// Of so many seeds the share must lie between these.
const MANY: usize = 400;
const SHARES: [f64; 2] = [0.92, 0.98];
/// Of fewer seeds the count must be one that 95 % would give: within the central 99.9 % of its
/// binomial distribution.
const NOMINAL: f64 = 0.95;
const CENTRAL: f64 = 0.999;
/// The mean error may be this share of the estimate's standard deviation.
const MOST_BIAS: f64 = 0.5;
/// With few seeds the mean itself scatters by 1/√seeds of that: so many times this is allowed
/// besides.
const BIAS_SCATTER: f64 = 3.3;

/// What one seed gave: the parameters, the threshold's bracket, and the force discrepancies.
struct Found {
    rows: Vec<PlantEstimate>,
    bracket: [f64; 2],
    discrepancies: Vec<Discrepancies>,
    /// What the energy observers looked at, and of it what they called active: contacts with the
    /// wall, and closed loops.
    observed: [[usize; 2]; 2],
}

/// The force discrepancies of one trial: intervals of the mean, the actuators' and the user's, and
/// of the actuators' step at the reversal, beside the step of Appendix B.
struct Discrepancies {
    mode: String,
    actuators: [f64; 2],
    user: [f64; 2],
    step: [f64; 2],
    step_of_appendix_b: f64,
}

pub(crate) fn coverage(seeds: u32) -> anyhow::Result<()> {
    let program = program()?;
    let began = std::time::Instant::now();
    let found = of_seeds(&scratch("coverage"), seeds, |root, seed| one(&program, root, seed))?;
    println!("{} seeds in {:.0} s", found.len(), began.elapsed().as_secs_f64());
    tell(&found)
}

/// Records and identifies one session.
fn one(program: &Path, root: &Path, seed: u32) -> anyhow::Result<Found> {
    let layout = fresh(root, &[("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {RATE}.0\n"))])?;
    twin(program, root, seed)?;
    run(program, root, &["--quiet", "run", STUDY, "--only", "metrics of the study"], &[0])?;
    let estimates: Vec<PlantEstimate> = rows(&layout)?;
    for row in &estimates {
        let parameter = row.parameter.as_str();
        row.std_error.with_context(|| format!("{parameter} has no standard error"))?;
    }
    let threshold = rows::<ThresholdBracket>(&layout)?.pop();
    let bracket = threshold.and_then(|of| Some([of.low_n?, of.high_n?]));
    let bracket = bracket.context("no threshold was bracketed")?;
    let metrics = Measured::read(&layout.derived().join("metrics.parquet"), &METRICS)?;
    let discrepancies = discrepancies(&metrics)?;
    let observed = observed(metrics.table())?;
    Ok(Found { rows: estimates, bracket, discrepancies, observed })
}

/// The rows of a table of the study.
fn rows<R: Row>(layout: &Layout) -> anyhow::Result<Vec<R>> {
    let file = layout.derived().join(format!("{}.parquet", R::NAME));
    Ok(Table::from_parquet(&file)?.to_rows()?)
}

/// The spring of the study, N/rad, where it rests, rad, and what motor and brake give at 8 V, N.
const SPRING_N_PER_RAD: f64 = 4.0;
const REST_RAD: f64 = -std::f64::consts::FRAC_PI_4;
const MOTOR_N: f64 = 2.08;
const BRAKE_N: f64 = 13.0;

/// The metrics that are looked at: of the force discrepancies, then of the energy observers.
const METRICS: [&str; 11] = [
    "theta_max_rad",
    "discrepancy_actuator_mean_ci_low_n",
    "discrepancy_actuator_mean_ci_high_n",
    "discrepancy_user_mean_ci_low_n",
    "discrepancy_user_mean_ci_high_n",
    "discrepancy_actuator_step_ci_low_n",
    "discrepancy_actuator_step_ci_high_n",
    "wall_contacts",
    "wall_contacts_active",
    "closed_loops",
    "closed_loops_active",
];

/// Of the trials in the spring without a wall that have a way back.
fn discrepancies(metrics: &Measured) -> anyhow::Result<Vec<Discrepancies>> {
    let columns = METRICS[..7].iter().map(|name| metrics.numbers(name));
    let columns: Vec<Vec<Option<f64>>> = columns.collect::<Result<_, _>>()?;
    let mut found = Vec::new();
    for (row, trial) in metrics.trials().iter().enumerate() {
        let numbers: Option<Vec<f64>> = columns.iter().map(|column| column[row]).collect();
        let Some(Ok(of)) = numbers.map(<[f64; 7]>::try_from) else { continue };
        if trial.environment.as_str() != "spring" {
            continue;
        }
        let asked_n = SPRING_N_PER_RAD * (of[0] - REST_RAD);
        found.push(Discrepancies {
            mode: trial.mode.to_string(),
            actuators: [of[1], of[2]],
            user: [of[3], of[4]],
            step: [of[5], of[6]],
            step_of_appendix_b: asked_n.min(BRAKE_N) - asked_n.min(MOTOR_N),
        });
    }
    Ok(found)
}

/// Shares of trials whose interval must hold what it should: the actuators' of a motor alone 0, the
/// hybrid's step that of Appendix B; and the most of the user's that may hold 0 with a motor alone.
const HOLD: f64 = 0.9;
const USER_HOLDS: f64 = 0.01;

/// Prints how many intervals of the force discrepancies hold what they should.
fn tell_discrepancies(found: &[Found], wrong: &mut Vec<String>) {
    let of = |mode: &'static str| {
        found.iter().flat_map(|f| &f.discrepancies).filter(move |d| d.mode == mode)
    };
    let holds = |[low, high]: [f64; 2], value: f64| low <= value && value <= high;
    let share = |some: usize, all: usize| some as f64 / all.max(1) as f64;
    let motor = of("active").count();
    let hybrid = of("hybrid").count();
    let none = of("active").filter(|d| holds(d.actuators, 0.0)).count();
    let user = of("active").filter(|d| holds(d.user, 0.0)).count();
    let steps = of("hybrid").filter(|d| holds(d.step, d.step_of_appendix_b)).count();
    println!(
        "motor alone: 0 in {none} intervals of {motor} of the actuators, in {user} of the user's"
    );
    println!("hybrid: the step of Appendix B in {steps} of {hybrid} of the actuators'");
    let mean = |of: Vec<f64>| of.iter().sum::<f64>() / of.len().max(1) as f64;
    let middles = |f: fn(&Discrepancies) -> [f64; 2]| {
        mean(of("active").map(|d| f(d).iter().sum::<f64>() / 2.0).collect())
    };
    println!(
        "motor alone, mean of the middles: actuators {:.4} N, user {:.4} N",
        middles(|d| d.actuators),
        middles(|d| d.user)
    );
    if share(none, motor) < HOLD || share(steps, hybrid) < HOLD {
        wrong.push("the actuators' intervals hold too seldom what they should".to_owned());
    }
    if share(user, motor) > USER_HOLDS {
        wrong.push(format!("{user} of the user's intervals hold 0"));
    }
}

/// What the energy observers of all trials looked at, and called active.
fn observed(metrics: &Table) -> anyhow::Result<[[usize; 2]; 2]> {
    let mut sums = [[0; 2]; 2];
    for (place, name) in METRICS[7..].iter().enumerate() {
        let counts = metrics.numbers(name)?.into_iter().flatten();
        sums[place / 2][place % 2] = counts.sum::<f64>() as usize;
    }
    Ok(sums)
}

/// The simulated device is passive, so that what an observer finds there is a false alarm. Of so
/// many there may be one, at most: a count fails that this rate gives in less than one of a
/// thousand runs.
const FALSE_ALARMS: f64 = 0.002;
/// The level of the exact interval of which the lower end must then lie below that rate.
const SURE: f64 = 0.998;

/// Prints how often the energy observers are wrong, with 95 % intervals (Clopper and Pearson).
fn tell_observed(found: &[Found], wrong: &mut Vec<String>) -> anyhow::Result<()> {
    for (kind, what) in ["wall contacts", "closed loops"].into_iter().enumerate() {
        let sum = |i: usize| found.iter().map(|f| f.observed[kind][i]).sum::<usize>();
        let all = sum(0);
        let active = sum(1);
        let (low, high) = clopper_pearson(active, all, NOMINAL)?;
        println!(
            "energy observer: {active} of {all} {what} called active, {:.2} % ({:.2} to {:.2} %)",
            100.0 * active as f64 / all as f64,
            100.0 * low,
            100.0 * high
        );
        if clopper_pearson(active, all, SURE)?.0 > FALSE_ALARMS {
            wrong.push(format!("{active} of {all} {what} are called active"));
        }
    }
    Ok(())
}

/// What the twin's plant is in the words of the fit: mass and inertia at the lever's end, what
/// damps there (bearings and the closed winding), friction in motion, lags.
fn truth(parameter: PlantParameter) -> anyhow::Result<f64> {
    let plant = TwinParameters::default().plant(None);
    let friction = plant.friction.context("the twin has friction")?;
    let [on, off] = plant.brake_lag_on_off_s.context("the twin's brake has lags")?;
    Ok(match parameter {
        PlantParameter::Mass => plant.inertia_kg_m2 / (plant.lever_m * plant.lever_m),
        PlantParameter::Damping => {
            friction.viscous_ns_per_rad + plant.back_emf_ns_per_rad.unwrap_or(0.0)
        }
        PlantParameter::Friction => friction.kinetic_n,
        PlantParameter::MotorLag => plant.motor_lag_s.unwrap_or(0.0),
        PlantParameter::BrakeOn => on,
        PlantParameter::BrakeOff => off,
    })
}

/// Prints what came out, a line a parameter, and fails where it is not what it must be.
fn tell(found: &[Found]) -> anyhow::Result<()> {
    let mut wrong = Vec::new();
    let n = found.len();
    let allowed = allowed(n);
    println!("parameter   truth      mean       coverage  bias/SD  SE/SD  identifiable");
    for (j, first) in found.first().context("no seeds")?.rows.iter().enumerate() {
        let rows: Vec<&PlantEstimate> = found.iter().filter_map(|f| f.rows.get(j)).collect();
        let parameter = first.parameter.as_str();
        let truth = truth(first.parameter)?;
        let mean = rows.iter().map(|r| r.fitted).sum::<f64>() / n as f64;
        let squares =
            |of: &dyn Fn(&PlantEstimate) -> f64| rows.iter().map(|r| of(r) * of(r)).sum::<f64>();
        let sd = (squares(&|r| r.fitted - mean) / (n as f64 - 1.0)).sqrt();
        let std_error = (squares(&|r| r.std_error.unwrap_or(f64::NAN)) / n as f64).sqrt();
        // An interval that is not there holds nothing.
        let ends = rows.iter().filter_map(|r| Some([r.ci_low?, r.ci_high?]));
        let covered = ends.filter(|[low, high]| *low <= truth && truth <= *high).count();
        let verdicts = rows.iter().map(|r| r.verdict);
        let identifiable = verdicts.filter(|v| *v == Identifiability::Identifiable).count();
        let bias = (mean - truth) / sd;
        let most = MOST_BIAS + if n < MANY { BIAS_SCATTER / (n as f64).sqrt() } else { 0.0 };
        println!(
            "{parameter:<10} {truth:<10.3e} {mean:<10.4e} {covered:>3}/{n:<5} {bias:>6.2} {:>6.2}  {identifiable}",
            std_error / sd,
        );
        if covered < allowed[0] || covered > allowed[1] {
            wrong.push(format!("{parameter}: {covered} intervals of {n} hold the truth"));
        }
        if bias.abs() > most {
            wrong.push(format!(
                "{parameter}: its mean is {bias:.2} standard deviations off, {most:.2} at most"
            ));
        }
    }
    println!("{} to {} of {n} intervals may hold the truth", allowed[0], allowed[1]);
    let set_n = Control::default().let_go_n;
    let held = found.iter().filter(|f| f.bracket[0] < set_n && set_n <= f.bracket[1]).count();
    let width = found.iter().map(|f| f.bracket[1] - f.bracket[0]).sum::<f64>() / n as f64;
    println!("let-go threshold: {held} of {n} brackets hold it; mean width {width:.3} N");
    tell_discrepancies(found, &mut wrong);
    tell_observed(found, &mut wrong)?;
    ensure!(held == n, "a bracket does not hold the let-go threshold");
    ensure!(wrong.is_empty(), "{}", wrong.join("; "));
    Ok(())
}

/// The smallest and the largest count of intervals that may hold the truth.
fn allowed(seeds: usize) -> [usize; 2] {
    let n = seeds as f64;
    if seeds >= MANY {
        return [(SHARES[0] * n).ceil() as usize, (SHARES[1] * n).floor() as usize];
    }
    let tail = (1.0 - CENTRAL) / 2.0;
    let low = most_hits(seeds, NOMINAL, |below| 1.0 - below < tail);
    [low, most_hits(seeds, NOMINAL, |below| below >= tail)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    /// SciPy: `binom.ppf(0.0005, n, 0.95)`, and the largest k with `binom.sf(k - 1, n, 0.95) >=
    /// 0.0005`.
    #[test]
    fn few_seeds_are_judged_by_the_binomial_distribution_and_many_by_the_shares() {
        assert_eq!(allowed(40), [32, 40]);
        assert_eq!(allowed(200), [179, 198]);
        assert_eq!(allowed(400), [368, 392]);
    }

    #[test]
    fn what_observers_looked_at_is_summed_over_the_trials() {
        let of = |name, values: [Option<i64>; 3]| Column::integer(name, "1", "", values);
        let columns = vec![
            of("closed_loops_active", [Some(0), Some(1), None]),
            of("wall_contacts", [None, Some(2), Some(1)]),
            of("wall_contacts_active", [None, Some(1), Some(0)]),
            of("closed_loops", [Some(1), Some(3), None]),
        ];
        let metrics = Table::new("metrics", "", columns).unwrap();
        assert_eq!(observed(&metrics).unwrap(), [[3, 1], [4, 1]]);
    }
}
