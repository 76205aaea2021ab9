//! Frames over lines that take their time, on a simulated clock.

use super::{environments, settings, twin};
use crate::simulated::{Bench, Trouble, Way};
use crate::{Board, Rig, Settings};
use std::sync::{Arc, Mutex};
use zwidth_device::{Clock, Device, Reading};
use zwidth_study::Voltages;

/// What was read at a tick's time, s, and how long that took, s.
struct Look {
    now_s: f64,
    took_s: f64,
    reading: Reading,
}

struct Run {
    looks: Vec<Look>,
    /// Looks without a newer answer, and pieces that were no message.
    faults: [u64; 2],
    /// What the board sent after homing, µs of its clock.
    sent_us: Vec<u64>,
}

fn micros(reading: &Reading) -> u64 {
    (reading.t_device_s.unwrap() * 1e6).round() as u64
}

/// A loop of so many ticks at a line of this baud, with a board that needs so long for an answer.
fn run(baud: u32, rate_hz: f64, thinks_s: f64, trouble: Option<Trouble>) -> Run {
    const TICKS: u32 = 500;
    let sent = Arc::new(Mutex::new(Vec::new()));
    let telling = Arc::clone(&sent);
    let board = Board::new(twin(), environments())
        .telling(move |reading| telling.lock().unwrap().push(micros(reading)));
    let mut bench: Bench = Bench::new(board, baud, baud, thinks_s);
    let settings = Settings { baud: Some(baud), ..settings() };
    let mut rig = Rig::connect(bench.wire(), settings, Vec::new()).unwrap();
    rig.home(bench.now_s()).unwrap();
    let (before, begin_s) = (rig.faults()[0], bench.now_s());
    sent.lock().unwrap().clear();
    if let Some(trouble) = trouble {
        bench.trouble(Way::ToHost, bench.said(Way::ToHost) + 100, trouble);
    }
    let mut looks = Vec::new();
    for tick in 1..=TICKS {
        let now_s = bench.wait_until(begin_s + f64::from(tick) / rate_hz);
        let reading = rig.read(now_s).unwrap();
        looks.push(Look { now_s, took_s: bench.now_s() - now_s, reading });
        let motor_v = f64::from(tick % 5);
        rig.write(bench.now_s(), Voltages { motor_v, brake_v: 0.0 }).unwrap();
    }
    let [late, damaged] = rig.faults();
    let sent_us = sent.lock().unwrap().clone();
    Run { looks, faults: [late - before, damaged], sent_us }
}

/// From the eighth look on everything that the board sent is handed out, once and in its order.
/// Before, two answers may come in one look, of which the newer counts: the loop has just begun.
fn nothing_is_lost(run: &Run) {
    let mut seen: Vec<u64> = run.looks[8..].iter().map(|look| micros(&look.reading)).collect();
    seen.dedup();
    assert!(seen.len() > run.looks.len() - 12, "{} readings", seen.len());
    assert!(run.sent_us.windows(seen.len()).any(|sent| sent == seen), "{seen:?}");
}

#[test]
fn where_an_answer_and_its_command_have_room_in_a_tick_each_reading_is_of_its_own_tick() {
    // The last is an Uno, which needs up to 1.5 ms.
    for (baud, rate_hz, thinks_s) in
        [(1_000_000, 1000.0, 0.1e-3), (500_000, 650.0, 0.1e-3), (500_000, 120.0, 1.5e-3)]
    {
        let run = run(baud, rate_hz, thinks_s, None);
        nothing_is_lost(&run);
        assert_eq!(run.faults, [0, 0], "{baud} {rate_hz}");
        for look in &run.looks {
            assert!(look.reading.angle_age_s < 1e-6, "{baud} {rate_hz}: {:?}", look.reading);
            assert!(look.took_s < 0.8 / rate_hz, "{baud} {rate_hz}: {} s", look.took_s);
        }
    }
}

#[test]
fn where_they_have_not_nothing_waits_and_each_reading_is_of_the_tick_before() {
    let run = run(500_000, 1000.0, 0.1e-3, None);
    nothing_is_lost(&run);
    assert_eq!(run.faults[1], 0);
    assert!(run.faults[0] <= 2, "{:?}", run.faults);
    for look in &run.looks[8..] {
        assert!(look.took_s < 1e-9, "{} s", look.took_s);
        assert!((look.reading.angle_age_s - 1e-3).abs() < 1e-6, "{:?}", look.reading);
    }
}

#[test]
fn at_the_highest_rate_of_a_line_nothing_piles_up() {
    // On a line that is full to its last bit nothing that once waited is worked off.
    for (rate_hz, most_ticks) in [(1500.0, 2.001), (1612.0, 3.001)] {
        let run = run(500_000, rate_hz, 0.1e-3, None);
        nothing_is_lost(&run);
        for look in &run.looks[8..] {
            assert!(look.reading.angle_age_s < most_ticks / rate_hz, "{:?}", look.reading);
        }
    }
}

#[test]
fn no_age_is_less_than_it_is() {
    for (baud, rate_hz) in [(1_000_000, 1000.0), (500_000, 1000.0), (500_000, 1612.0)] {
        let run = run(baud, rate_hz, 0.1e-3, None);
        // The twin at the board took its readings by the bench's own clock.
        for Look { now_s, took_s, reading } in &run.looks {
            let age_s = now_s + took_s - reading.t_device_s.unwrap();
            assert!(reading.angle_age_s + took_s > age_s - 1e-6, "{age_s} s: {reading:?}");
        }
    }
}

#[test]
fn an_answer_that_is_lost_costs_a_tick_and_no_more_than_the_room_that_it_has() {
    for (baud, rate_hz) in [(1_000_000, 1000.0), (500_000, 1000.0), (500_000, 120.0)] {
        let without = run(baud, rate_hz, 0.1e-3, None).faults[0];
        let run = run(baud, rate_hz, 0.1e-3, Some(Trouble::Drop));
        assert_eq!(run.faults, [without + 1, 0], "{baud} {rate_hz}");
        let took_s = run.looks[1..].iter().map(|look| look.took_s).fold(0.0, f64::max);
        assert!(took_s <= (0.8 / rate_hz).min(3.5e-3), "{baud} {rate_hz}: {took_s} s");
    }
}
