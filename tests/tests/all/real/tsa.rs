//! A one-axis device that renders virtual springs of 0.1 … 3.5 N/mm, one press and release each.

use super::{Real, floats, labels, recordings};
use crate::folders::files;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use zwidth_store::{Signal, read_trial};

/// Newtons per metre in one N/mm; the study's lever is 1 m, so that N/rad are N/m.
const PER_MM: f64 = 1e3;

/// The stiffness commanded in each environment, N/mm.
const COMMANDED: [(&str, f64); 6] =
    [("k0_1", 0.1), ("k0_2", 0.2), ("k0_6", 0.6), ("k1", 1.0), ("k2", 2.0), ("k3_5", 3.5)];

static RUN: LazyLock<Real> = LazyLock::new(|| {
    let folder = recordings("tsa_virtual_spring");
    let real = Real::new("tsa");
    let report = real.import("map.toml", &files(&folder, "csv"));
    assert!(report.ends_with("6 files imported into study tsa: 6 trials, 1 session\n"), "{report}");
    real.run()
});

/// A column of the metrics, by environment.
fn metric(real: &Real, column: &str) -> BTreeMap<String, f64> {
    let table = real.derived("metrics.parquet");
    let environments = table.texts("environment").unwrap().into_iter().flatten();
    environments.zip(floats(&table, column)).collect()
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_rendered_stiffness_is_the_commanded_and_a_parallel_spring_in_all_six() {
    let (rendered, error) =
        (metric(&RUN, "stiffness_n_per_rad"), metric(&RUN, "stiffness_error_n_per_rad"));
    assert_eq!(rendered.len(), 6);
    for (environment, commanded) in COMMANDED {
        let excess = rendered[environment] / PER_MM - commanded;
        assert!((0.165..0.215).contains(&excess), "{environment}: {excess} N/mm");
        assert!((error[environment] / PER_MM - excess).abs() < 1e-12);
    }
}

/// Least squares on the rows up to the first largest x, with x > 0.5 mm, straight from the file.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_stiffness_is_that_of_a_line_through_the_files_own_rows() {
    let folder = recordings("tsa_virtual_spring");
    let rendered = metric(&RUN, "stiffness_n_per_rad");
    for (environment, commanded) in COMMANDED {
        let expect = slope(&folder.join(format!("K_{commanded}.csv")));
        let found = rendered[environment] / PER_MM;
        assert!((found / expect - 1.0).abs() < 1e-9, "{environment}: {found} is not {expect}");
    }
}

/// Columns: time s, x desired mm, x measured mm, force desired N, force measured N (negative for
/// positive x).
fn slope(path: &Path) -> f64 {
    let text = fs::read_to_string(path).unwrap();
    let row = |line: &str| line.split(',').map(|v| v.trim().parse().unwrap()).collect::<Vec<f64>>();
    let rows: Vec<(f64, f64)> = text.lines().skip(1).map(row).map(|v| (v[2], -v[4])).collect();
    let largest = rows.iter().map(|r| r.0).fold(f64::MIN, f64::max);
    let reversal = rows.iter().position(|r| r.0 >= largest).unwrap();
    let press: Vec<_> = rows[..=reversal].iter().filter(|r| r.0 > 0.5).collect();
    let n = press.len() as f64;
    let (x, f) = press.iter().fold((0.0, 0.0), |m, r| (m.0 + r.0 / n, m.1 + r.1 / n));
    let (xx, xf) = press
        .iter()
        .fold((0.0, 0.0), |s, r| (s.0 + (r.0 - x) * (r.0 - x), s.1 + (r.0 - x) * (r.1 - f)));
    xf / xx
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn pushing_is_positive_and_unloading_lies_below_loading() {
    for column in
        ["stiffness_n_per_rad", "discrepancy_user_mean_n", "discrepancy_user_max_n", "loop_area_j"]
    {
        for (environment, value) in metric(&RUN, column) {
            assert!(value > 0.0, "{column} of {environment}: {value}");
        }
    }
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn a_loop_figure_and_tables_in_millimetres_are_there() {
    let figure = labels(&RUN.report("figures/loops.P01.S01.svg"));
    assert!(figure.iter().any(|l| l.contains("force against displacement")), "{figure:?}");
    assert!(figure.iter().any(|l| l.contains("(mm)")), "{figure:?}");
    for name in ["metrics", "conditions"] {
        let table = fs::read_to_string(RUN.report(&format!("tables/{name}.md"))).unwrap();
        for words in ["discrepancy", "stiffness", "N/mm"] {
            assert!(table.contains(words), "{words} is not in {name}: {table}");
        }
    }
}

/// Every file begins with a desired position of some 1e-321 mm, which is dropped; what is kept of
/// the other columns has the bits of the file.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn files_with_denormals_are_read_and_every_sample_is_kept() {
    let folder = recordings("tsa_virtual_spring");
    let trials = files(&RUN.layout.trials(), "parquet");
    let recorded = files(&folder, "csv");
    assert!(recorded.iter().any(|p| fs::read_to_string(p).unwrap().contains("e-32")));
    let lines: usize =
        recorded.iter().map(|p| fs::read_to_string(p).unwrap().lines().count() - 1).sum();
    let rows: usize =
        trials.iter().map(|p| read_trial(p, [Signal::Time]).unwrap().samples.len()).sum();
    assert_eq!(rows, lines);
}
