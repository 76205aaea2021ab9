"""Recordings made by others: our numbers against NumPy, SciPy and statsmodels on the Parquet files."""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import statsmodels.api as sm
from scipy.optimize import curve_fit
from scipy.stats import t as student

import folders
import results
from checks import close, equal, run

# The study's lever is 1 m: N/rad are N/m.
PER_MM = 1e3
# The interval of a fit to one recording: Newey–West with a tenth of it as lags, Student's t with 9 degrees of freedom.
LAGS_SHARE = 10
DEGREES = 9


def all_sets(zwidth, real, mappings):
    """Imports, runs and checks every set."""
    for name, maps, checks in [
        ("ethz", ethz_files(real / "ethz_haptic_paddle"), ethz),
        ("tsa", {"map.toml": sorted((real / "tsa_virtual_spring").glob("*.csv"))}, tsa),
        ("brake_b5zd", {"map.toml": [real / "brake_b5zd/test_rig_treadmill.csv"]}, brake),
        ("likert_vr_shoes", {"map.toml": [real / "likert_vr_shoes/UXdata2023-04-28.csv"]}, shoes),
    ]:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            raw = root / "raw" / name
            raw.mkdir(parents=True)
            (raw / "study.toml").write_bytes((mappings / name / "study.toml").read_bytes())
            for mapping, files in maps.items():
                run(zwidth, "--root", root, "import", name, "--map", mappings / name / mapping, *files)
            run(zwidth, "--root", root, "run", name, "--quiet")
            folders.study(zwidth, root, name)
            results.tables(name, root / "reports" / name / "tables")
            results.figures(name, root / "reports" / name / "figures", synthetic=False)
            checks(root, real)


def ethz_files(folder):
    """The paddle's recordings, by mapping."""
    return {
        "map-transparency.toml": sorted((folder / "transparency").glob("*/*.csv")),
        "map-motor.toml": [folder / "motor/motor_voltage_current_torque.csv"],
        "map-load-cell.toml": [folder / "force_sensor/transfer_function_put_together.csv"],
    }


def table(root, study, name):
    """A printed table, from its CSV."""
    return pd.read_csv(root / "reports" / study / "tables" / f"{name}.csv", float_precision="round_trip")


def robust(y, *columns):
    """Least squares with Newey–West standard errors: the fit of statsmodels."""
    x = np.column_stack([np.ones(len(y)), *columns])
    return sm.OLS(y, x).fit(cov_type="HAC", cov_kwds={"maxlags": len(y) // LAGS_SHARE})


def agree(label, row, stem, fit, i, factor=1.0, relative=1e-7):
    """Estimate, standard error and interval of one coefficient, in the columns `<quantity>…_<unit>`."""
    quantity, unit = stem
    half = student.ppf(0.975, DEGREES) * fit.bse[i]
    for part, expect in [
        ("", fit.params[i]),
        ("_std_error", fit.bse[i]),
        ("_ci_low", fit.params[i] - half),
        ("_ci_high", fit.params[i] + half),
    ]:
        close(f"{label}: {quantity}{part}", row[f"{quantity}{part}_{unit}"], factor * expect, relative)


def ethz(root, real):
    """Plane fits, motor, load cell."""
    fits = table(root, "ethz", "free_motion").set_index(["session", "trial"])
    equal("ethz: plane fits", len(fits), 12)
    frame = pd.read_parquet(root / "raw/ethz/trials")
    for (session, trial), d in frame.groupby(["session", "trial"], observed=True):
        d = d.sort_values("t_s")
        fit = robust(d["torque_ex_nm"].to_numpy(), d["theta_ddot_rad_s2"].to_numpy(), d["theta_dot_rad_s"].to_numpy())
        row, label = fits.loc[(session, trial)], f"ethz {session} trial {trial}"
        agree(label, row, ("offset", "nm"), fit, 0)
        agree(label, row, ("inertia", "kg_m2"), fit, 1)
        agree(label, row, ("damping", "nm_s_per_rad"), fit, 2)
        close(f"{label}: R²", row["r2"], fit.rsquared, 1e-9)
    for actuator in ["motor", "load_cell"]:
        sweep = pd.read_parquet(root / f"raw/ethz/sweeps/actuator={actuator}")
        slope, offset = np.polyfit(sweep["command"], sweep["response"], 1)
        line = table(root, "ethz", f"parameters.{actuator}").query("model == 'line'").set_index("parameter")["estimate"]
        close(f"ethz: slope of the {actuator}", line["b"], slope, 1e-9)
        close(f"ethz: offset of the {actuator}", line["a"], offset, 1e-9)
    raw = pd.read_csv(real / "ethz_haptic_paddle/force_sensor/transfer_function_put_together.csv", nrows=1414)
    masses = [float(c.removeprefix("kg_")) for c in raw.columns]
    slope, offset = np.polyfit(raw.mean().to_numpy(), 9.81 * np.array(masses), 1)
    line = table(root, "ethz", "parameters.load_cell").query("model == 'line'").set_index("parameter")["estimate"]
    close("ethz: slope of the load cell, from the recording itself", line["b"], slope, 1e-9)
    close("ethz: offset of the load cell, from the recording itself", line["a"], offset, 1e-9)


def tsa(root, real):
    """Stiffness by a line through the rows up to the largest x, with x > 0.5 mm."""
    metrics = table(root, "tsa", "metrics").set_index("trial")
    frame = pd.read_parquet(root / "raw/tsa/trials")
    for trial, d in frame.groupby("trial"):
        d = d.sort_values("t_s").reset_index(drop=True)
        press = d.loc[: d["theta_rad"].idxmax()]
        press = press[press["theta_rad"] > 0.5 / PER_MM]
        fit = robust(press["force_ex_n"].to_numpy(), press["theta_rad"].to_numpy())
        row, label = metrics.loc[trial], f"tsa trial {trial}"
        agree(label, row, ("stiffness", "n_per_rad"), fit, 1)
        equal(f"{label}: samples of the fit", int(row["stiffness_samples"]), len(press))
        close(f"{label}: force at rest", row["force_at_rest_n"], fit.params[0], 1e-7)
        raw = np.polyfit(*from_csv(real / "tsa_virtual_spring", trial), 1)
        close(f"{label}: stiffness from the recording itself, N/mm", row["stiffness_n_per_rad"] / PER_MM, raw[0], 1e-9)


def from_csv(folder, trial):
    """x (mm) and resisting force (N) of a trial's press, straight from the recording; trials follow the files' order."""
    d = pd.read_csv(sorted(folder.glob("K_*.csv"))[trial - 1])
    press = d.loc[: d["x_measured_mm"].idxmax()]
    press = press[press["x_measured_mm"] > 0.5]
    return press["x_measured_mm"], -press["force_measured_N"]


def brake(root, _):
    """RMS of a line, and of SciPy's power law above a break."""
    d = pd.read_parquet(root / "raw/brake_b5zd/sweeps")
    x, y = d["command"].to_numpy(), d["response"].to_numpy()
    models = table(root, "brake_b5zd", "characteristic.brake").set_index("model")
    rms = lambda residual: float(np.sqrt(np.mean(residual**2)))
    close("brake: RMS of the line", models.loc["line", "rms"], rms(y - np.polyval(np.polyfit(x, y, 1), x)), 1e-9)
    law = lambda v, a, b, x0, p: a + b * np.clip(v / 1e4 - x0, 0, None) ** p
    best, _ = curve_fit(law, x, y, p0=[0, 10, 0.1, 1.7], maxfev=20000)
    close("brake: RMS of the power law", models.loc["power_law", "rms"], rms(y - law(x, *best)), 1e-3)
    power = table(root, "brake_b5zd", "parameters.brake").query("model == 'power_law'").set_index("parameter")["estimate"]
    close("brake: exponent of the power law", power["p"], best[3], 0.02)


def shoes(root, real):
    """Every item under every condition, counted from the two files of the questionnaire."""
    folder = real / "likert_vr_shoes"
    answers = pd.read_csv(folder / "UXdata2023-04-28.csv", sep=";")
    questions = pd.read_csv(folder / "UXdata_questions2023-04-17.csv", sep=";").query("ToBeInverted != -2")
    tally = table(root, "likert_vr_shoes", "likert").dropna(subset="question")
    counts = tally.set_index(["question", "mode"])[[f"count_{k}" for k in range(1, 6)]]
    equal("shoes: answers", int(counts.to_numpy().sum()), 3600)
    wrong = []
    for i, question in enumerate(questions.itertuples(), start=1):
        for mode, d in answers.groupby("VR motion used ask researcher"):
            given = d[question.Question_description]
            given = 6 - given if question.ToBeInverted == -1 else given
            expect = [int((given == k).sum()) for k in range(1, 6)]
            if counts.loc[(f"q{i:02}", mode)].tolist() != expect:
                wrong.append((i, mode))
    equal("shoes: items and conditions that are counted otherwise", wrong, [])

