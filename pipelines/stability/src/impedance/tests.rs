//! Searches compared with known boundaries.

use super::*;
use rayon::prelude::*;
use zwidth_dynamics::{DriveMode, Pushed, PushedWall, SampledWall};
use zwidth_results::{ImpedancePoint, WallBound, ZWidth};
use zwidth_tables::Table;

/// Pushes of a device whose boundary is known; it saturates from `saturates` on.
fn device(
    boundary: f64,
    saturates: f64,
) -> impl FnMut(f64) -> Result<Pushed, zwidth_dynamics::DynamicsError> {
    move |stiffness| {
        let goes_on = stiffness > boundary;
        let swing_m = if goes_on { 1e-3 } else { 0.0 };
        Ok(Pushed { swing_m, goes_on, saturates: stiffness > saturates })
    }
}

#[test]
fn a_search_brackets_the_boundary_to_two_percent() {
    for boundary in [21.0, 651.0, 987.0, 12_000.0] {
        let found = search(device(boundary, 1e9)).unwrap();
        let (low, high) = found.bracket();
        let high = high.unwrap();
        assert!(low <= boundary && boundary <= high && high - low <= 0.02 * high, "{boundary}");
        assert_eq!(found.ending, Ending::Boundary);
        assert!(found.tried.len() < 40);
    }
}

#[test]
fn a_device_that_saturates_first_is_censored_and_one_that_never_swings_too() {
    let found = search(device(5000.0, 800.0)).unwrap();
    assert_eq!(found.ending, Ending::Saturated);
    assert!(found.bracket().0 > 800.0 && found.bracket().1.is_none());
    assert_eq!(search(device(1e9, 1e9)).unwrap().ending, Ending::Stiffest);
    let swings_at_once = search(device(1.0, 1e9)).unwrap();
    assert!(swings_at_once.bracket().1.unwrap() <= 20.0);
}

#[test]
fn repeats_widen_the_interval_and_a_triangle_has_half_its_rectangle() {
    let probes = probes(&[DriveMode::Active], &[5e-3], &[0.0, 1.0, 2.0], 2);
    let boundary = |probe: &super::Probe| match probe.damping_ns_per_m {
        b if b < 0.5 => 1000.0 + 100.0 * f64::from(probe.repeat),
        b if b < 1.5 => 500.0,
        _ => 25.0,
    };
    let searches: Vec<_> =
        probes.iter().map(|p| (*p, search(device(boundary(p), 1e9)).unwrap())).collect();
    let regions = regions(&searches);
    assert_eq!(regions.len(), 1);
    let first = regions[0].undamped().unwrap();
    assert!(first.ci_low <= 1100.0 && first.ci_high >= 1200.0);
    let [area, low, high] = regions[0].area();
    let expect = 0.5 * (1150.0 + 500.0) + 0.5 * (500.0 + 25.0);
    assert!((area / expect - 1.0).abs() < 0.03 && low < area && area < high, "{area}");
    let widths = z_widths(&regions);
    assert_eq!(widths.len(), 1);
    assert_eq!(z_widths_table(&widths).unwrap().to_rows::<ZWidth>().unwrap(), widths);
    let walls = bounds(&regions);
    assert_eq!(walls.len(), 3);
    assert_eq!(Table::of_rows(&walls).unwrap().to_rows::<WallBound>().unwrap(), walls);
}

/// The simulated device with friction, counts and a motor of 4.16 N.
fn twin(push_m: f64, count_zero: f64) -> PushedWall {
    PushedWall {
        wall: SampledWall::bare(0.09726, 2.614, 8.3e-3),
        static_n: 0.2,
        kinetic_n: 0.15,
        motor_n: 4.16,
        brake_n: 13.0,
        mode: DriveMode::Active,
        count_m: 10.13e-6,
        count_zero,
        push_m,
    }
}

/// Ticks of a push: 3.3 s.
const TICKS: usize = 400;

/// How many of so many seeds' brackets hold the boundary of the same device with its counts begun
/// at 0; the push of each repeat is off by up to 1 %.
fn held(seeds: u64) -> u64 {
    let truth = twin(5e-3, 0.0).stiffest(TICKS, 1e-3).unwrap().unwrap();
    let share = |seed: u64, k: u64| {
        let mixed = (seed * 3 + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let holds = |seed: &u64| {
        let searches: Vec<_> = (0..3)
            .map(|k| {
                let push_m = 5e-3 * (0.99 + 0.02 * share(*seed, 2 * k));
                let device = twin(push_m, share(*seed, 2 * k + 1));
                let found = search(|k| device.with_stiffness(k).push(TICKS)).unwrap();
                let probe = Probe {
                    mode: DriveMode::Active,
                    push_m: 5e-3,
                    damping_ns_per_m: 0.0,
                    repeat: k as u32 + 1,
                };
                (probe, found)
            })
            .collect();
        let bound = &regions(&searches)[0].bounds[0];
        bound.ci_low <= truth && truth <= bound.ci_high
    };
    (0..seeds).into_par_iter().filter(holds).count() as u64
}

#[test]
fn brackets_of_the_simulated_device_hold_its_boundary() {
    assert!(held(20) >= 18);
}

#[test]
#[ignore = "a thousand seeds"]
fn brackets_hold_the_boundary_in_93_percent_of_a_thousand_seeds() {
    let held = held(1000);
    println!("{held} of 1000 brackets hold the boundary");
    assert!(held >= 930, "{held}");
}

#[test]
fn a_response_has_a_row_a_frequency_and_no_interval_where_nothing_is_coherent() {
    let t_s: Vec<f64> = (0..3000).map(|i| f64::from(i) / 80.0).collect();
    let theta: Vec<f64> = t_s.iter().map(|t| libm::sin(t * t)).collect();
    let of = |force: &[f64]| {
        let recording =
            Recording { t_s: &t_s, theta_rad: &theta, force_n: force, force_age_s: None };
        response(&[recording], 0.045, 0.95).unwrap().unwrap()
    };
    let (spring, none) = (of(&theta), of(&vec![0.0; t_s.len()]));
    let rows = spring.points.len();
    let both = [
        impedance_points("spring", "active", &spring),
        impedance_points("spring", "passive", &none),
    ]
    .concat();
    assert_eq!(both.len(), 2 * rows);
    assert!(both[0].ci_high.is_some() && both[rows].ci_high.is_none(), "{:?}", both[rows]);
    assert_eq!(Table::of_rows(&both).unwrap().to_rows::<ImpedancePoint>().unwrap(), both);
}
