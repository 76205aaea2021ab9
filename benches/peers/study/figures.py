"""Every figure as SVG, PDF and PNG, with its data beside it."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import metrics
import model

COLOURS = {"active": "#0077bb", "passive": "#ee7733", "hybrid": "#009988"}
INCH = 25.4
WIDE, NARROW = 175 / INCH, 110 / INCH
DPI = 200

plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
                     "grid.color": "#e5e5e5", "grid.linewidth": 0.5, "lines.linewidth": 0.9, "pdf.fonttype": 42,
                     "legend.frameon": False, "figure.constrained_layout.use": True})


def save(figure, folder, name):
    figure.text(0.99, 0.99, "SYNTHETIC: simulated, not measured", ha="right", va="top", color="#aa2211",
                fontsize=6, weight="bold")
    for suffix in ("svg", "pdf", "png"):
        figure.savefig(folder / f"{name}.{suffix}", dpi=DPI)
    rows = []
    for panel, axes in enumerate(figure.axes):
        for layer, line in enumerate(axes.get_lines()):
            x, y = (np.asarray(v, dtype=float) for v in line.get_data())
            rows.append(pd.DataFrame({"panel": panel, "layer": layer, "name": line.get_label(), "x": x, "y": y}))
    if rows:
        pd.concat(rows, ignore_index=True).to_parquet(folder / f"{name}.parquet")
    plt.close(figure)


def dotted_past(axes, x, y, theta, wall, **style):
    """A line that is dotted where theta is past the wall."""
    past = np.zeros(len(theta), bool) if wall is None else theta >= wall
    label = style.pop("label", None)
    axes.plot(x, np.where(past, np.nan, y), label=label, **style)
    if past.any():
        axes.plot(x, np.where(past | np.roll(past, 1), y, np.nan), linestyle=":", **style)


SIGNALS = [("theta_rad", "θ (°)"), ("force_ex_n", "$F_{ex}$ (N)"), ("theta_dot_rad_s", "θ' (°/s)")]


def shown(name, values):
    return np.degrees(values) if name.startswith("theta") else np.asarray(values)


def modes_figure(folder, study, trials, averages, onsets, environment):
    figure = plt.figure(figsize=(WIDE, 125 / INCH))
    grid = figure.add_gridspec(3, 2)
    panels = [figure.add_subplot(grid[i, 0]) for i in range(3)]
    loop = figure.add_subplot(grid[:, 1])
    wall = environment["wall_rad"]
    for mode in study["modes"]:
        colour = COLOURS[mode["id"]]
        table = averages[environment["id"], mode["id"], "onset"]
        mean_theta = table.theta_mean_rad.to_numpy()
        for meta, frame in trials:
            if (meta["environment"], meta["mode"]) != (environment["id"], mode["id"]):
                continue
            t = frame.t_s - onsets[meta["trial"]]
            for axes, (name, _) in zip(panels, SIGNALS):
                axes.plot(t, shown(name, frame[name]), color=colour, alpha=0.25, linewidth=0.5)
            loop.plot(np.degrees(frame.theta_rad), frame.force_ex_n, color=colour, alpha=0.25, linewidth=0.5)
        for axes, (name, _) in zip(panels, SIGNALS):
            get = lambda what: shown(name, table[metrics.QUANTITIES[name].format(what)])
            axes.fill_between(table.t_s, get("ci_low"), get("ci_high"), color=colour, alpha=0.2, linewidth=0)
            dotted_past(axes, table.t_s, get("mean"), mean_theta, wall, color=colour, linewidth=1.6)
        dotted_past(loop, np.degrees(mean_theta), table.force_ex_mean_n, mean_theta, wall, color=colour,
                    linewidth=1.6, label=mode["label"])
    for axes, (_, label) in zip(panels, SIGNALS):
        axes.set_ylabel(label)
    panels[-1].set_xlabel("time since onset (s)")
    loop.set(xlabel="θ (°)", ylabel="$F_{ex}$ (N)")
    if wall is not None:
        panels[0].axhline(np.degrees(wall), color="k", linestyle="--", linewidth=0.6)
        loop.axvline(np.degrees(wall), color="k", linestyle="--", linewidth=0.6)
    loop.legend()
    figure.suptitle(f"{environment['label']}: mean of the repeats by mode")
    save(figure, folder, f"modes.P01.S01.{environment['id']}")


def repeats_figure(folder, trials, onsets, environment, mode):
    figure, panels = plt.subplots(1, 3, figsize=(WIDE, 68 / INCH))
    mine = [(m, f) for m, f in trials if (m["environment"], m["mode"]) == (environment["id"], mode["id"])]
    shades = matplotlib.colors.LinearSegmentedColormap.from_list("", ["#bbbbbb", COLOURS[mode["id"]]])
    for i, (meta, frame) in enumerate(mine):
        style = dict(color=shades((i + 1) / len(mine)), label=f"repeat {meta['repeat']}")
        panels[0].plot(np.degrees(frame.theta_rad), frame.force_ex_n, **style)
        t = frame.t_s - onsets[meta["trial"]]
        panels[1].plot(t, np.degrees(frame.theta_rad), **style)
        panels[2].plot(t, np.degrees(frame.theta_dot_rad_s), **style)
    furthest = max((f for _, f in mine), key=lambda f: f.theta_rad.max())
    panels[0].plot(np.degrees(furthest.theta_rad), furthest.force_cmd_n, "k:", label="commanded force")
    panels[0].set(xlabel="θ (°)", ylabel="$F_{ex}$ (N)")
    panels[1].set(xlabel="time since onset (s)", ylabel="θ (°)")
    panels[2].set(xlabel="time since onset (s)", ylabel="θ' (°/s)")
    if environment["wall_rad"] is not None:
        panels[0].axvline(np.degrees(environment["wall_rad"]), color="k", linestyle="--", linewidth=0.6)
        panels[1].axhline(np.degrees(environment["wall_rad"]), color="k", linestyle="--", linewidth=0.6)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=7)
    figure.suptitle(f"{environment['label']}: every repeat, {mode['label'].lower()}")
    save(figure, folder, f"repeats.P01.S01.{environment['id']}.{mode['id']}")


def loops_figure(folder, study, averages):
    figure, panels = plt.subplots(1, len(study["environment"]), figsize=(WIDE, 80 / INCH), sharey=True)
    for axes, environment in zip(panels, study["environment"].values()):
        for mode in study["modes"]:
            table = averages[environment["id"], mode["id"], "onset"]
            dotted_past(axes, np.degrees(table.theta_mean_rad), table.force_ex_mean_n, table.theta_mean_rad.to_numpy(),
                        environment["wall_rad"], color=COLOURS[mode["id"]], linewidth=1.6, label=mode["label"])
        axes.set(xlabel="θ (°)", ylabel="$F_{ex}$ (N)", title=environment["label"])
    panels[-1].legend()
    save(figure, folder, "loops.P01.S01")


def characteristic_figure(folder, actuator, frames, curve, parameters):
    figure, axes = plt.subplots(figsize=(NARROW, 125 / INCH))
    for frame in frames:
        axes.plot(frame.command, frame.response, color="#bbbbbb", linewidth=0.4)
    for (branch, part), colour in zip(curve.groupby("branch", sort=False), ("#0077bb", "#ee7733")):
        axes.fill_between(part.command, part.prediction_low, part.prediction_high, color=colour, alpha=0.25, linewidth=0)
        axes.plot(part.command, part.fit, color=colour, linewidth=1.6, label=f"chosen fit, {branch}")
        axes.plot(part.command, part["mean"], "k", linewidth=0.6, label="mean of the sweeps")
    axes.plot(part.command, part.first_order, "k--", label="first-order fit")
    axes.set(xlabel="voltage (V)", ylabel="force (N)", title=f"Characteristic: {actuator}")
    axes.legend()
    save(figure, folder, f"characteristic.{actuator}")


def replay_figure(folder, study, replays, models, fitted, environment):
    figure, panels = plt.subplots(3, len(study["modes"]), figsize=(WIDE, 145 / INCH), sharex="col", sharey="row")
    driven = replays[(replays.causality == "force_driven") & (replays.environment == environment["id"])]
    for column, mode in enumerate(study["modes"]):
        mine = driven[driven["mode"] == mode["id"]].sort_values("nrmse")
        number = mine.trial.iloc[(len(mine) - 1) // 2]
        trial = next(m for m in models if m.meta["trial"] == number)
        t = trial.t
        top, middle, bottom = panels[:, column]
        top.plot(t, trial.force, color="#888888", label="external force, recorded")
        top.plot(t, trial.frame.force_cmd_n, "k", linewidth=2.4, alpha=0.35, label="recorded")
        middle.plot(t, np.degrees(trial.theta), "k", linewidth=2.4, alpha=0.35)
        bottom.plot(t, np.degrees(trial.velocity), "k", linewidth=2.4, alpha=0.35)
        runs = [("model, by eye", model.BY_EYE, dict(color="#882255", linestyle="--")),
                ("model, fitted", fitted, dict(color="#117733"))]
        for label, plant, style in runs:
            theta, velocity, feedback = trial.force_driven(plant)
            top.plot(t, feedback, label=label, **style)
            middle.plot(t, np.degrees(theta), **style)
            bottom.plot(t, np.degrees(velocity), **style)
        if environment["wall_rad"] is not None:
            middle.axhline(np.degrees(environment["wall_rad"]), color="k", linestyle="--", linewidth=0.6)
        top.set_title(f"{mode['label']}, trial {number}")
        bottom.set_xlabel("time (s)")
    for axes, label in zip(panels[:, 0], ("F (N)", "θ (°)", "θ' (°/s)")):
        axes.set_ylabel(label)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=4)
    save(figure, folder, f"replay.P01.S01.{environment['id']}")


def likert_figure(folder, study, likert):
    figure, panels = plt.subplots(1, len(study["environment"]), figsize=(WIDE, 58 / INCH), sharex=True)
    colours = ["#b2182b", "#ef8a62", "#dddddd", "#67a9cf", "#2166ac"]
    for axes, environment in zip(panels, study["environment"].values()):
        for row, mode in enumerate(reversed(study["modes"])):
            one = likert[(likert.environment == environment["id"]) & (likert["mode"] == mode["id"])].iloc[0]
            counts = np.array([one[f"count_{k}"] for k in range(1, 6)])
            left = -(counts[:2].sum() + counts[2] / 2) + np.r_[0, np.cumsum(counts)[:-1]]
            axes.barh(row, counts, left=left, color=colours)
            for x, n in zip(left + counts / 2, counts):
                if n:
                    axes.text(x, row, str(n), ha="center", va="center")
        axes.set_yticks(range(3), [m["label"] for m in reversed(study["modes"])])
        axes.axvline(0, color="k", linewidth=0.6)
        axes.set(title=environment["label"], xlabel="answers, against ← → in favour")
    save(figure, folder, "likert")


def environment_figure(folder, study, environment):
    figure, axes = plt.subplots(figsize=(85 / INCH, 65 / INCH))
    at = lambda degrees, r: (r * np.sin(np.radians(degrees)), r * np.cos(np.radians(degrees)))
    arc = np.array([at(a, 1.0) for a in np.linspace(study["device"]["theta_min_deg"], study["device"]["theta_max_deg"], 91)])
    axes.plot(*arc.T, "k", linewidth=0.8)
    axes.plot(*np.array([(0, 0), at(-15, 0.9)]).T, "k", linewidth=4)
    axes.plot(*np.array([(0, 0), at(environment["rest_deg"], 1.0)]).T, "k:", linewidth=0.6)
    coil = np.linspace(-13, 25, 60)
    axes.plot(*np.array([at(a, 0.65 + 0.04 * (-1) ** i) for i, a in enumerate(coil)]).T, color="#009988")
    if environment["wall_rad"] is not None:
        axes.plot(*np.array([at(environment["wall_deg"], r) for r in (0.7, 1.0)]).T, color="#b2182b", linewidth=3)
    axes.annotate(f"K = {environment['stiffness_n_per_rad']:g} N/rad", at(25, 0.45))
    axes.set(aspect="equal", title=environment["label"])
    axes.axis("off")
    save(figure, folder, f"environment.{environment['id']}")


def rendering_range_figure(folder, study, characteristics):
    figure, panels = plt.subplots(2, len(study["modes"]), figsize=(WIDE, 100 / INCH), sharex=True, sharey="row")
    for column, mode in enumerate(study["modes"]):
        for row, way in enumerate(("compressing", "decompressing")):
            motor, brake = mode.get("motor_max_v"), mode.get("brake_max_v")
            by_brake = brake is not None and (motor is None or row == 0)
            voltage = np.linspace(0, brake if by_brake else motor, 201)
            force = characteristics["brake" if by_brake else "motor"][3](voltage)
            low = 0 * force if by_brake and row == 0 else -force
            high = 0 * force if by_brake and row == 1 else force
            axes = panels[row, column]
            axes.fill_between(voltage, low, high, color=COLOURS[mode["id"]], alpha=0.25)
            axes.plot(voltage, low, color=COLOURS[mode["id"]])
            axes.plot(voltage, high, color=COLOURS[mode["id"]])
            if row == 0:
                axes.set_title(mode["label"])
            else:
                axes.set_xlabel("command (V)")
            if column == 0:
                axes.set_ylabel(f"F, {way} (N)")
    save(figure, folder, "rendering_range")


def draw_all(folder, study, trials, averages, tables, sweeps, characteristics, models, fitted):
    onsets = dict(zip(tables["metrics"].trial, tables["metrics"].onset_s))
    for environment in study["environment"].values():
        modes_figure(folder, study, trials, averages, onsets, environment)
        for mode in study["modes"]:
            repeats_figure(folder, trials, onsets, environment, mode)
        replay_figure(folder, study, tables["replay"], models, fitted, environment)
        environment_figure(folder, study, environment)
    loops_figure(folder, study, averages)
    for actuator, frames in sweeps.items():
        curve, parameters, *_ = characteristics[actuator]
        characteristic_figure(folder, actuator, frames, curve, parameters)
    likert_figure(folder, study, tables["likert"])
    rendering_range_figure(folder, study, characteristics)
