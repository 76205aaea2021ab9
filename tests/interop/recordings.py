"""Recordings made by others: our numbers against NumPy, SciPy and statsmodels on the Parquet files.

`paddle` and `questionnaire` compute again what `zwidth compare` says of them, from the original files.
"""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import curve_fit

import definitions
import folders
import paddle
import questionnaire
import results
from checks import check, close, equal, run
from definitions import half_width, robust

# The study's lever is 1 m: N/rad are N/m.
PER_MM = 1e3
# `analysis` of studies/tsa/study.toml: its own, and the program's defaults for a device that slides; m/s, m.
TSA_ONSET, TSA_OFFSET, TSA_PAST_REST, TSA_POINTS = 5e-3, 2.5e-3, 0.5e-3, 401
# That of studies/ethz_plant/study.toml, rad/s.
PLANT_ONSET = np.radians(6.0)
# Current (A) on drive voltage (V) as published, and torque of the shaft on current, the ratio of the file's own columns.
MOTOR_LINE, TORQUE_CONSTANT = (-0.42852, 1.06768), 53.8e-3
# To what two programs must agree, relative to the number.
AGREEMENT = 1e-6


def all_sets(zwidth, real, mappings):
    """Imports, runs and checks every set."""
    comparisons = {"ethz": paddle.check_compared, "likert_vr_shoes": questionnaire.check_compared}
    for name, maps, checks in [
        ("ethz", ethz_files(real / "ethz_haptic_paddle"), ethz),
        ("ethz_plant", {"map.toml": [real / "ethz_haptic_paddle/plant/position_time_sinusoid.csv"]}, plant),
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
            if name in comparisons:
                comparisons[name](zwidth, root, real)


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


def agree(label, row, stem, fit, i, factor=1.0, relative=1e-7):
    """Estimate, standard error and interval of one coefficient, in the columns `<quantity>…_<unit>`."""
    quantity, unit = stem
    half = half_width(fit.bse[i])
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


def plant(root, real):
    """Offset, inertia, damping, dry friction and stiffness with their intervals, from the recording itself."""
    rows = table(root, "ethz_plant", "plant")
    equal("ethz_plant: fits", len(rows), 1)
    d = pd.read_csv(real / "ethz_haptic_paddle/plant/position_time_sinusoid.csv")
    t, theta = d["time_s"].to_numpy(), np.radians(d["paddle_pos_deg"].to_numpy())
    # A positive current turns the paddle to negative angles.
    torque = -TORQUE_CONSTANT * np.polyval(MOTOR_LINE, d["motor_input_V"].to_numpy())
    fit = definitions.plant(t, theta, np.gradient(theta, t), torque, PLANT_ONSET)
    row = rows.iloc[0]
    for i, quantity in enumerate([("offset", "nm"), ("inertia", "kg_m2"), ("damping", "nm_s_per_rad"), ("friction", "nm"), ("stiffness", "nm_per_rad")]):
        agree("ethz_plant", row, quantity, fit, i, relative=AGREEMENT)
    equal("ethz_plant: stretches", int(row["samples"]), int(fit.nobs))
    close("ethz_plant: R²", row["r2"], fit.rsquared, AGREEMENT)
    close("ethz_plant: RMS", row["rms_nm"], np.sqrt(np.mean(fit.resid**2)), AGREEMENT)
    breakaway(real / "ethz_haptic_paddle/stiction", row)


def breakaway(folder, row):
    """What the stiction runs say of the same motor: the drive is off by half of what the two ways differ, and slipping takes
    less than breaking away."""
    last = lambda way: np.mean([pd.read_csv(f)["motor_current_A"].iloc[-1] for f in sorted(folder.glob(f"*_{way}*.csv"))])
    negative, positive = TORQUE_CONSTANT * last("ccw"), -TORQUE_CONSTANT * last("cw")
    offset, static = (positive - negative) / 2, (positive + negative) / 2
    within = abs(row["offset_nm"] - offset) < 0.2 * offset
    check("ethz_plant: offset beside that of the stiction runs, to a fifth", within, (row["offset_nm"], offset))
    check("ethz_plant: slipping takes less torque than breaking away", row["friction_nm"] < static, (row["friction_nm"], static))


def tsa(root, real):
    """Discrepancy and stiffness with their intervals, from the recordings themselves."""
    metrics = table(root, "tsa", "metrics").set_index("trial")
    files = sorted((real / "tsa_virtual_spring").glob("K_*.csv"))
    equal("tsa: trials", len(metrics), len(files))
    for trial, file in enumerate(files, start=1):
        d = pd.read_csv(file)
        t, x = d["t_s_inferred"].to_numpy(), d["x_measured_mm"].to_numpy() / PER_MM
        f, command = -d["force_measured_N"].to_numpy(), -d["force_desired_N"].to_numpy()
        first, turn, last = definitions.phases(x, np.gradient(x, t), TSA_ONSET, TSA_OFFSET)
        row, label = metrics.loc[trial], f"tsa {file.stem}"
        for name, i in [("onset_s", first), ("reversal_s", turn)]:
            equal(f"{label}: {name}", row[name], t[i])
        expect = definitions.discrepancy(x, f, first, turn, last, TSA_POINTS, lever=1.0)
        expect |= definitions.spring(x, f, command, first, turn, last, rest=0.0, past_rest=TSA_PAST_REST)
        same(label, row, expect)
        commanded = PER_MM * float(file.stem.removeprefix("K_"))
        error = expect["stiffness"][0] - commanded
        close(f"{label}: error of the stiffness", row["stiffness_error_n_per_rad"], error, AGREEMENT)


UNITS = {
    "discrepancy_user_mean": "_n",
    "discrepancy_user_max": "_n",
    "discrepancy_user_step": "_n",
    "loop_area": "_j",
    "stiffness": "_n_per_rad",
    "stiffness_std_error": "_n_per_rad",
    "force_at_rest": "_n",
    "force_rms_error": "_n",
}


def same(label, row, expect):
    """Each quantity of a row of the metrics, and the ends of its interval where it has one."""
    for quantity, values in expect.items():
        for part, value in zip(["", "_ci_low", "_ci_high"], values):
            found = row[f"{quantity}{part}{UNITS.get(quantity, '')}"]
            close(f"{label}: {quantity}{part}", found, value, AGREEMENT)


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

