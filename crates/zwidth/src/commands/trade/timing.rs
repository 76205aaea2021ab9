//! How long runs take on this machine. Not repeatable, and kept apart from what is.

use std::hint::black_box;
use std::time::Instant;
use zwidth_dynamics::{Grid, System};
use zwidth_tables::{Column, Table};
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
    let short = |cell: &&Cell| cell.errors.is_some() && cell.evaluations <= MOST_WORK;
    let rows: Vec<(&Cell, [f64; 3])> =
        trade.cells.iter().filter(short).map(|cell| (cell, time_s(cell, trade, &system))).collect();
    let time = |name, about, which: usize| {
        Column::float(name, "s", about, rows.iter().map(move |row| Some(row.1[which])))
    };
    let duration_s = trade.scene.duration_s;
    let columns = vec![
        Column::text(
            "solver",
            "the solver",
            rows.iter().map(|row| Some(row.0.setting.solver.to_owned())),
        ),
        Column::float("step_s", "s", "its step", rows.iter().map(|row| row.0.setting.step_s())),
        Column::float(
            "tolerance",
            "1",
            "its tolerance",
            rows.iter().map(|row| {
                let is = row.0.setting.step_s().is_none() && row.0.setting.size() > 0.0;
                is.then(|| row.0.setting.size())
            }),
        ),
        Column::integer(
            "work",
            "1",
            "its work in evaluations",
            rows.iter().map(|row| Some(row.0.evaluations as i64)),
        ),
        time("time_s", "median time of a run", 0),
        time("time_low_s", "lower end of its interval", 1),
        time("time_high_s", "upper end of it", 2),
        Column::float(
            "time_share",
            "1",
            "time of a run over the time that it simulates",
            rows.iter().map(|row| Some(row.1[0] / duration_s)),
        ),
    ];
    let table = Table::new("timing", &format!("{}: time of runs", trade.scene.name), columns)?;
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
        drop(black_box(run));
        time_s
    };
    let (runs, [low, high]) = if once() < LONG_S { OF_SHORT } else { OF_LONG }; // it warms up, too
    let mut times: Vec<f64> = (0..runs).map(|_| once()).collect();
    times.sort_by(f64::total_cmp);
    let median_s = 0.5 * (times[(runs - 1) / 2] + times[runs / 2]);
    [median_s, times[low], times[high]]
}
