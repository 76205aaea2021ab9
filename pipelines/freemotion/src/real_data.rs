//! The plane fits against recordings made by others; the test says so if they are missing.

use crate::fit::tests::{parameters, trial};
use crate::plane_fit;
use std::path::{Path, PathBuf};
use zwidth_store::{Signal, Trial};

/// The recordings have no time column; their rate is 200 Hz.
const RATE_HZ: f64 = 200.0;

/// Columns: torque N·m, acceleration rad/s², velocity rad/s.
fn read(path: &Path) -> Trial {
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    let column = |j: usize| rows.iter().map(|row| row[j]).collect();
    trial([
        (Signal::Time, (0..rows.len()).map(|i| i as f64 / RATE_HZ).collect()),
        (Signal::TorqueEx, column(0)),
        (Signal::ThetaDdot, column(1)),
        (Signal::ThetaDot, column(2)),
    ])
}

/// statsmodels 0.15: `OLS(torque, [1, acc, vel]).fit(cov_type="HAC", cov_kwds={"maxlags": n //
/// 10})`: file, lags, `params` and `bse`, each of the two for c, I, b.
const STATSMODELS: &str = "\
session_10/fg_compensated.csv 518 4.4965370565e-03 -8.2284411494e-04 4.8166705981e-03 1.8853467490e-04 2.3981941536e-05 6.6648967610e-04
session_10/force_feedback.csv 551 1.9148430666e-03 -4.9512075613e-04 3.1075330938e-03 5.5495066822e-04 1.7959260636e-05 4.4095328043e-04
session_10/uncontrolled.csv 510 2.6828237181e-03 -6.8402319665e-04 6.0346562125e-03 4.1132035158e-04 1.4673307783e-05 3.9011323665e-04
session_11/fg_compensated.csv 447 3.9206587527e-03 -7.7163136862e-04 3.5421839399e-03 3.6306603061e-04 2.2893495713e-05 4.4834593109e-04
session_11/force_feedback.csv 570 1.1104270072e-03 -4.7515016029e-04 2.5107762241e-03 4.6342776338e-04 1.6561044025e-05 3.7430766718e-04
session_11/uncontrolled.csv 332 2.2725644832e-03 -6.0048412736e-04 4.1070946440e-03 4.0646481049e-04 1.3991889100e-05 3.2416794620e-04
session_12/fg_compensated.csv 482 5.3110361301e-03 -8.3906562678e-04 4.4570423834e-03 1.8916919926e-04 1.2361813985e-05 3.1846522995e-04
session_12/force_feedback.csv 422 2.3015449562e-03 -5.5679454059e-04 4.5376455778e-03 3.5531304903e-04 1.1924746271e-05 3.1800228511e-04
session_12/uncontrolled.csv 383 4.7343230777e-03 -6.5016566736e-04 4.9658643733e-03 2.1444999398e-04 1.8629821394e-05 4.8759985500e-04
session_9/fg_compensated.csv 422 3.4876376467e-03 -8.1661573079e-04 5.4113636763e-03 2.2552362372e-04 4.1912043763e-05 1.0469957751e-03
session_9/force_feedback.csv 466 1.9535524949e-03 -5.4680346928e-04 4.3768408762e-03 3.4247455972e-04 1.4335986696e-05 3.6747352917e-04
session_9/uncontrolled.csv 503 2.5255333240e-03 -7.8524371513e-04 8.9581199728e-03 3.4091730696e-04 2.9302662104e-05 7.1736642525e-04
";

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn every_session_and_controller_agrees_with_statsmodels() {
    let root = PathBuf::from(
        std::env::var_os("ZWIDTH_REAL_DATA").expect("ZWIDTH_REAL_DATA names a folder"),
    );
    let folder = root.join("ethz_haptic_paddle/transparency");
    for line in STATSMODELS.lines() {
        let (file, numbers) = line.split_once(' ').unwrap();
        let (lags, expect) = numbers.split_once(' ').unwrap();
        let fit = plane_fit(&read(&folder.join(file)), &parameters()).unwrap();
        let found = [
            fit.offset_nm,
            fit.inertia_kg_m2,
            fit.damping_nm_s_per_rad,
            fit.offset_std_error_nm,
            fit.inertia_std_error_kg_m2,
            fit.damping_std_error_nm_s_per_rad,
        ];
        let expect: Vec<f64> = expect.split(' ').map(|number| number.parse().unwrap()).collect();
        assert_eq!(expect.len(), found.len(), "{file}");
        for (found, expect) in found.iter().zip(expect) {
            assert!((found / expect - 1.0).abs() < 1e-8, "{file}: {found} {expect}");
        }
        assert_eq!(fit.lags.to_string(), lags, "{file}");
    }
}
