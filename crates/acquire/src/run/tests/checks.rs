//! The device check if somebody is asked before each of its steps.

use super::*;
use crate::flow::EMERGENCY_STOP;
use std::cell::RefCell;
use zwidth_device::check::steps;
use zwidth_study::Check;

const MASS_KG: f64 = 0.2;
/// What the load cell shows whatever hangs on it, N.
const ALWAYS_N: f64 = 0.15;

fn asked() -> Desk {
    let mut desk = Desk::new(false);
    (desk.options.steps, desk.options.ask) = (steps(Some(MASS_KG)), true);
    desk
}

fn still() -> Mock {
    Mock::new(|_| (-std::f64::consts::FRAC_PI_4, ALWAYS_N))
}

/// What a person says at each step that is shown, one after the other; then they quit.
fn says(words: Vec<Input>) -> Somebody<impl FnMut(&View) -> Option<Input>> {
    let mut words = words.into_iter();
    somebody(move |view: &View| match view.phase {
        Shown::Step { .. } => words.next(),
        Shown::Ready => Some(Input::Quit),
        _ => None,
    })
}

fn value(checks: &[Check], name: &str) -> Option<f64> {
    checks.iter().find(|check| check.name == name).map(|check| check.value)
}

#[test]
fn steps_that_somebody_lets_begin_are_kept_with_the_session_and_the_mass_hangs_beside_the_tare() {
    let (desk, mut device) = (asked(), still());
    // The last word is for the motor and the brake: Enter alone lets nothing move.
    let words = vec![Input::Start, Input::Start, Input::Skip, Input::Start, Input::Skip];
    let shown = RefCell::new(Vec::new());
    let mut front = says(words);
    let mut seen = somebody(|view: &View| {
        shown.borrow_mut().push((view.phase.clone(), view.messages.back().cloned()));
        (front.0)(view)
    });
    desk.run(&mut device, &Unsynced, &mut seen).unwrap();
    assert!(device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
    let moves =
        |(phase, _): &&(Shown, Option<String>)| matches!(phase, Shown::Step { moves: true, .. });
    let shown = shown.borrow();
    let told: Vec<_> = shown.iter().filter(moves).map(|(_, told)| told.clone()).collect();
    assert_eq!(told, [None, Some("the lever will move: yes lets it, skip does not".to_owned())]);
    let checks = desk.data().sessions[0].record.checks.clone();
    let tare_n = value(&checks, "tare").unwrap();
    assert!((tare_n - ALWAYS_N).abs() < 1e-9, "{tare_n}");
    assert_eq!(value(&checks, "known mass"), Some(MASS_KG));
    // Nothing hung there: without the tare it would be 8 % of the mass' weight.
    assert!(value(&checks, "load cell scale").unwrap().abs() < 1e-9);
    assert_eq!([value(&checks, "stroke"), value(&checks, "motor responds")], [None, None]);
}

#[test]
fn a_yes_lets_motor_and_brake_be_switched_on() {
    let (desk, mut device) = (asked(), still());
    let words = vec![Input::Skip, Input::Skip, Input::Skip, Input::Yes];
    desk.run(&mut device, &Unsynced, &mut says(words)).unwrap();
    assert!(device.writes.iter().any(|(_, voltages)| *voltages != Voltages::OFF));
    assert!(value(&desk.data().sessions[0].record.checks, "brake responds").is_some());
}

#[test]
fn a_stop_and_a_quit_between_two_steps_leave_no_session_and_no_voltage() {
    for (last, why) in [(Input::Stop, Some(EMERGENCY_STOP)), (Input::Quit, None)] {
        let (desk, mut device) = (asked(), still());
        let words = vec![Input::Start, last.clone()];
        let outcome = desk.run(&mut device, &Unsynced, &mut says(words)).unwrap();
        assert_eq!((outcome.stopped.as_deref(), outcome.done), (why, 0), "{last:?}");
        assert!(device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
        assert_eq!(desk.data().sessions.len(), 0, "{last:?}");
    }
}
