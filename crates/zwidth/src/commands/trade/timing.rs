//! How long runs take on this machine. These numbers are not repeatable, and are kept apart from
//! those that are.

use std::hint::black_box;
use std::time::Instant;
use zwidth_dynamics::{Grid, System};
use zwidth_numerics::order::{median, sorted};
use zwidth_results::{Row, RunTime};
use zwidth_tables::Table;
use zwidth_trade::{Cell, Trade};

/// Times a setting is run, and the ranks, from 0, of the ends of the median's interval: of 15 the
/// 4th and the 12th hold it with 96.5 %, of 6 the first and the last with 96.9 % (binomial, p =
/// 1/2).
const OF_SHORT: (usize, [usize; 2]) = (15, [3, 11]);
const OF_LONG: (usize, [usize; 2]) = (6, [0, 5]);
/// A run that takes longer is a long one: what disturbs it is short beside it, s.
const LONG_S: f64 = 2e-3;
/// Settings with more work are not timed: some milliseconds a run.
const MOST_WORK: u64 = 200_000;

/// Median time of a run with its interval, and per simulated second, for every setting that does
/// not take long.
pub(super) fn table(trade: &Trade) -> anyhow::Result<Table> {
    let system = System::new(trade.scene.clone())?;
    let cells = trade.cells.iter();
    let short = cells.filter(|cell| cell.errors.is_some() && cell.evaluations <= MOST_WORK);
    let rows = short.map(|cell| {
        let [median_s, low_s, high_s] = time_s(cell, trade, &system);
        RunTime {
            solver: cell.setting.solver.into(),
            step_s: cell.setting.step_s(),
            tolerance: cell.setting.tolerance(),
            work: cell.evaluations,
            time_s: median_s,
            time_low_s: low_s,
            time_high_s: high_s,
            time_share: median_s / trade.scene.duration_s,
        }
    });
    let rows: Vec<RunTime> = rows.collect();
    let title = format!("{}: {}", trade.scene.name, RunTime::TITLE);
    let table = Table::of_rows(&rows)?.called(RunTime::NAME, title);
    Ok(table
        .with_note("Measured on the machine that made it, one run at a time; another run gives other numbers.")
        .with_note(
            "Median of 15 runs, with the 4th and the 12th as its 96.5 % interval; of 6 where one \
             takes more than 2 ms, with the first and the last as its 96.9 % interval.",
        ))
}

/// The median and the ends of its interval, s.
fn time_s(cell: &Cell, trade: &Trade, system: &System) -> [f64; 3] {
    let solver = cell.setting.solver();
    let step_s = cell.setting.step_s().unwrap_or(trade.scene.step_s);
    let grid = Grid::filling(trade.scene.duration_s, step_s);
    let once = || {
        let start = Instant::now();
        let run = solver.run(black_box(system), &grid);
        let time_s = start.elapsed().as_secs_f64();
        // Outside of the time, and not optimised away.
        drop(black_box(run));
        time_s
    };
    let (runs, [low, high]) = if once() < LONG_S { OF_SHORT } else { OF_LONG }; // it warms up, too
    let times = sorted((0..runs).map(|_| once()));
    [median(times.iter().copied()).unwrap_or(f64::NAN), times[low], times[high]]
}
