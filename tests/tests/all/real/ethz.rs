//! A one-axis haptic paddle: free motion under three controllers in four sessions, a motor, a load
//! cell.

use super::{Real, close, floats, labels, parameter, recordings};
use crate::folders::files;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use zwidth_store::{Signal, read_trial};

static RUN: LazyLock<Real> = LazyLock::new(|| {
    let folder = recordings("ethz_haptic_paddle");
    let real = Real::new("ethz");
    let transparency = files(&folder.join("transparency"), "csv");
    assert_eq!(transparency.len(), 12);
    let report = real.import("map-transparency.toml", &transparency);
    assert!(
        report.ends_with("12 files imported into study ethz: 12 trials, 4 sessions\n"),
        "{report}"
    );
    real.import("map-motor.toml", &files(&folder.join("motor"), "csv"));
    real.import(
        "map-load-cell.toml",
        &[folder.join("force_sensor/transfer_function_put_together.csv")],
    );
    real.run()
});

static DRIVEN: LazyLock<Real> = LazyLock::new(|| {
    let folder = recordings("ethz_haptic_paddle");
    let real = Real::new("ethz_plant");
    real.import("map.toml", &[folder.join("plant/position_time_sinusoid.csv")]);
    real.run()
});

/// NumPy and statsmodels on the file itself (`tests/interop/definitions.py`, `plant`): estimate and
/// standard error.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_paddle_driven_by_its_motor_shows_friction_and_pull_but_no_inertia() {
    let plant = DRIVEN.derived("plant.parquet");
    for (quantity, unit, expect, std_error) in [
        ("offset", "nm", 2.5989635054e-04, 3.8164317637e-06),
        ("inertia", "kg_m2", 1.9307315634e-06, 3.9701278852e-06),
        ("damping", "nm_s_per_rad", 1.4401233712e-04, 7.8556593903e-05),
        ("friction", "nm", 7.2490067403e-04, 5.3966955310e-05),
        ("stiffness", "nm_per_rad", 1.2677575730e-03, 1.9682850355e-04),
    ] {
        close(floats(&plant, &format!("{quantity}_{unit}"))[0], expect, 1e-6 * expect);
        close(
            floats(&plant, &format!("{quantity}_std_error_{unit}"))[0],
            std_error,
            1e-6 * std_error,
        );
    }
    let summary = DRIVEN.summary();
    for unseen in ["inertia I is not identified", "damping b is not identified"] {
        assert!(summary.contains(unseen), "{unseen} is not in {summary}");
    }
    assert!(!summary.contains("friction is not identified"), "{summary}");
}

/// Half of the last digit of a number published with so many decimals.
fn half_digit(decimals: i32) -> f64 {
    0.5 * 10_f64.powi(-decimals)
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_motor_current_is_the_published_line() {
    let table = RUN.derived("characterise/parameters.motor.parquet");
    close(parameter(&table, "line", "b"), -0.42852, half_digit(5));
    close(parameter(&table, "line", "a"), 1.06768, half_digit(5));
}

/// F = 3.5855 (V − 0.118712) + 0.057404.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_load_cell_is_the_published_line() {
    let table = RUN.derived("characterise/parameters.load_cell.parquet");
    let slope = parameter(&table, "line", "b");
    close(slope, 3.5855, half_digit(4));
    close(
        parameter(&table, "line", "a") + slope * 0.118712,
        0.057404,
        half_digit(6) + 0.118712 * half_digit(4),
    );
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn twelve_plane_fits_have_intervals_and_one_figure_compares_them() {
    let fits = RUN.derived("free_motion.parquet");
    let texts = |column| fits.texts(column).unwrap().into_iter().flatten().collect::<Vec<_>>();
    let conditions: std::collections::BTreeSet<_> =
        texts("session").into_iter().zip(texts("mode")).collect();
    assert_eq!((fits.height(), conditions.len()), (12, 12));
    for (estimate, ci) in [
        ("offset_nm", ["offset_ci_low_nm", "offset_ci_high_nm"]),
        ("inertia_kg_m2", ["inertia_ci_low_kg_m2", "inertia_ci_high_kg_m2"]),
        ("damping_nm_s_per_rad", ["damping_ci_low_nm_s_per_rad", "damping_ci_high_nm_s_per_rad"]),
    ] {
        let [low, high] = ci.map(|c| floats(&fits, c));
        for (i, value) in floats(&fits, estimate).into_iter().enumerate() {
            assert!(low[i] < value && value < high[i], "{estimate} of row {i}");
        }
    }
    let figure = labels(&RUN.report("figures/free_motion.svg"));
    for word in [
        "Uncontrolled",
        "Friction and gravity compensated",
        "Force feedback",
        "S09",
        "S10",
        "S11",
        "S12",
    ] {
        assert!(figure.iter().any(|l| l.contains(word)), "{word} is not in {figure:?}");
    }
}

/// Ordinary least squares by normal equations, straight from the file, for one recording.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn a_plane_fit_is_that_of_the_normal_equations_on_the_file() {
    let folder = recordings("ethz_haptic_paddle");
    let expect = plane(&folder.join("transparency/session_11/force_feedback.csv"));
    let fits = RUN.derived("free_motion.parquet");
    let (sessions, modes) = (fits.texts("session").unwrap(), fits.texts("mode").unwrap());
    let is_it = |i: &usize| {
        sessions[*i].as_deref() == Some("S11") && modes[*i].as_deref() == Some("force_feedback")
    };
    let row = (0..12).find(is_it).unwrap();
    for (column, expect) in
        ["offset_nm", "inertia_kg_m2", "damping_nm_s_per_rad"].into_iter().zip(expect)
    {
        close(floats(&fits, column)[row], expect, 1e-9 * expect.abs());
    }
}

/// c, I and b of τ = c + I θ̈ + b θ̇ by Cramer's rule; columns torque, acceleration, velocity.
fn plane(path: &Path) -> [f64; 3] {
    let text = fs::read_to_string(path).unwrap();
    let (mut ata, mut aty) = ([[0.0; 3]; 3], [0.0; 3]);
    for line in text.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|v| v.trim().parse().unwrap()).collect();
        let x = [1.0, v[1], v[2]];
        for i in 0..3 {
            (0..3).for_each(|j| ata[i][j] += x[i] * x[j]);
            aty[i] += x[i] * v[0];
        }
    }
    let det = |m: [[f64; 3]; 3]| {
        let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    std::array::from_fn(|k| {
        let mut of_k = ata;
        (0..3).for_each(|i| of_k[i][k] = aty[i]);
        det(of_k) / det(ata)
    })
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn what_was_not_recorded_is_null_and_the_time_comes_from_the_rate() {
    for path in files(&RUN.layout.trials(), "parquet") {
        let trial = read_trial(&path, Signal::all()).unwrap();
        for lacks in [
            Signal::Theta,
            Signal::ForceEx,
            Signal::ForceCmd,
            Signal::VoltageMotor,
            Signal::StateBits,
        ] {
            assert!(trial.samples.get(lacks).is_none(), "{} of {}", lacks.name(), path.display());
        }
        let t = trial.samples.get(Signal::Time).unwrap();
        close(t[200], 1.0, 1e-12);
        assert!(trial.file["made_by_import"].contains("t_s = row / 200 Hz"), "{:?}", trial.file);
    }
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn there_is_no_average_no_angle_and_no_force_and_the_program_says_why() {
    for path in files(&RUN.layout.derived().join("average"), "parquet") {
        let average = zwidth_tables::Table::from_parquet(&path).unwrap();
        assert_eq!(average.height(), 0);
        assert!(average.notes()[0].contains("no average over time"), "{:?}", average.notes());
    }
    let summary = RUN.summary();
    assert!(summary.contains("Free motion has no average over time"), "{summary}");
    assert!(summary.contains("No lever length is known"), "{summary}");
    for session in ["S09", "S10", "S11", "S12"] {
        let figure = labels(&RUN.report(&format!("figures/modes.P01.{session}.free.svg")));
        let times = figure.iter().filter(|l| *l == "no angle was recorded").count();
        assert_eq!(times, 2, "the panel of the angle, and that of force against angle: {figure:?}");
        assert!(figure.iter().any(|l| l.contains("no average over time")), "{figure:?}");
    }
}
