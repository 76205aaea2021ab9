//! Recordings of a movement, spoilt on purpose, and answers.

use super::super::world::{ONE, column, trials_map};
use super::{LIKERT, Row, mapped_csv};
use std::fmt::Write as _;

/// There and back on the template's spring in 2 s, 500 samples a second, with every column but one
/// as it should be.
fn motion(what: &'static str, change: fn(usize, [f64; 5]) -> [f64; 5]) -> Row {
    let mut text = String::from("t,x,v,f,d\n");
    for i in 0..1000_u32 {
        let t = f64::from(i) * 2e-3;
        let (sin, cos) = libm::sincos(core::f64::consts::PI * t);
        let size = 77_f64.to_radians();
        let out = size * (1.0 - cos) / 2.0;
        let noise = f64::from(i.wrapping_mul(2_654_435_761) >> 20) * 1e-5;
        let x = out - core::f64::consts::FRAC_PI_4;
        let v = size * core::f64::consts::PI * sin / 2.0;
        let [t, x, v, f, d] = change(i as usize, [t, x, v, 4.0 * out + noise, t]);
        let _ = writeln!(text, "{t},{x},{v},{f},{d}");
    }
    let columns = [
        column("theta_rad", "x", "rad"),
        column("theta_dot_rad_s", "v", "rad/s"),
        column("force_ex_n", "f", "N"),
        column("t_device_s", "d", "s"),
    ];
    let time = "[time]\nfrom = \"t\"\nunit = \"s\"\n";
    mapped_csv(what, trials_map(&[ONE, time, &columns.concat()]), text)
}

/// A recording without its first half second.
fn begun(row: Row) -> Row {
    let shorter = |(name, bytes): (&'static str, Vec<u8>)| {
        let lines = bytes.split_inclusive(|byte| *byte == b'\n').enumerate();
        let kept = lines.filter(|(i, _)| *i == 0 || *i > 250).flat_map(|(_, line)| line);
        (name, kept.copied().collect())
    };
    Row { files: row.files.into_iter().map(shorter).collect(), ..row }
}

/// What cannot be what it says.
pub(super) fn units() -> Vec<Row> {
    vec![
        motion("a recording as it should be", |_, row| row),
        motion("degrees taken for radians", |_, [t, x, v, f, d]| [t, x.to_degrees(), v, f, d]),
        motion("degrees per second taken for radians", |_, [t, x, v, f, d]| {
            [t, x, v.to_degrees(), f, d]
        }),
        motion("revolutions per minute taken for radians per second", |_, [t, x, v, f, d]| {
            [t, x, v * 60.0 / core::f64::consts::TAU, f, d]
        }),
        motion("a velocity of the wrong sign", |_, [t, x, v, f, d]| [t, x, -v, f, d]),
        motion("milliseconds taken for seconds", |_, [t, x, v, f, d]| [1e3 * t, x, v, f, 1e3 * d]),
        motion("seconds taken for milliseconds", |_, [t, x, v, f, d]| {
            [1e-3 * t, x, v, f, 1e-3 * d]
        }),
        motion("a rate ten times too high", |_, [t, x, v, f, d]| [0.1 * t, x, v, f, 0.1 * d]),
        motion("a device's clock in another unit", |_, [t, x, v, f, d]| [t, x, v, f, 1e3 * d]),
        motion("a clock that jumps", |i, [t, x, v, f, d]| {
            if i < 700 { [t, x, v, f, d] } else { [t + 5.0, x, v, f, d + 5.0] }
        }),
        motion("an angle that starts over at 360°", |_, [t, x, v, f, d]| {
            [t, if x < 0.0 { x + core::f64::consts::TAU } else { x }, v, f, d]
        }),
        motion("a force of the wrong sign", |_, [t, x, v, f, d]| [t, x, v, -f, d]),
        motion("N·m taken for N", |_, [t, x, v, f, d]| [t, x, v, 0.045 * f, d]),
        motion("mN taken for N", |_, [t, x, v, f, d]| [t, x, v, 1e3 * f, d]),
        motion("a sensor that is not plugged in", |_, [t, x, v, _, d]| [t, x, v, 0.125, d]),
        motion("a sensor that stops", |i, [t, x, v, f, d]| {
            [t, x, v, if i < 300 { f } else { 3.25 }, d]
        }),
        motion("a sensor at the end of its range", |_, [t, x, v, f, d]| [t, x, v, f.min(4.5), d]),
        motion("a force in steps of 0.1 N", |_, [t, x, v, f, d]| {
            [t, x, v, (10.0 * f).round() / 10.0, d]
        }),
        motion("a number for a missing angle, not said", |i, [t, x, v, f, d]| {
            [t, if i == 40 { -1.73 } else { x }, v, f, d]
        }),
        motion("a number for missing forces, not said", |i, [t, x, v, f, d]| {
            [t, x, v, if (900..920).contains(&i) { -999.0 } else { f }, d]
        }),
        begun(motion("a recording that begins within its movement", |_, row| row)),
    ]
}

/// Answers to questions.
pub(super) fn answers() -> Vec<Row> {
    let likert =
        |what, answers: &str| mapped_csv(what, LIKERT.to_owned(), format!("who,mode,q\n{answers}"));
    let slider = LIKERT.replace("felt_spring", "line");
    let decimals = "who,mode,q\nP01,active,47.273\nP01,passive,100\n";
    vec![
        likert("answers on the scale", "P01,active,5\nP01,passive,1\n"),
        likert("an answer off the scale", "P01,active,6\n"),
        likert("words for answers", "P01,active,agree\n"),
        likert("half an answer", "P01,active,2.5\n"),
        mapped_csv("decimals of a slider, on a line", slider.clone(), decimals),
        mapped_csv("an answer off a line", slider, decimals.replace("47.273", "100.5")),
        likert("no answer", "P01,active,\n"),
    ]
}
