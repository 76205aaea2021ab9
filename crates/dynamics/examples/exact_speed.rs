//! Nanoseconds a sample of the exact solver, in steady state: `cargo run --release --example
//! exact_speed`.
#![allow(clippy::print_stdout, clippy::unwrap_used)]

use std::time::Instant;

use zwidth_dynamics::{
    DormandPrince, DriveMode, Exact, Grid, Input, ModelScene, Series, Solver, System, Tolerances,
    table3,
};

fn measure(name: &str, scene: ModelScene, grid: &Grid) {
    let system = System::new(scene).unwrap();
    let solver = Exact::default();
    let runs = 2_000_000 / grid.samples();
    let mut first = f64::INFINITY;
    for _ in 0..2_000 {
        let start = Instant::now();
        std::hint::black_box(solver.run(&system, grid).unwrap());
        first = first.min(start.elapsed().as_secs_f64());
    }
    let mut prepared = solver.prepare(&system, grid).unwrap();
    let mut out = solver.run(&system, grid).unwrap();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..runs {
            prepared.run_into(grid, std::hint::black_box(&mut out)).unwrap();
        }
        best = best.min(start.elapsed().as_secs_f64() / (runs * grid.samples()) as f64);
    }
    let run = solver.run(&system, grid).unwrap();
    let events = run.events.len();
    let pieces = run.work.evaluations - run.work.steps;
    let whole_us = best * grid.samples() as f64 * 1e6;
    println!(
        "{name}: {:.1} ns a sample, {whole_us:.1} us a run, {:.1} us the first; {events} events, {} regions, {pieces} pieces",
        best * 1e9,
        first * 1e6,
        run.regions.len()
    );
}

/// Whole runs of the adaptive method on the same regions, and its error against the exact one.
fn peer(tolerance: f64) {
    let system = System::new(table3::scene(DriveMode::Hybrid, Input::sine(2.15))).unwrap();
    let grid = Grid::of(&system);
    let solver = DormandPrince { tolerances: Tolerances::of(tolerance) };
    let mut best = f64::INFINITY;
    for _ in 0..200 {
        let start = Instant::now();
        std::hint::black_box(solver.run(&system, &grid).unwrap());
        best = best.min(start.elapsed().as_secs_f64());
    }
    let (run, exact) =
        (solver.run(&system, &grid).unwrap(), Exact::default().run(&system, &grid).unwrap());
    let error =
        run.theta_rad().zip(exact.theta_rad()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!(
        "dormand_prince at {tolerance:e}: {:.1} us a run, {error:.1e} rad, {} steps",
        best * 1e6,
        run.work.steps
    );
}

fn main() {
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12] {
        peer(tolerance);
    }
    let scene = || table3::scene(DriveMode::Hybrid, Input::sine(2.15));
    for (name, step_s) in [("480 of 8.3 ms", 0.008_3), ("4,000 of 1 ms", 0.001)] {
        let grid = Grid::filling(4.0, step_s);
        measure(&format!("no finger, {name}"), scene(), &grid);
        measure(&format!("finger, {name}"), table3::with_finger(scene()), &grid);
    }
    for step in [0.008_3, 0.001] {
        let n = (4.0 / step) as usize;
        let even: Vec<f64> = (0..=n).map(|i| i as f64 * step).collect();
        let uneven: Vec<f64> = (0..=n)
            .map(|i| (i as f64 + 0.3 * (i as f64 * 1.7).sin() * f64::from(u8::from(i > 0))) * step)
            .collect();
        for (name, times) in [("even", even), ("uneven", uneven)] {
            let value = times.iter().map(|t| 2.15 + 2.15 * (1.57 * t).sin()).collect();
            let input = Input::Series(Series { t_s: times.clone(), value });
            let grid = if name == "even" {
                Grid::Even { step_s: step, steps: n }
            } else {
                Grid::Times(times)
            };
            measure(
                &format!("recorded, {name}, {step}"),
                table3::scene(DriveMode::Hybrid, input.clone()),
                &grid,
            );
            let finger = table3::with_finger(table3::scene(DriveMode::Hybrid, input));
            measure(&format!("recorded, {name}, {step}, finger"), finger, &grid);
        }
    }
}
