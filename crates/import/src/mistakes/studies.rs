//! Clocks and counters of other programs, zeros of sensors, and trials that a study did not plan.

use super::super::world::{FORCE, ONE, trials_map};
use super::super::xdf::tests::steady;
use super::{Row, mapped, mapped_csv};
use std::fmt::Write as _;

/// A mapping with other keys under `[time]`.
fn timed(keys: &str) -> String {
    let force = "[[column]]\nto = \"force_ex_n\"\nfrom = \"f\"\nunit = \"N\"\n";
    trials_map(&[ONE, "[time]\n", keys, "\n", force])
}

/// Three samples at these times.
fn three(what: &'static str, keys: &str, [a, b, c]: [&str; 3]) -> Row {
    mapped_csv(what, timed(keys), format!("t,f\n{a},1.5\n{b},-2\n{c},4\n"))
}

/// What becomes of clocks and counters.
pub(super) fn clocks() -> Vec<Row> {
    let micros = "from = \"t\"\nunit = \"us\"\nzero = \"first\"";
    let seconds = "from = \"t\"\nunit = \"s\"\nzero = \"first\"";
    let counted = "rate_hz = 100.0\ncounter = \"n\"\nwrap = 16";
    let wraps = ["4294000000", "4294500000", "32704"];
    let doubled = "t,f\n0,1.5\n0,1.5\n0.5,-2\n1,4\n";
    let mut counter = String::from("n,f\n");
    for n in (0..60).filter(|n| !(30..40).contains(n)) {
        let _ = writeln!(counter, "{},{}", n % 16, n % 7);
    }
    let rows = |header: &str, first: &dyn Fn(u32) -> u32| {
        (0..100).fold(header.to_owned(), |text, i| format!("{text}{},{}\n", first(i), i % 7))
    };
    let packets = rows("n,f\n", &|i| i / 4 + u32::from(i >= 60));
    let of_8_ms = rows("time_ms,f\n", &|i| 8 * i);
    let coarse = rows("t,f\n", &|i| i / 25);
    let from_xdf = timed(&seconds.replace("\"t\"", "\"time_s\"")).replace("\"f\"", "\"load\"");
    let stream = |what, times: &dyn Fn(u32) -> f64, samples, offsets: &[(f64, f64)]| {
        mapped(what, from_xdf.clone(), "a.xdf", steady((0..samples).map(times), offsets))
    };
    let usual = [(0.0, 5.0), (1.0, 5.0), (2.0, 5.0)];
    let even = |i: u32| 0.01 * f64::from(i);
    let gap = |i: u32| 0.01 * f64::from(i) + if i >= 150 { 0.6 } else { 0.0 };
    let single = |i: u32| 0.01 * f64::from(if i < 150 { i } else { (2 * i - 150).min(i + 40) });
    let stalled = |i: u32| even(i).max(if i >= 90 { 1.7 + 1e-5 * f64::from(i) } else { 0.0 });
    // Chunks of ten, late by up to 40 ms.
    let in_chunks = |i: u32| even(i) + 0.01 * f64::from((i / 10 * 7 + i / 50) % 5);
    let stepped = |i: u32| 0.01 * f64::from(i) - if i >= 150 { 10.0 } else { 0.0 };
    vec![
        three("a counter of microseconds that starts over", micros, wraps),
        three("the same, said", &format!("{micros}\nwrap = 4294967296"), wraps),
        three(
            "the same, parted into trials there",
            &format!("{micros}\nbackwards = \"split\""),
            ["4294967290", "4294967295", "4"],
        ),
        three("clock times", seconds, ["10:00:00.0", "10:00:00.5", "10:00:01.0"]),
        three(
            "dates with times",
            seconds,
            ["2026-01-31 23:59:59", "2026-01-31 23:59:59.5", "2026-02-01 00:00:00"],
        ),
        three("durations with their unit", seconds, ["0 sec", "0.5 sec", "1 sec"]),
        three(
            "durations as pandas writes them",
            seconds,
            ["0 days 00:00:00", "0 days 00:00:00.5", "0 days 00:00:01"],
        ),
        three(
            "clock times taken for milliseconds",
            "from = \"t\"\nunit = \"ms\"",
            ["10:00:00.0", "10:00:00.5", "10:00:01.0"],
        ),
        three(
            "days, as spreadsheets count",
            "from = \"t\"\nunit = \"d\"",
            ["0", "5.787037037037037e-6", "1.1574074074074073e-5"],
        ),
        three("a clock that is set back", seconds, ["0", "0.5", "0.25"]),
        mapped_csv("each row twice", timed(seconds), doubled),
        mapped_csv("each row twice, said", timed(&format!("{seconds}\nequal = \"drop\"")), doubled),
        mapped_csv("samples that a counter passes over, said", timed(counted), &counter),
        mapped_csv(
            "samples that a counter passes over, beside rate_hz",
            timed("rate_hz = 100.0"),
            &counter,
        ),
        mapped_csv(
            "packets of four samples of which one is missing, beside rate_hz",
            timed("rate_hz = 100.0"),
            packets,
        ),
        mapped_csv("a column of times that contradicts rate_hz", timed("rate_hz = 100.0"), of_8_ms),
        mapped_csv(
            "a clock of whole seconds, made one sample of each",
            timed(&format!("{seconds}\nequal = \"drop\"")),
            coarse,
        ),
        stream("an XDF stream as it should be", &even, 300, &usual),
        stream("an XDF stream of which 0.6 s are missing", &gap, 300, &usual),
        stream(
            "an XDF stream of which every second sample is missing for a while",
            &single,
            400,
            &usual,
        ),
        stream(
            "an XDF stream whose samples were held up, and all came then",
            &stalled,
            400,
            &usual,
        ),
        stream(
            "an XDF stream whose chunks come late, each by another time",
            &in_chunks,
            400,
            &usual,
        ),
        stream(
            "an XDF stream of another rate than it says",
            &|i| 0.011 * f64::from(i),
            300,
            &usual,
        ),
        stream(
            "an XDF file with a clock offset that is off by itself",
            &even,
            300,
            &[usual[0], usual[1], usual[2], (3.0, 200_005.0)],
        ),
        stream(
            "an XDF file whose clock offsets step by 0.2 s, and its samples do not",
            &even,
            300,
            &[usual[0], usual[1], usual[2], (3.0, 5.2)],
        ),
        stream(
            "an XDF file with a clock offset that is no number",
            &even,
            300,
            &[usual[0], (1.0, f64::NAN), usual[2]],
        ),
        stream(
            "an XDF file recorded while the clock was set back by 10 s",
            &stepped,
            1000,
            &[(0.0, 5.0), (0.5, 5.0), (1.0, 5.0), (1.4, 5.0), (-8.3, 15.0), (-7.5, 15.0)],
        ),
    ]
}

/// A force that rests at 2.3 N for a second and rises then, at 25 Hz; its first value as given.
fn pushed(first: f64) -> String {
    let mut text = String::from("t,load\n");
    for i in 0..100_u32 {
        let noise = 0.01 * f64::from(i * 7 % 5) - 0.02;
        let push = 0.1 * (f64::from(i) - 25.0).max(0.0);
        let f = if i == 0 { first } else { 2.3 + noise + push };
        let _ = writeln!(text, "{},{f}", 0.04 * f64::from(i));
    }
    text
}

/// What becomes of zeros, and of sensors that rest.
pub(super) fn zeros() -> Vec<Row> {
    let load = &FORCE.replace("\"f\"", "\"load\"");
    let zeroed = |zero: &str| {
        trials_map(&[ONE, &load.replace("unit = \"N\"", &format!("unit = \"N\"\nzero = {zero}"))])
    };
    let rest = |from: f64, to: f64| zeroed(&format!("{{ from_s = {from:?}, to_s = {to:?} }}"));
    let angle = |wrap: &str| {
        let column =
            format!("[[column]]\nto = \"theta_rad\"\nfrom = \"a\"\nunit = \"deg\"\n{wrap}\n");
        trials_map(&[ONE, load, &column])
    };
    let turning = "t,load,a\n0,1.5,350\n0.5,-2,10\n1,4,30\n";
    let mut held = String::from("t,load\n");
    let mut isometric = String::from("t,load,a\n");
    for i in 0..150_u32 {
        let load = (0.09 * f64::from(i)).min(if i % 4 == 0 { 1.798 } else { 1.8 });
        let _ = writeln!(held, "{},{load}", 0.02 * f64::from(i));
        let _ = writeln!(
            isometric,
            "{},{},9.975",
            0.011 * f64::from(i) + 1e-4 * f64::from(i % 3),
            0.01 * f64::from(i)
        );
    }
    let derived = "[[column]]\nto = \"theta_dot_rad_s\"\nderive = \"derivative of theta_rad\"\n";
    vec![
        mapped_csv(
            "a first sample that is taken for the zero, and is none",
            zeroed("\"first\""),
            pushed(1.15),
        ),
        mapped_csv("a zero over a stretch at rest", rest(0.1, 0.6), pushed(1.15)),
        mapped_csv("a zero over a stretch that does not rest", rest(0.5, 2.5), pushed(2.3)),
        mapped_csv(
            "an angle that starts over at a full turn, said",
            angle("wrap = 360.0\noffset = -360.0"),
            turning,
        ),
        mapped_csv("a load that is held", trials_map(&[ONE, load]), held),
        mapped_csv("an isometric trial", angle("") + derived, isometric),
    ]
}

/// A file of a trial: a movement of so many samples at this interval in ms, and the label of each row.
fn trial(samples: u32, interval_ms: u32, label: impl Fn(u32) -> &'static str) -> Vec<u8> {
    let mut text = String::from("t,f,m\n");
    for i in 0..samples {
        let t = f64::from(i * interval_ms) * 1e-3;
        let _ = writeln!(text, "{t},{},{}", libm::sin(t + f64::from(samples)), label(i));
    }
    text.into_bytes()
}

/// What becomes of trials that are more, fewer or other than planned.
pub(super) fn plans() -> Vec<Row> {
    const NAMES: [&str; 6] = ["P1.csv", "P2.csv", "P3.csv", "P4.csv", "P5.csv", "P6.csv"];
    let labelled = "[name]\npattern = 'P(?<who>\\d)'\n[trial]\nparticipant = { name = \"who\", prefix = \"P\" }\n\
                    session = \"S01\"\nenvironment = \"spring\"\nmode = { column = \"m\" }\n";
    let several = |what, one: &str, files: Vec<Vec<u8>>| Row {
        what,
        map: trials_map(&[one, FORCE]),
        files: NAMES.into_iter().zip(files).collect(),
        is_twice: false,
        has_axes: false,
    };
    let active = |_| "active";
    let odd_one = |what, odd: Vec<u8>| {
        let usual = (0..5).map(|n| trial(100 + n, 10, active));
        several(what, labelled, usual.chain([odd]).collect())
    };
    vec![
        odd_one(
            "a label that changes just before a file ends",
            trial(100, 10, |i| if i < 95 { "active" } else { "passive" }),
        ),
        odd_one("a trial far shorter than the others", trial(15, 10, active)),
        odd_one("a trial at another rate than the others", trial(60, 20, active)),
        several(
            "more repeats than planned",
            ONE,
            vec![trial(100, 10, active), trial(101, 10, active)],
        ),
    ]
}
