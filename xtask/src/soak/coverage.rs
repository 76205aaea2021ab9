//! Does a 95 % interval contain the truth 95 times in a hundred? Sessions of the simulated device,
//! whose truth is known, are recorded and identified as users do it, one per seed.

use super::{STUDY, fresh, run};
use anyhow::{Context as _, bail, ensure};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use zwidth_device::TwinParameters;
use zwidth_stats::power::clopper_pearson;
use zwidth_study::Control;

/// At this rate as the study that comes along, Hz.
const RATE: &str = "120";
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
/// Seeds at once: one writes while another computes.
const AT_ONCE: u32 = 2;

/// One parameter of one seed.
struct Coverage {
    parameter: String,
    fitted: f64,
    std_error: f64,
    interval: [f64; 2],
    identifiable: bool,
}

/// What one seed gave: the parameters, the threshold's bracket, and the force discrepancies.
struct Found {
    rows: Vec<Coverage>,
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

pub(crate) fn coverage(program: &Path, folder: &Path, seeds: u32) -> anyhow::Result<()> {
    let next = AtomicU32::new(1);
    let began = std::time::Instant::now();
    let work = || -> anyhow::Result<Vec<Found>> {
        let mut found = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed > seeds {
                return Ok(found);
            }
            let root = folder.join(format!("coverage-{seed}"));
            found.push(one(program, &root, seed).with_context(|| format!("seed {seed}"))?);
            std::fs::remove_dir_all(&root)?;
        }
    };
    let parts: Vec<Vec<Found>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..AT_ONCE).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread panicked")))
            .collect::<anyhow::Result<_>>()
    })?;
    let found: Vec<Found> = parts.into_iter().flatten().collect();
    println!("{} seeds in {:.0} s", found.len(), began.elapsed().as_secs_f64());
    tell(&found)
}

/// Records and identifies one session.
fn one(program: &Path, root: &Path, seed: u32) -> anyhow::Result<Found> {
    fresh(root, &[("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {RATE}.0\n"))])?;
    let seed = seed.to_string();
    let twin = [
        "--quiet",
        "twin",
        STUDY,
        "--participants",
        "1",
        "--sessions",
        "1",
        "--seed",
        &seed,
        "--rate",
        RATE,
    ];
    run(program, root, &twin, &[0])?;
    run(program, root, &["--quiet", "run", STUDY, "--only", "metrics of the study"], &[0])?;
    let table = |name: &str| -> anyhow::Result<String> {
        let output = run(program, root, &["table", STUDY, name, "--format", "csv"], &[0])?;
        Ok(String::from_utf8(output.stdout)?)
    };
    let [low, high] = columns(&table("identify.threshold")?, ["low_n", "high_n"])?
        .pop()
        .context("no threshold was bracketed")?;
    let names = ["parameter", "fitted", "std_error", "ci_low", "ci_high", "verdict"];
    let row =
        |[parameter, fitted, std_error, low, high, verdict]: [String; 6]| -> anyhow::Result<Coverage> {
            let number =
                |text: &str| text.parse::<f64>().with_context(|| format!("{parameter}: '{text}'"));
            // An interval that is not there holds nothing.
            let end = |text: &str| if text.is_empty() { Ok(f64::NAN) } else { number(text) };
            Ok(Coverage {
                fitted: number(&fitted)?,
                std_error: number(&std_error)?,
                interval: [end(&low)?, end(&high)?],
                identifiable: verdict == "identifiable",
                parameter,
            })
        };
    let rows =
        columns(&table("identify")?, names)?.into_iter().map(row).collect::<anyhow::Result<_>>()?;
    let metrics = table("metrics")?;
    let discrepancies = discrepancies(&metrics)?;
    let observed = observed(&metrics)?;
    Ok(Found { rows, bracket: [low.parse()?, high.parse()?], discrepancies, observed })
}

/// The spring of the study, N/rad, where it rests, rad, and what motor and brake give at 8 V, N.
const SPRING_N_PER_RAD: f64 = 4.0;
const REST_RAD: f64 = -std::f64::consts::FRAC_PI_4;
const MOTOR_N: f64 = 2.08;
const BRAKE_N: f64 = 13.0;

/// Of the trials in the spring without a wall that have a way back.
fn discrepancies(metrics: &str) -> anyhow::Result<Vec<Discrepancies>> {
    let names = [
        "environment",
        "mode",
        "theta_max_rad",
        "discrepancy_actuator_mean_ci_low_n",
        "discrepancy_actuator_mean_ci_high_n",
        "discrepancy_user_mean_ci_low_n",
        "discrepancy_user_mean_ci_high_n",
        "discrepancy_actuator_step_ci_low_n",
        "discrepancy_actuator_step_ci_high_n",
    ];
    let mut found = Vec::new();
    for [environment, mode, numbers @ ..] in columns(metrics, names)? {
        let mut of = [0.0; 7];
        let all = numbers.iter().map(|text| text.parse::<f64>());
        if environment != "spring" || numbers.iter().any(String::is_empty) {
            continue;
        }
        for (place, number) in of.iter_mut().zip(all) {
            *place = number?;
        }
        let asked_n = SPRING_N_PER_RAD * (of[0] - REST_RAD);
        found.push(Discrepancies {
            mode,
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
fn observed(metrics: &str) -> anyhow::Result<[[usize; 2]; 2]> {
    let names = ["wall_contacts", "wall_contacts_active", "closed_loops", "closed_loops_active"];
    let mut sums = [[0; 2]; 2];
    for counts in columns(metrics, names)? {
        for (place, count) in counts.iter().enumerate().filter(|(_, count)| !count.is_empty()) {
            sums[place / 2][place % 2] += count.parse::<usize>()?;
        }
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

/// Some columns of a table in CSV, whose cells hold no commas.
fn columns<const N: usize>(csv: &str, names: [&str; N]) -> anyhow::Result<Vec<[String; N]>> {
    let mut lines = csv.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().context("an empty table")?;
    let place = |name: &str| {
        header.iter().position(|h| h == name).with_context(|| format!("no column {name}"))
    };
    let places = names.iter().map(|name| place(name)).collect::<anyhow::Result<Vec<_>>>()?;
    lines
        .map(|line| {
            let cells: Vec<String> = places.iter().filter_map(|i| line.get(*i).cloned()).collect();
            cells.try_into().map_err(|_| anyhow::anyhow!("a line is too short"))
        })
        .collect()
}

/// What the twin's plant is in the words of the fit: mass and inertia at the lever's end, what
/// damps there (bearings and the closed winding), friction in motion, lags.
fn truth(parameter: &str) -> anyhow::Result<f64> {
    let plant = TwinParameters::default().plant(None);
    let friction = plant.friction.context("the twin has friction")?;
    let [on, off] = plant.brake_lag_on_off_s.context("the twin's brake has lags")?;
    Ok(match parameter {
        "mass" => plant.inertia_kg_m2 / (plant.lever_m * plant.lever_m),
        "damping" => friction.viscous_ns_per_rad + plant.back_emf_ns_per_rad.unwrap_or(0.0),
        "friction" => friction.kinetic_n,
        "motor_lag" => plant.motor_lag_s.unwrap_or(0.0),
        "brake_on" => on,
        "brake_off" => off,
        other => bail!("the twin has no '{other}'"),
    })
}

/// Prints what came out, a line a parameter, and fails where it is not what it must be.
fn tell(found: &[Found]) -> anyhow::Result<()> {
    let mut wrong = Vec::new();
    let n = found.len();
    let allowed = allowed(n);
    println!("parameter   truth      mean       coverage  bias/SD  SE/SD  identifiable");
    for (j, first) in found.first().context("no seeds")?.rows.iter().enumerate() {
        let rows: Vec<&Coverage> = found.iter().filter_map(|f| f.rows.get(j)).collect();
        let truth = truth(&first.parameter)?;
        let mean = rows.iter().map(|r| r.fitted).sum::<f64>() / n as f64;
        let squares =
            |of: &dyn Fn(&Coverage) -> f64| rows.iter().map(|r| of(r) * of(r)).sum::<f64>();
        let sd = (squares(&|r| r.fitted - mean) / (n as f64 - 1.0)).sqrt();
        let std_error = (squares(&|r| r.std_error) / n as f64).sqrt();
        let covered =
            rows.iter().filter(|r| r.interval[0] <= truth && truth <= r.interval[1]).count();
        let identifiable = rows.iter().filter(|r| r.identifiable).count();
        let bias = (mean - truth) / sd;
        let most = MOST_BIAS + if n < MANY { BIAS_SCATTER / (n as f64).sqrt() } else { 0.0 };
        println!(
            "{:<10} {truth:<10.3e} {mean:<10.4e} {covered:>3}/{n:<5} {bias:>6.2} {:>6.2}  {identifiable}",
            first.parameter,
            std_error / sd,
        );
        if covered < allowed[0] || covered > allowed[1] {
            wrong.push(format!("{}: {covered} intervals of {n} hold the truth", first.parameter));
        }
        if bias.abs() > most {
            wrong.push(format!(
                "{}: its mean is {bias:.2} standard deviations off, {most:.2} at most",
                first.parameter
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
    let mut probability = NOMINAL.powi(seeds as i32);
    let mut below = 0.0;
    let mut low = 0;
    // from all of them down: the chance of k misses
    let mut high = seeds;
    for misses in 0..=seeds {
        if below + probability < tail {
            high = seeds - misses - 1;
        }
        below += probability;
        if 1.0 - below < tail {
            low = seeds - misses;
            break;
        }
        probability *= (n - misses as f64) / (misses as f64 + 1.0) * (1.0 - NOMINAL) / NOMINAL;
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let csv = "closed_loops_active,wall_contacts,wall_contacts_active,closed_loops\n\
                   0,,,1\n1,2,1,3\n,1,0,\n";
        assert_eq!(observed(csv).unwrap(), [[3, 1], [4, 1]]);
    }

    #[test]
    fn columns_come_by_their_names() {
        let csv = "a,b,c\n1,2,3\n4,,6\n";
        assert_eq!(
            columns(csv, ["c", "b"]).unwrap(),
            [["3", "2"], ["6", ""]].map(|r| r.map(str::to_owned))
        );
        assert!(columns(csv, ["d"]).is_err());
    }
}
