//! How long a step of QUEST+ takes: from an answer to the next level, median and 95 % of many, for grids of common size and
//! for the largest. `cargo run --release -p zwidth-stats --example quest_step`
#![allow(clippy::print_stdout)] // it is run by hand

use std::time::Instant;
use zwidth_stats::StatsError;
use zwidth_stats::psychometric::quest::{Plan, Quest};
use zwidth_stats::psychometric::{Asks, Sigmoid};

/// Answers of a session.
const ANSWERS: usize = 200;

fn main() -> Result<(), StatsError> {
    println!(
        "{:>7}{:>8}{:>12}{:>12}{:>12}{:>12}",
        "levels", "curves", "begin, ms", "median, ms", "95 %, ms", "most, ms"
    );
    for [levels, thresholds, scales, lapses] in
        [[15, 21, 9, 1], [25, 41, 12, 3], [40, 60, 20, 4], [100, 100, 40, 5], [200, 250, 40, 5]]
    {
        let begun = Instant::now();
        let mut quest = Quest::new(&plan(levels, thresholds, scales, lapses))?;
        let begin_ms = begun.elapsed().as_secs_f64() * 1e3;
        let mut steps_ms = Vec::new();
        for answer in 0..ANSWERS {
            let begun = Instant::now();
            let place = quest.place_of(quest.next_level()).unwrap_or_default();
            // Two of three, so that the posterior moves.
            quest.answer(place, answer % 3 > 0)?;
            steps_ms.push(begun.elapsed().as_secs_f64() * 1e3);
        }
        steps_ms.sort_by(f64::total_cmp);
        let at = |share: f64| steps_ms[((ANSWERS - 1) as f64 * share).round() as usize];
        println!(
            "{levels:>7}{:>8}{begin_ms:>12.2}{:>12.3}{:>12.3}{:>12.3}",
            thresholds * scales * lapses,
            at(0.5),
            at(0.95),
            at(1.0)
        );
    }
    Ok(())
}

/// A grid of so many numbers on each axis.
fn plan(levels: usize, thresholds: usize, scales: usize, lapses: usize) -> Plan {
    let axis = |n: usize, from: f64, to: f64| -> Vec<f64> {
        let step = (to - from) / n as f64;
        (0..n).map(|i| from + step * i as f64).collect()
    };
    Plan {
        asks: Asks::WhichWasMore,
        sigmoid: Sigmoid::Norm,
        levels: axis(levels, 2.0, 6.0),
        thresholds: axis(thresholds, 3.0, 5.0),
        scales: axis(scales, 0.1, 2.0),
        lapses: axis(lapses, 0.0, 0.06),
    }
}
