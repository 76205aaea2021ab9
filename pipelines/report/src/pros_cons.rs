//! The thesis' Table 1: pros and cons of brake and motor, each beside the study's own evidence.

use crate::actuation::{active, passive};
use crate::columns::{
    CONTACTS, CONTACTS_ACTIVE, ENERGY, ENERGY_AT_MOST, FORCE_PER_POWER, LOOPS, LOOPS_ACTIVE,
    PAST_WALL, RETURNED, SMOOTH, STABILITY, STIFFNESS,
};
use crate::evidence::{Evidence, Known, NOTHING_RETURNED, Verdict, a_spring, a_wall};
use crate::trials::{Mean, Trials};
use zwidth_results::ProOrCon;
use zwidth_study::{Coordinate, Environment, Mode, Resistances};
use zwidth_tables::{TableError, given, quantity, shown_unit};

/// Finds the evidence for a claim.
type Find = fn(&Known) -> Result<Option<Evidence>, TableError>;

/// Actuation, side, claim (thesis Table 1), and where the study's evidence comes from.
const CLAIMS: [(&str, &str, &str, Find); 11] = [
    ("passive", "pro", "High force to energy consumption ratio", |data| efficiency(data, [1, 0])),
    ("passive", "pro", "Lightweight", |data| Ok(mass(data, true))),
    ("passive", "pro", "Safe", brake_never_gives),
    ("passive", "con", "Only resistive forces", brake_returns_nothing),
    ("passive", "con", "Can not render stiffness", brake_has_no_way_back),
    ("active", "pro", "Easy to control", motor_is_smooth),
    ("active", "pro", "Can resist and amplify", motor_returns),
    ("active", "con", "Low force to energy consumption ratio", |data| efficiency(data, [0, 1])),
    ("active", "con", "Heavy", |data| Ok(mass(data, false))),
    ("active", "con", "Unsafe/weak trade off", motor_is_weak),
    ("active", "con", "Can not render infinite stiffness", motor_passes_the_wall),
];

/// The pros and cons of the thesis' Table 1, each beside the study's own metric and whether that
/// supports or contradicts it; `not measured` if the study has no such metric.
///
/// # Errors
/// Metrics that lack a column.
pub fn pros_cons(data: Known) -> Result<Vec<ProOrCon>, TableError> {
    let mut rows = Vec::new();
    for (actuation, side, claim, find) in CLAIMS {
        let evidence = find(&data)?;
        rows.push(ProOrCon {
            actuation: actuation.to_owned(),
            side: side.to_owned(),
            claim: claim.to_owned(),
            verdict: evidence.as_ref().map_or(Verdict::NotMeasured, |e| e.verdict),
            value: evidence.as_ref().and_then(|e| e.value),
            metric: evidence.as_ref().map(|e| e.metric.clone()),
            unit: evidence.as_ref().map(|e| e.unit.clone()),
            remark: evidence.map(|e| e.remark.into()),
        });
    }
    Ok(rows)
}

/// The largest force of brake and motor as used, over the power that they take at rest.
struct Efficiency {
    brake_n: f64,
    brake_v: f64,
    motor_n: f64,
    motor_v: f64,
}

impl Efficiency {
    fn of(data: &Known) -> Option<Self> {
        let motor_v = active(data.study)?.motor_max_v?;
        let brake_v = passive(data.study)?.brake_max_v?;
        let motor_n = data.calibration.motor.force_n(motor_v);
        let brake_n = data.calibration.brake.force_n(brake_v);
        Some(Self { brake_n, brake_v, motor_n, motor_v })
    }

    /// N/W of the motor and of the brake, by U² / R; none where the resistance is not known.
    fn force_per_power(&self, data: &Known) -> [Option<f64>; 2] {
        let Resistances { motor_ohm, brake_ohm } = data.study.resistances;
        let motor = (self.motor_n, self.motor_v, motor_ohm);
        let brake = (self.brake_n, self.brake_v, brake_ohm);
        [motor, brake].map(|(force_n, volts, ohm)| Some(force_n * ohm? / (volts * volts)))
    }
}

/// Names of the actuators in their order in [`Efficiency::force_per_power`].
const ACTUATORS: [&str; 2] = ["motor", "brake"];

/// What one of the two actuators gives for its power beside the other: in the trials with it alone,
/// where those of both have recorded currents; else at rest, where U² / R is what a winding takes.
fn efficiency(data: &Known, pair: [usize; 2]) -> Result<Option<Evidence>, TableError> {
    let at_rest = at_rest(data, pair)?;
    match in_trials(data, pair, at_rest.as_ref())? {
        Some(evidence) => Ok(Some(evidence)),
        None => Ok(at_rest),
    }
}

/// Commanded force over the power that trials took by their recorded currents.
fn in_trials(
    data: &Known,
    [own, other]: [usize; 2],
    at_rest: Option<&Evidence>,
) -> Result<Option<Evidence>, TableError> {
    let column = FORCE_PER_POWER;
    let (Some(mine), Some(beside)) = (alone(data, own, column)?, alone(data, other, column)?)
    else {
        return Ok(None);
    };
    let shares = if own == 0 { [mine.mean, beside.mean] } else { [beside.mean, mine.mean] };
    let took = took(data, own)?.map(|text| format!("; {text}")).unwrap_or_default();
    // `at_rest` may hold a resistance instead, in Ω.
    let rest = at_rest.filter(|e| e.unit == "N/W").and_then(|e| e.value);
    let rest = rest.map(|share| format!("; {AT_REST} {share:.2} N/W")).unwrap_or_default();
    Ok(Some(Evidence {
        metric: format!("commanded force over power, {} alone", ACTUATORS[own]),
        value: Some(mine.mean),
        unit: "N/W".to_owned(),
        remark: format!(
            "by recorded currents ({}); the {} has {:.2} N/W{took}{rest}",
            mine.words(),
            ACTUATORS[other],
            beside.mean
        ),
        verdict: Verdict::of(shares[1] > shares[0]),
    }))
}

/// The beginning of the remark on an actuator at rest.
const AT_REST: &str = "at rest, by voltage and resistance:";

/// The largest force over U² / R.
fn at_rest(data: &Known, [own, other]: [usize; 2]) -> Result<Option<Evidence>, TableError> {
    let Some(efficiency) = Efficiency::of(data) else { return Ok(None) };
    let shares = efficiency.force_per_power(data);
    let Some(motor) = shares[0] else { return Ok(None) };
    let Some(brake) = shares[1] else {
        // F R / U² of the brake set equal to the motor's, and solved for R.
        let even_ohm = motor * efficiency.brake_v * efficiency.brake_v / efficiency.brake_n;
        return Ok(Some(Evidence {
            metric: "brake's resistance from which on it gives more for its power".to_owned(),
            value: Some(even_ohm),
            unit: "Ω".to_owned(),
            remark: format!(
                "{AT_REST} the motor has {motor:.2} N/W; the brake's resistance is not known"
            ),
            verdict: Verdict::Undecided,
        }));
    };
    let shares = [motor, brake];
    let trials = took(data, own)?.map(|text| format!("; {text}")).unwrap_or_default();
    Ok(Some(Evidence {
        metric: format!("largest force over power, {}", ACTUATORS[own]),
        value: Some(shares[own]),
        unit: "N/W".to_owned(),
        remark: format!("{AT_REST} the {} has {:.2} N/W{trials}", ACTUATORS[other], shares[other]),
        verdict: Verdict::of(brake > motor),
    }))
}

/// The mean of a metric over the trials with that actuator alone.
fn alone(data: &Known, actuator: usize, column: &str) -> Result<Option<Mean>, TableError> {
    let mode = if actuator == 0 { active(data.study) } else { passive(data.study) };
    let (Some(metrics), Some(mode)) = (data.metrics, mode) else { return Ok(None) };
    Trials::of(metrics, None, &mode.id).mean(column)
}

/// What the trials with that actuator alone took: by their recorded currents, else at most.
fn took(data: &Known, actuator: usize) -> Result<Option<String>, TableError> {
    if let Some(e) = alone(data, actuator, ENERGY)? {
        return Ok(Some(format!("a trial took {:.2} J by its current ({})", e.mean, e.words())));
    }
    let most = alone(data, actuator, ENERGY_AT_MOST)?;
    Ok(most.map(|e| format!("a trial took at most {:.2} J ({})", e.mean, e.words())))
}

/// Mass of one of the two actuators against the other's, g.
fn mass(data: &Known, brake_first: bool) -> Option<Evidence> {
    let masses = data.study.masses?;
    let brake_g = masses.brake_kg * 1e3;
    let motor_g = masses.motor_kg * 1e3;
    let ((name, value), (other, beside)) = match brake_first {
        true => (("mass of the brake", brake_g), ("motor", motor_g)),
        false => (("mass of the motor", motor_g), ("brake", brake_g)),
    };
    Some(Evidence {
        metric: name.to_owned(),
        value: Some(value),
        unit: "g".to_owned(),
        remark: format!("the {other} has {beside:.0} g"),
        verdict: Verdict::of(brake_g < motor_g),
    })
}

/// The first environment that fits, and the trials in it of the mode; `None` without any.
fn trials<'a>(
    data: &Known<'a>,
    mode: Option<&Mode>,
    fits: fn(&Environment) -> bool,
) -> Result<Option<(&'a Environment, Trials<'a>)>, TableError> {
    let environment = data.study.environments.iter().find(|e| fits(e));
    let (Some(metrics), Some(mode), Some(environment)) = (data.metrics, mode, environment) else {
        return Ok(None);
    };
    let trials = Trials::of(metrics, Some(&environment.id), &mode.id);
    Ok((trials.len() > 0).then_some((environment, trials)))
}

/// Contacts with the wall and closed loops in which the brake gave more than it had got.
fn brake_never_gives(data: &Known) -> Result<Option<Evidence>, TableError> {
    let (Some(metrics), Some(mode)) = (data.metrics, passive(data.study)) else {
        return Ok(None);
    };
    let trials = Trials::of(metrics, None, &mode.id);
    let all = total(&trials, CONTACTS)? + total(&trials, LOOPS)?;
    let gave = total(&trials, CONTACTS_ACTIVE)? + total(&trials, LOOPS_ACTIVE)?;
    Ok((all > 0.0).then(|| Evidence {
        metric: "wall contacts and closed loops that gave more than they got".to_owned(),
        value: Some(gave),
        unit: "1".to_owned(),
        remark: format!("of {all:.0}, by energy observers"),
        verdict: Verdict::of(gave == 0.0),
    }))
}

fn total(trials: &Trials, column: &str) -> Result<f64, TableError> {
    let people = trials.people(column, None)?;
    Ok(people.values().flat_map(|sessions| sessions.values()).flatten().sum())
}

/// The share of the work put into a spring that comes back, and the stiffness, N/rad.
fn returned(
    data: &Known,
    mode: Option<&Mode>,
    judge: fn(f64) -> bool,
) -> Result<Option<(Evidence, f64)>, TableError> {
    let Some((environment, trials)) = trials(data, mode, a_spring)? else { return Ok(None) };
    let Some(share) = trials.mean(RETURNED)? else { return Ok(None) };
    let stiffness = trials.mean(STIFFNESS)?.map_or(f64::NAN, |stiffness| stiffness.mean);
    let evidence = Evidence {
        metric: format!("returned share of the work, {}", environment.label),
        value: Some(100.0 * share.mean),
        unit: "%".to_owned(),
        remark: share.words(),
        verdict: Verdict::of(judge(share.mean)),
    };
    Ok(Some((evidence, stiffness)))
}

fn brake_returns_nothing(data: &Known) -> Result<Option<Evidence>, TableError> {
    let evidence = returned(data, passive(data.study), |share| share <= NOTHING_RETURNED)?;
    Ok(evidence.map(|(evidence, _)| evidence))
}

fn brake_has_no_way_back(data: &Known) -> Result<Option<Evidence>, TableError> {
    let evidence = returned(data, passive(data.study), |share| share <= NOTHING_RETURNED)?;
    Ok(evidence.map(|(evidence, stiffness)| match stiffness.is_finite() {
        true => Evidence {
            remark: format!(
                "{}; compressing alone it does: {}",
                evidence.remark,
                quantity(stiffness, "N/rad", data.study.coordinate)
            ),
            ..evidence
        },
        false => evidence,
    }))
}

fn motor_returns(data: &Known) -> Result<Option<Evidence>, TableError> {
    let evidence = returned(data, active(data.study), |share| share > NOTHING_RETURNED)?;
    let limit = "it drives the lever back; no environment asked it to help a push";
    Ok(evidence.map(|(e, _)| Evidence { remark: format!("{}: {limit}", e.remark), ..e }))
}

fn motor_is_smooth(data: &Known) -> Result<Option<Evidence>, TableError> {
    let (Some(metrics), Some(mode)) = (data.metrics, active(data.study)) else { return Ok(None) };
    let (smooth, n) = Trials::of(metrics, None, &mode.id).count(STABILITY, SMOOTH)?;
    Ok((n > 0).then(|| Evidence {
        metric: "trials without fast swings".to_owned(),
        value: Some(100.0 * smooth as f64 / n as f64),
        unit: "%".to_owned(),
        remark: format!("{smooth} of {n} trials; steadiness alone, not the effort of making it so"),
        verdict: Verdict::of(smooth == n),
    }))
}

fn motor_is_weak(data: &Known) -> Result<Option<Evidence>, TableError> {
    let motor_v = active(data.study).and_then(|mode| mode.motor_max_v);
    let brake_v = passive(data.study).and_then(|mode| mode.brake_max_v);
    let (Some(motor_v), Some(brake_v)) = (motor_v, brake_v) else { return Ok(None) };
    let motor_n = data.calibration.motor.force_n(motor_v);
    let brake_n = data.calibration.brake.force_n(brake_v);
    let coordinate = data.study.coordinate;
    Ok(Some(Evidence {
        metric: "largest motor force as used".to_owned(),
        value: Some(motor_n),
        unit: "N".to_owned(),
        remark: format!(
            "the brake has {}; a finger's limit is {}",
            quantity(brake_n, "N", coordinate),
            given(data.study.control.force_limit_n, "N", coordinate)
        ),
        verdict: Verdict::of(motor_n < brake_n),
    }))
}

fn motor_passes_the_wall(data: &Known) -> Result<Option<Evidence>, TableError> {
    let motor = trials(data, active(data.study), a_wall)?;
    let motor = motor.map(|(_, trials)| trials.mean(PAST_WALL)).transpose()?.flatten();
    let brake = trials(data, passive(data.study), a_wall)?;
    let brake = brake.map(|(_, trials)| trials.mean(PAST_WALL)).transpose()?.flatten();
    let (Some(motor), Some(brake)) = (motor, brake) else { return Ok(None) };
    let coordinate = data.study.coordinate;
    let (unit, factor) = shown_unit("rad", coordinate);
    Ok(Some(Evidence {
        metric: match coordinate {
            Coordinate::Rotational => "angle past the wall".to_owned(),
            Coordinate::Linear { .. } => "way past the wall".to_owned(),
        },
        value: Some(factor * motor.mean),
        unit,
        remark: format!(
            "{}; {} with the brake",
            motor.words(),
            quantity(brake.mean, "rad", coordinate)
        ),
        verdict: Verdict::of(motor.mean > brake.mean),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::notes;
    use crate::trials::testing::{MetricsRow, metrics, row};
    use zwidth_study::{Calibration, Setup};
    use zwidth_tables::{Column, Measured, Table};

    fn study() -> Setup {
        Setup::of(&zwidth_testing::study())
    }

    fn verdicts(metrics: Option<&Measured>) -> Vec<Verdict> {
        let (study, calibration) = (study(), Calibration::thesis());
        let known = Known { study: &study, calibration: &calibration, metrics };
        pros_cons(known).unwrap().iter().map(|row| row.verdict).collect()
    }

    fn trials(past_with_motor: f64) -> Measured {
        metrics(&[
            MetricsRow { returned: Some(0.8), ..row("spring", "active") },
            row("spring", "passive"),
            MetricsRow { past_rad: Some(past_with_motor), ..row("spring_wall", "active") },
            MetricsRow { past_rad: Some(0.01), ..row("spring_wall", "passive") },
        ])
    }

    #[test]
    fn without_trials_only_masses_forces_and_resistances_are_known() {
        let found = verdicts(None);
        let known: Vec<usize> = (0..11).filter(|i| found[*i] != Verdict::NotMeasured).collect();
        assert_eq!(known, [0, 1, 7, 8, 9]);
        assert_eq!([found[0], found[7]], [Verdict::Undecided; 2]);
    }

    /// 4.16 N for 16² / 30.4 W; 13 N for 8² V² / R: the brake gives more above 2.43 Ω.
    #[test]
    fn the_brake_gives_more_for_its_power_where_its_resistance_is_high_enough() {
        let of = |motor_ohm, brake_ohm| {
            let resistances = Resistances { motor_ohm, brake_ohm };
            let (study, calibration) = (Setup { resistances, ..study() }, Calibration::thesis());
            let known = Known { study: &study, calibration: &calibration, metrics: None };
            let rows = pros_cons(known).unwrap();
            ([rows[0].verdict, rows[7].verdict], rows[7].value)
        };
        assert_eq!(of(Some(30.4), Some(20.0)).0, [Verdict::Supported; 2]);
        assert_eq!(of(Some(30.4), Some(2.0)).0, [Verdict::Contradicted; 2]);
        assert_eq!(of(None, Some(20.0)).0, [Verdict::NotMeasured; 2]);
        let (verdicts, even_ohm) = of(Some(30.4), None);
        assert_eq!(verdicts, [Verdict::Undecided; 2]);
        let calibration = Calibration::thesis();
        let motor = calibration.motor.force_n(16.0) * 30.4 / 256.0;
        let expect = motor * 64.0 / calibration.brake.force_n(8.0);
        assert!((even_ohm.unwrap() - expect).abs() < 1e-12, "{even_ohm:?}");
    }

    /// The efficiency rows of brake and motor: value, verdict, remark.
    fn efficiencies(
        motor: Option<[f64; 2]>,
        brake: Option<[f64; 2]>,
    ) -> Vec<(f64, Verdict, String)> {
        let metrics = metrics(&[
            MetricsRow { recorded: motor, ..row("spring", "active") },
            MetricsRow { recorded: brake, ..row("spring", "passive") },
        ]);
        let resistances = Resistances { motor_ohm: Some(30.4), brake_ohm: Some(20.0) };
        let (study, calibration) = (Setup { resistances, ..study() }, Calibration::thesis());
        let known = Known { study: &study, calibration: &calibration, metrics: Some(&metrics) };
        let rows = pros_cons(known).unwrap();
        let of = |row: &ProOrCon| {
            (row.value.unwrap(), row.verdict, row.remark.clone().unwrap().to_string())
        };
        [0, 7].map(|i| of(&rows[i])).to_vec()
    }

    #[test]
    fn recorded_currents_judge_efficiency_where_both_actuators_have_them() {
        let of = efficiencies(Some([2.0, 0.7]), Some([0.5, 4.0]));
        assert_eq!((of[0].0, of[0].1), (4.0, Verdict::Supported));
        assert_eq!((of[1].0, of[1].1), (0.7, Verdict::Supported));
        assert!(
            of[1].2.contains("the brake has 4.00 N/W; a trial took 2.00 J by its current"),
            "{of:?}"
        );
        let worse = efficiencies(Some([2.0, 0.7]), Some([0.5, 0.3]));
        assert_eq!(worse[0].1, Verdict::Contradicted);
    }

    #[test]
    fn where_one_actuator_has_no_recorded_current_both_are_judged_at_rest() {
        let of = efficiencies(Some([2.0, 0.7]), None);
        assert_eq!(of[1].1, Verdict::Supported);
        assert!(of[1].2.starts_with("at rest, by voltage and resistance: the brake has"), "{of:?}");
        assert!(of[1].2.contains("a trial took 2.00 J by its current (one trial)"), "{of:?}");
        assert!(of[0].2.contains("a trial took at most 1.50 J (one trial)"), "{of:?}");
    }

    #[test]
    fn a_contact_in_which_the_brake_gave_contradicts_that_it_is_safe() {
        let trials = trials(0.2);
        assert_eq!(verdicts(Some(&trials))[2], Verdict::Supported);
        let table = trials.table();
        let columns = table.columns().iter().map(|column| {
            let field = &column.field;
            match field.name.as_ref() {
                "wall_contacts_active" => {
                    Column::integer("wall_contacts_active", "1", "", vec![Some(1); table.height()])
                }
                _ => column.clone(),
            }
        });
        let table = Table::new("metrics", "", columns.collect()).unwrap();
        let gave = Measured::of(table).unwrap();
        assert_eq!(verdicts(Some(&gave))[2], Verdict::Contradicted);
    }

    #[test]
    fn what_the_trials_show_supports_or_contradicts() {
        let supported = verdicts(Some(&trials(0.2)));
        assert!(
            supported.iter().filter(|v| **v == Verdict::Supported).count() == 9,
            "{supported:?}"
        );
        assert_eq!(
            verdicts(Some(&trials(0.005)))[10],
            Verdict::Contradicted,
            "a motor that holds the wall"
        );
        let weak = metrics(&[MetricsRow { returned: Some(0.5), ..row("spring", "passive") }]);
        assert_eq!(verdicts(Some(&weak))[3], Verdict::Contradicted, "a brake that gives work back");
    }

    #[test]
    fn simulated_trials_and_a_single_participant_are_named_in_the_notes() {
        let (study, calibration) = (study(), Calibration::thesis());
        let of = |source, participants: [&'static str; 2]| {
            let rows = participants.map(|participant| MetricsRow {
                source,
                participant,
                ..row("spring", "active")
            });
            let metrics = metrics(&rows);
            let known = Known { study: &study, calibration: &calibration, metrics: Some(&metrics) };
            notes(known.metrics).join(" ")
        };
        assert!(of("twin", ["P01", "P01"]).contains("simulated"));
        assert!(of("recorded", ["P01", "P01"]).contains("one participant, P01"));
        assert_eq!(of("recorded", ["P01", "P02"]), "");
    }
}
