//! Views for tests: a session in each of its phases.

use crate::{Cell, CheckLine, Course, Current, Phase, Point, Timing, View};
use zwidth_device::check::Step;
use zwidth_study::{AnswerScale, Kind, Voltages, template};

/// The longest question of the commented `study.toml`: the thesis' second.
pub(super) fn question() -> String {
    let text = template(&"demo".parse().unwrap());
    text.lines()
        .filter_map(|l| l.strip_prefix("text = "))
        .next_back()
        .unwrap()
        .trim_matches('"')
        .to_owned()
}

/// That question, open.
pub(super) fn asked() -> Phase {
    Phase::Question { text: question(), scale: AnswerScale::FivePoint }
}

pub(crate) fn phases() -> Vec<Phase> {
    vec![
        Phase::Check,
        Phase::Step { what: crate::step_words(Step::Load(0.2)).0, moves: false },
        Phase::Step { what: crate::step_words(Step::Actuators).0, moves: true },
        Phase::AtStop,
        Phase::Homing,
        Phase::Ready,
        Phase::Trial { t_s: 1.6, limit_s: 4.0 },
        asked(),
        Phase::Pause { left_s: 3.2, pause_s: 5.0 },
        Phase::Stopped { why: "stale angle: no new value for 50 ms; check the cable".into() },
        Phase::Done,
        Phase::Left,
    ]
}

/// A forward and backward movement against a spring, at 100 points a second, up to `end_s`.
fn course(end_s: f64) -> Vec<Point> {
    let at = |t_s: f64| {
        let turn = std::f64::consts::TAU / 4.0;
        let lift = 0.5 - 0.5 * (turn * t_s).cos();
        let theta_rad = (-45.0 + 73.0 * lift).to_radians();
        let theta_dot_rad_s = 73_f64.to_radians() * 0.5 * turn * (turn * t_s).sin();
        let (motor_v, brake_v) =
            (-8.0_f64.min(16.0 * lift), if lift > 0.98 { 8.0 } else { 3.0 * lift });
        let voltages = Some(Voltages { motor_v, brake_v });
        Point { t_s, theta_rad, theta_dot_rad_s, force_ex_n: 4.6 * lift, voltages }
    };
    (0..).map(|i| f64::from(i) * 0.01).take_while(|t| *t <= end_s).map(at).collect()
}

/// A session at its twelfth trial of 39, in a phase.
pub(super) fn view(phase: Phase, blinded: bool) -> View {
    let end_s = match phase {
        Phase::Trial { t_s, .. } => t_s,
        Phase::Check | Phase::Step { .. } | Phase::AtStop | Phase::Homing | Phase::Left => 0.0,
        _ => 3.8,
    };
    let check =
        |name: &str, value: &str, ok| CheckLine { name: name.into(), value: value.into(), ok };
    let mut view = View {
        study: "thesis-twin".into(),
        participant: "P01".into(),
        session: "S01".into(),
        device: "twin 1".into(),
        simulated: true,
        blinded,
        phase,
        trial: Some(Current {
            trial: 41,
            place: 12,
            kind: Kind::Trial,
            environment: "Spring + wall".into(),
            mode: (!blinded).then(|| "Hybrid".into()),
            repeats: Some(12),
        }),
        done: 11,
        total: 39,
        cells: cells(blinded),
        course: Course { elapsed_s: 160.0, left_s: Some(410.0) },
        theta_range_rad: (-45_f64.to_radians(), 45_f64.to_radians()),
        wall_rad: Some(26.6_f64.to_radians()),
        timing: Timing {
            rate_hz: 1000.0,
            measured_hz: 999.6,
            jitter_p50_s: 58e-6,
            jitter_p99_s: 112e-6,
            jitter_max_s: 1.34e-3,
            missed: 3,
            dropouts: 0,
        },
        checks: vec![
            check("rate against nominal", "999.8 of 1000 Hz", true),
            check("unique codes", "212 in 2 s", true),
            check("force noise", "0.012 N", true),
            check("unwrap margin", "0.02 turn", true),
            check("motor responds", "no movement at 2 V", false),
        ],
        ..View::default()
    };
    // One trial before of the same condition, a little weaker.
    view.begin_trace(Vec::new());
    for point in course(3.8) {
        let point = Point { force_ex_n: 0.8 * point.force_ex_n, ..point };
        view.trace(if blinded { hide(point) } else { point });
    }
    view.begin_trace(vec![(-45_f64.to_radians(), 0.0), (26_f64.to_radians(), 2.0)]);
    view.force_before_n = None;
    course(end_s)
        .into_iter()
        .for_each(|point| view.trace(if blinded { hide(point) } else { point }));
    for message in ["trial 10 stored: 3,941 samples", "trial 11 stored: 3,998 samples"] {
        view.say(message);
    }
    view
}

/// Two environments of three modes, with a trial in all cells but one.
fn cells(blinded: bool) -> Vec<Cell> {
    let cell = |environment: &str, mode: Option<&str>, done, of| Cell {
        environment: environment.into(),
        mode: mode.map(str::to_owned),
        done,
        of,
    };
    let environments = ["Spring", "Spring + wall"];
    if blinded {
        return environments.map(|e| cell(e, None, 2, 18)).to_vec();
    }
    let modes = ["Active", "Passive", "Hybrid"];
    let of = |e| modes.map(|mode| cell(e, Some(mode), usize::from(mode != "Hybrid"), 6));
    environments.map(of).concat()
}

fn hide(point: Point) -> Point {
    Point { voltages: None, ..point }
}
