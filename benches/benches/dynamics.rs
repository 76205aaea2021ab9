//! The exact solver in steady state: time a sample with and without finger, an uneven recording
//! against an even one, and a sweep on one core and on two. Throughput is in samples a second: 25
//! Melem/s are 40 ns a sample. Beside its peers: `benches/peers/run.sh`.
#![allow(missing_docs, clippy::unwrap_used)] // a bench may panic

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use zwidth_benches::sweep::sweep;
use zwidth_dynamics::{DriveMode, Exact, Grid, Input, ModelScene, Series, Solver, System, table3};

/// The grids of the stated goals: name, step in s.
const GRIDS: [(&str, f64); 2] = [("480 of 8.3 ms", 0.008_3), ("4000 of 1 ms", 0.001)];

/// Whole runs of a scene whose regions have been met before, all samples written.
fn steady(group: &mut BenchmarkGroup<'_, WallTime>, name: String, scene: ModelScene, grid: &Grid) {
    let system = System::new(scene).unwrap();
    let solver = Exact::default();
    let mut prepared = solver.prepare(&system, grid).unwrap();
    let mut out = solver.run(&system, grid).unwrap();
    group.throughput(Throughput::Elements(grid.samples() as u64));
    group.bench_function(name, |b| b.iter(|| prepared.run_into(grid, &mut out).unwrap()));
}

/// A scene and its twin with the finger.
fn both(scene: ModelScene) -> [(&'static str, ModelScene); 2] {
    [("no finger", scene.clone()), ("finger", table3::with_finger(scene))]
}

fn sine(c: &mut Criterion) {
    let mut group = c.benchmark_group("exact hybrid spring");
    for (samples, step_s) in GRIDS {
        for (finger, scene) in both(table3::scene(DriveMode::Hybrid, Input::sine(2.15))) {
            steady(&mut group, format!("{finger}, {samples}"), scene, &Grid::filling(4.0, step_s));
        }
    }
    group.finish();
}

/// A push recorded at such times.
fn recording(t_s: Vec<f64>) -> Input {
    let value = t_s.iter().map(|t| 2.15 + 2.15 * (std::f64::consts::FRAC_PI_2 * t).sin()).collect();
    Input::Series(Series { t_s, value })
}

/// Recorded on the output grid: even, and with each time moved by up to 30 % of a step.
fn recorded(c: &mut Criterion) {
    let mut group = c.benchmark_group("exact recorded push");
    for (samples, step_s) in GRIDS {
        let steps = (4.0 / step_s) as usize;
        let moved = |i: usize| i as f64 + if i == 0 { 0.0 } else { 0.3 * (i as f64 * 1.7).sin() };
        let even: Vec<f64> = (0..=steps).map(|i| i as f64 * step_s).collect();
        let uneven: Vec<f64> = (0..=steps).map(|i| moved(i) * step_s).collect();
        let grids = [
            ("even", even, Grid::Even { step_s, steps }),
            ("uneven", uneven.clone(), Grid::Times(uneven)),
        ];
        for (name, times, grid) in grids {
            for (finger, scene) in both(table3::scene(DriveMode::Hybrid, recording(times.clone())))
            {
                steady(&mut group, format!("{name}, {finger}, {samples}"), scene, &grid);
            }
        }
    }
    group.finish();
}

/// The number of trials may be set: `ZWIDTH_SWEEP=1000000 cargo bench -p zwidth-benches --bench
/// dynamics sweep`.
fn sweeps(c: &mut Criterion) {
    let trials = std::env::var("ZWIDTH_SWEEP").map_or(1_000_u32, |text| text.parse().unwrap());
    let mut group = c.benchmark_group("sweep, summaries only");
    group.sample_size(10).throughput(Throughput::Elements(u64::from(trials)));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        group.bench_function(format!("{trials} trials, {threads} threads"), |b| {
            b.iter(|| pool.install(|| sweep(trials)).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, sine, recorded, sweeps);
criterion_main!(benches);
