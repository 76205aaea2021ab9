//! Recordings in several axes at the extremes: whatever was recorded, each metric is a number that can be, or null.
//!
//! A few hundred here; `cargo xtask soak extremes` asks for thousands by `ZWIDTH_EXTREMES_PATHS`.

use zwidth_metrics::{Parameters, Space, table, trial_metrics};
use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_study::Axes;

const AXES: [Signal; 6] =
    [Signal::X, Signal::Y, Signal::Z, Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// Numbers drawn from a seed (SplitMix64).
struct Drawn(u64);

impl Drawn {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.next() as usize % all.len()]
    }
}

/// A recording whose clock, places and forces are as strange as a file may have them.
fn recording(seed: u64) -> (Trial, Axes) {
    let mut drawn = Drawn(seed);
    let n = drawn.one_of(&[1, 2, 3, 5, 20, 400]);
    let step = drawn.one_of(&[1e-9, 1e-6, 1e-3, 0.01, 0.3, 1e6]);
    let mut t = Vec::new();
    let mut now = drawn.one_of(&[0.0, -5.0, 1e9]);
    for _ in 0..n {
        t.push(now);
        let gap = if drawn.share() < 0.02 { drawn.one_of(&[0.1, 3.0, 1e4]) } else { 0.0 };
        let next = now + step * (0.5 + drawn.share()) + gap;
        // Far from 0 a short step is none.
        now = if next > now { next } else { now.next_up() };
    }
    let mut samples = Samples::default();
    for signal in AXES {
        if drawn.share() < 0.15 {
            continue;
        }
        let size = drawn.one_of(&[0.0, 1e-320, 1e-12, 1e-3, 1.0, 1e5, 1e150, 1e308]);
        let middle = drawn.one_of(&[0.0, size, -size]) / 2.0;
        let is_smooth = drawn.share() < 0.5;
        let turn = drawn.share() * 3.0;
        let value = |i: usize, drawn: &mut Drawn| {
            let unit =
                if is_smooth { libm::sin(turn * i as f64) } else { 2.0 * drawn.share() - 1.0 };
            middle + size / 2.0 * unit
        };
        samples.set(signal, (0..n).map(|i| value(i, &mut drawn)).collect());
    }
    samples.set(Signal::Time, t);
    let push = drawn.one_of(&[[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.0, -1.0]]);
    let low_pass_hz = drawn.one_of(&[0.1, 1.0, 10.0, 1000.0]);
    let onset_m_s = drawn.one_of(&[1e-12, 0.01, 10.0]);
    let axes = Axes {
        frame: "x right".to_owned(),
        push,
        low_pass_hz,
        onset_m_s,
        offset_m_s: onset_m_s / 2.0,
    };
    (Trial { meta: zwidth_testing::meta(1, "hybrid"), file: TrialFile::new(), samples }, axes)
}

#[test]
fn every_metric_of_a_recording_at_the_extremes_can_be_or_is_null() {
    let all = std::env::var("ZWIDTH_EXTREMES_PATHS").ok().and_then(|n| n.parse().ok());
    let study = zwidth_testing::study();
    let mode = study.mode(&zwidth_testing::meta(1, "hybrid").mode).unwrap();
    let mut with_path = 0;
    let mut overflows = 0;
    for seed in 0..all.unwrap_or(400_u64) {
        let (trial, axes) = recording(seed);
        let parameters =
            Parameters { axes: Some(axes), ..Parameters::of(&study, &study.environments[0], mode) };
        let row = trial_metrics(&trial, &parameters).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let Space {
            path_m, distance_m, path_over_distance, completion_s, force_across_share, ..
        } = row.space;
        // A table refuses what is not finite.
        table(&[row], &[], true).unwrap_or_else(|e| panic!("recording {seed}: {e}"));
        with_path += u32::from(path_m.is_some());
        overflows += u32::from(completion_s.is_some() && path_m.is_none());
        if let (Some(path_m), Some(distance_m)) = (path_m, distance_m) {
            assert!(path_m >= distance_m * (1.0 - 1e-9), "{seed}: {path_m} {distance_m}");
        }
        assert!(path_over_distance.is_none_or(|ratio| ratio > 1.0 - 1e-9), "{seed}");
        assert!(completion_s.is_none_or(|s| s >= 0.0), "{seed}");
        assert!(
            force_across_share.is_none_or(|share| (0.0..1.0 + 1e-9).contains(&share)),
            "{seed}"
        );
    }
    assert!(with_path > 30 && overflows > 3, "{with_path} {overflows}: the extremes are not tried");
}
