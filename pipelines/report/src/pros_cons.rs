//! The thesis' Table 1: pros and cons of brake and motor, each beside the study's own evidence.

use crate::columns::{
    CONTACTS, CONTACTS_ACTIVE, ENERGY, ENERGY_AT_MOST, FORCE_PER_POWER, LOOPS, LOOPS_ACTIVE,
    PAST_WALL, RETURNED, SMOOTH, STABILITY, STIFFNESS,
};
use crate::evidence::{Known, NOTHING_RETURNED, Place, Verdict, with_law};
use crate::trials::{Mean, Trials};
use zwidth_results::ProOrCon;
use zwidth_study::{Coordinate, Environment, ModeLaw, Resistances};
use zwidth_tables::{TableError, given, quantity, shown_unit};

/// What speaks for or against a claim.
struct Evidence {
    metric: String,
    value: f64,
    unit: String,
    remark: String,
    verdict: Verdict,
}

/// The evidence for a claim, if the study has any.
type Outcome = Result<Option<Evidence>, TableError>;

/// Finds the evidence for a claim.
type Find = fn(&Known) -> Outcome;

/// Actuation, side, claim (thesis Table 1), and where the study's evidence comes from.
const CLAIMS: [(&str, &str, &str, Find); 11] = [
    ("passive", "pro", "High force to energy consumption ratio", |data| efficiency(data, BRAKE)),
    ("passive", "pro", "Lightweight", |data| Ok(mass(data, BRAKE))),
    ("passive", "pro", "Safe", brake_never_gives),
    ("passive", "con", "Only resistive forces", |data| {
        returned(data, ModeLaw::Passive, |_, _| Ok(String::new()))
    }),
    ("passive", "con", "Can not render stiffness", |data| {
        returned(data, ModeLaw::Passive, stiffness_of_the_way_in)
    }),
    ("active", "pro", "Easy to control", motor_is_smooth),
    ("active", "pro", "Can resist and amplify", |data| {
        returned(data, ModeLaw::Active, |_, _| Ok(NO_HELP.to_owned()))
    }),
    ("active", "con", "Low force to energy consumption ratio", |data| efficiency(data, MOTOR)),
    ("active", "con", "Heavy", |data| Ok(mass(data, MOTOR))),
    ("active", "con", "Unsafe/weak trade off", motor_is_weak),
    ("active", "con", "Can not render infinite stiffness", motor_passes_the_wall),
];

/// What the work that comes back does not show.
const NO_HELP: &str = ": it drives the lever back; no environment asked it to help a push";

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
            value: evidence.as_ref().map(|e| e.value),
            metric: evidence.as_ref().map(|e| e.metric.clone()),
            unit: evidence.as_ref().map(|e| e.unit.clone()),
            remark: evidence.map(|e| e.remark.into()),
        });
    }
    Ok(rows)
}

/// The two actuators, by their places in arrays of both.
const MOTOR: usize = 0;
const BRAKE: usize = 1;
/// Their names.
const ACTUATORS: [&str; 2] = ["motor", "brake"];

/// All trials with that actuator alone.
fn alone<'a>(data: &Known<'a>, actuator: usize) -> Option<Trials<'a>> {
    let mode = with_law(data.study, [ModeLaw::Active, ModeLaw::Passive][actuator])?;
    Some(Trials::of(data.metrics?, None, &mode.id))
}

/// The mean of a metric over the trials with that actuator alone.
fn mean_alone(data: &Known, actuator: usize, column: &str) -> Result<Option<Mean>, TableError> {
    alone(data, actuator).map_or(Ok(None), |trials| trials.mean(column))
}

/// Motor and brake as used alone.
struct Used {
    brake_n: f64,
    brake_v: f64,
    motor_n: f64,
    motor_v: f64,
}

impl Used {
    /// Their highest voltages, and the forces there.
    fn of(data: &Known) -> Option<Self> {
        let motor_v = with_law(data.study, ModeLaw::Active)?.motor_max_v?;
        let brake_v = with_law(data.study, ModeLaw::Passive)?.brake_max_v?;
        let motor_n = data.calibration.motor.force_n(motor_v);
        let brake_n = data.calibration.brake.force_n(brake_v);
        Some(Self { brake_n, brake_v, motor_n, motor_v })
    }
}

/// What one of the two actuators gives for its power beside the other: in the trials with it alone,
/// where those of both have recorded currents; else at rest, where U² / R is what a winding takes.
fn efficiency(data: &Known, own: usize) -> Outcome {
    let at_rest = at_rest(data, own)?;
    let other = 1 - own;
    let mine = mean_alone(data, own, FORCE_PER_POWER)?;
    let beside = mean_alone(data, other, FORCE_PER_POWER)?;
    let (Some(mine), Some(beside)) = (mine, beside) else { return Ok(at_rest) };
    let (motor, brake) = if own == MOTOR { (mine, beside) } else { (beside, mine) };
    let took = took(data, own)?;
    // `at_rest` may hold a resistance instead, in Ω.
    let rest = at_rest.filter(|e| e.unit == "N/W");
    let rest = rest.map(|e| format!("; {AT_REST} {:.2} N/W", e.value)).unwrap_or_default();
    Ok(Some(Evidence {
        metric: format!("commanded force over power, {} alone", ACTUATORS[own]),
        value: mine.mean,
        unit: "N/W".to_owned(),
        remark: format!(
            "by recorded currents ({}); the {} has {:.2} N/W{took}{rest}",
            mine.words(),
            ACTUATORS[other],
            beside.mean
        ),
        verdict: Verdict::of(brake.mean > motor.mean),
    }))
}

/// The beginning of the remark on an actuator at rest.
const AT_REST: &str = "at rest, by voltage and resistance:";

/// The largest force over U² / R.
fn at_rest(data: &Known, own: usize) -> Outcome {
    let Resistances { motor_ohm, brake_ohm } = data.study.resistances;
    let (Some(used), Some(motor_ohm)) = (Used::of(data), motor_ohm) else { return Ok(None) };
    let motor = used.motor_n * motor_ohm / (used.motor_v * used.motor_v);
    let Some(brake_ohm) = brake_ohm else {
        return Ok(Some(Evidence {
            metric: "brake's resistance from which on it gives more for its power".to_owned(),
            // F R / U² of the brake set equal to the motor's, and solved for R.
            value: motor * used.brake_v * used.brake_v / used.brake_n,
            unit: "Ω".to_owned(),
            remark: format!(
                "{AT_REST} the motor has {motor:.2} N/W; the brake's resistance is not known"
            ),
            verdict: Verdict::Undecided,
        }));
    };
    let brake = used.brake_n * brake_ohm / (used.brake_v * used.brake_v);
    let shares = [motor, brake];
    let other = 1 - own;
    let took = took(data, own)?;
    Ok(Some(Evidence {
        metric: format!("largest force over power, {}", ACTUATORS[own]),
        value: shares[own],
        unit: "N/W".to_owned(),
        remark: format!("{AT_REST} the {} has {:.2} N/W{took}", ACTUATORS[other], shares[other]),
        verdict: Verdict::of(brake > motor),
    }))
}

/// What the trials with that actuator alone took: by their recorded currents, else at most.
fn took(data: &Known, actuator: usize) -> Result<String, TableError> {
    if let Some(e) = mean_alone(data, actuator, ENERGY)? {
        return Ok(format!("; a trial took {:.2} J by its current ({})", e.mean, e.words()));
    }
    let most = mean_alone(data, actuator, ENERGY_AT_MOST)?;
    let most = most.map(|e| format!("; a trial took at most {:.2} J ({})", e.mean, e.words()));
    Ok(most.unwrap_or_default())
}

/// Mass of one of the two actuators against the other's, g.
fn mass(data: &Known, own: usize) -> Option<Evidence> {
    let masses = data.study.masses?;
    let grams = [masses.motor_kg * 1e3, masses.brake_kg * 1e3];
    let other = 1 - own;
    Some(Evidence {
        metric: format!("mass of the {}", ACTUATORS[own]),
        value: grams[own],
        unit: "g".to_owned(),
        remark: format!("the {} has {:.0} g", ACTUATORS[other], grams[other]),
        verdict: Verdict::of(grams[BRAKE] < grams[MOTOR]),
    })
}

/// The first environment of that kind, and the trials in it of the mode; `None` without any.
fn trials<'a>(
    data: &Known<'a>,
    law: ModeLaw,
    place: Place,
) -> Option<(&'a Environment, Trials<'a>)> {
    let environment = data.study.environments.iter().find(|e| place.fits(e))?;
    let mode = with_law(data.study, law)?;
    let trials = Trials::of(data.metrics?, Some(&environment.id), &mode.id);
    (trials.len() > 0).then_some((environment, trials))
}

/// Contacts with the wall and closed loops in which the brake gave more than it had got.
fn brake_never_gives(data: &Known) -> Outcome {
    let Some(trials) = alone(data, BRAKE) else { return Ok(None) };
    let total = |column: &str| -> Result<f64, TableError> {
        let people = trials.people(column, None)?;
        Ok(people.values().flat_map(|sessions| sessions.values()).flatten().sum())
    };
    let all = total(CONTACTS)? + total(LOOPS)?;
    let gave = total(CONTACTS_ACTIVE)? + total(LOOPS_ACTIVE)?;
    Ok((all > 0.0).then(|| Evidence {
        metric: "wall contacts and closed loops that gave more than they got".to_owned(),
        value: gave,
        unit: "1".to_owned(),
        remark: format!("of {all:.0}, by energy observers"),
        verdict: Verdict::of(gave == 0.0),
    }))
}

/// The share of the work put into a spring that comes back, of which the brake claims none and the
/// motor some; `more` is what else is to be said.
fn returned(
    data: &Known,
    law: ModeLaw,
    more: fn(&Known, &Trials) -> Result<String, TableError>,
) -> Outcome {
    let Some((environment, trials)) = trials(data, law, Place::Spring) else { return Ok(None) };
    let Some(share) = trials.mean(RETURNED)? else { return Ok(None) };
    let comes_back = share.mean > NOTHING_RETURNED;
    Ok(Some(Evidence {
        metric: format!("returned share of the work, {}", environment.label),
        value: 100.0 * share.mean,
        unit: "%".to_owned(),
        remark: share.words() + &more(data, &trials)?,
        verdict: Verdict::of(comes_back == (law == ModeLaw::Active)),
    }))
}

fn stiffness_of_the_way_in(data: &Known, trials: &Trials) -> Result<String, TableError> {
    let words = trials.mean(STIFFNESS)?.map(|stiffness| {
        let stiffness = quantity(stiffness.mean, "N/rad", data.study.coordinate);
        format!("; compressing alone it does: {stiffness}")
    });
    Ok(words.unwrap_or_default())
}

fn motor_is_smooth(data: &Known) -> Outcome {
    let Some(trials) = alone(data, MOTOR) else { return Ok(None) };
    let (smooth, n) = trials.count(STABILITY, SMOOTH)?;
    Ok((n > 0).then(|| Evidence {
        metric: "trials without fast swings".to_owned(),
        value: 100.0 * smooth as f64 / n as f64,
        unit: "%".to_owned(),
        remark: format!("{smooth} of {n} trials; steadiness alone, not the effort of making it so"),
        verdict: Verdict::of(smooth == n),
    }))
}

fn motor_is_weak(data: &Known) -> Outcome {
    let coordinate = data.study.coordinate;
    Ok(Used::of(data).map(|used| Evidence {
        metric: "largest motor force as used".to_owned(),
        value: used.motor_n,
        unit: "N".to_owned(),
        remark: format!(
            "the brake has {}; a finger's limit is {}",
            quantity(used.brake_n, "N", coordinate),
            given(data.study.control.force_limit_n, "N", coordinate)
        ),
        verdict: Verdict::of(used.motor_n < used.brake_n),
    }))
}

fn motor_passes_the_wall(data: &Known) -> Outcome {
    let past = |law| -> Result<Option<Mean>, TableError> {
        trials(data, law, Place::Wall).map_or(Ok(None), |(_, trials)| trials.mean(PAST_WALL))
    };
    let motor = past(ModeLaw::Active)?;
    let brake = past(ModeLaw::Passive)?;
    let (Some(motor), Some(brake)) = (motor, brake) else { return Ok(None) };
    let coordinate = data.study.coordinate;
    let (unit, factor) = shown_unit("rad", coordinate);
    Ok(Some(Evidence {
        metric: match coordinate {
            Coordinate::Rotational => "angle past the wall".to_owned(),
            Coordinate::Linear { .. } => "way past the wall".to_owned(),
        },
        value: factor * motor.mean,
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

    fn rows(study: &Setup, metrics: Option<&Measured>) -> Vec<ProOrCon> {
        pros_cons(Known { study, calibration: &Calibration::thesis(), metrics }).unwrap()
    }

    fn verdicts(metrics: Option<&Measured>) -> Vec<Verdict> {
        rows(&study(), metrics).iter().map(|row| row.verdict).collect()
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
            let rows = rows(&Setup { resistances, ..study() }, None);
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
        let rows = rows(&Setup { resistances, ..study() }, Some(&metrics));
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
        let columns = table.columns().iter().map(|column| match column.field.name.as_ref() {
            "wall_contacts_active" => {
                Column::integer("wall_contacts_active", "1", "", vec![Some(1); table.height()])
            }
            _ => column.clone(),
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
        let of = |source, participants: [&'static str; 2]| {
            let rows = participants.map(|participant| MetricsRow {
                source,
                participant,
                ..row("spring", "active")
            });
            notes(Some(&metrics(&rows))).join(" ")
        };
        assert!(of("twin", ["P01", "P01"]).contains("simulated"));
        assert!(of("recorded", ["P01", "P01"]).contains("one participant, P01"));
        assert_eq!(of("recorded", ["P01", "P02"]), "");
    }
}
