//! A magnetic-particle brake: torque against set point, a dead region and strong curvature.

use super::{Real, close, floats, labels, recordings};
use std::fs;
use std::sync::LazyLock;

static RUN: LazyLock<Real> = LazyLock::new(|| {
    let folder = recordings("brake_b5zd");
    let real = Real::new("brake_b5zd");
    let report = real.import("map.toml", &[folder.join("test_rig_treadmill.csv")]);
    assert!(report.contains("6554 rows read, 6554 kept"), "{report}");
    real.run()
});

/// Model → its RMS (mN·m) and what is said of it.
fn models(real: &Real) -> Vec<(String, f64, String)> {
    let table = real.derived("characterise/characteristic.brake.parquet");
    let texts = |column| table.texts(column).unwrap().into_iter().flatten().collect::<Vec<_>>();
    let names = texts("model").into_iter().zip(floats(&table, "rms")).zip(texts("verdict"));
    names.map(|((model, rms), verdict)| (model, rms, verdict)).collect()
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn a_line_and_a_hinge_are_rejected_and_the_power_law_is_chosen() {
    let found = models(&RUN);
    let expect =
        [("line", 3.09, "rejected"), ("hinge", 1.34, "rejected"), ("power_law", 0.33, "chosen")];
    let of = |name: &str| found.iter().find(|(model, ..)| model == name).unwrap();
    for (name, published, word) in expect {
        let (_, rms, verdict) = of(name);
        close(*rms, published, 0.005);
        assert_eq!(verdict, word, "{name}");
    }
    let chosen: Vec<_> = found.iter().filter(|(.., verdict)| verdict == "chosen").collect();
    assert_eq!(chosen, [of("power_law")]);
    assert!(of("power_law").1 <= 0.4, "RMS of the chosen model, mN·m");
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_printed_table_says_why() {
    let table = fs::read_to_string(RUN.report("tables/characteristic.brake.md")).unwrap();
    for words in [
        "RMS 3.09 mN·m is",
        "RMS 1.34 mN·m is",
        "times the noise, residual autocorrelation 0.9",
        "RMS 0.326 mN·m is 1.0 times the noise",
        "10 blocks",
        "1 sweep, 6554 points",
    ] {
        assert!(table.contains(words), "'{words}' is not in {table}");
    }
}

/// 0 … 47 mN·m over 0 … 26,212 counts, noise about 0.36 mN·m.
#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_curve_spans_the_published_torque_and_its_units_are_those_of_the_sweep() {
    let curve = RUN.derived("characterise/curve.brake.parquet");
    let command = floats(&curve, "command");
    assert_eq!((command[0], *command.last().unwrap()), (0.0, 26212.0));
    let fields: Vec<_> =
        curve.fields().filter(|f| f.name == "command").map(|f| f.unit.to_string()).collect();
    assert_eq!(fields, ["counts"]);
    let figure = labels(&RUN.report("figures/characteristic.brake.svg"));
    for unit in ["(counts)", "(mN·m)"] {
        assert!(figure.iter().any(|l| l.contains(unit)), "{figure:?}");
    }
}
