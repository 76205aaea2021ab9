"""Tables in six formats, the tables of the plan, and the summary."""

import numpy as np
import pandas as pd


def write_table(table, stem):
    """LaTeX, Typst, Markdown, CSV, HTML and Parquet."""
    at = lambda suffix: stem.with_name(f"{stem.name}.{suffix}")  # stems have dots
    table.to_parquet(at("parquet"))
    table.to_csv(at("csv"), index=False)
    shown = table.copy()
    for column in shown.select_dtypes("number"):
        shown[column] = [("" if pd.isna(v) else f"{v:.4g}") for v in shown[column]]
    shown = shown.fillna("–").astype(str)
    at("md").write_text(shown.to_markdown(index=False))
    at("html").write_text(shown.to_html(index=False))
    at("tex").write_text(shown.style.hide(axis="index").format(escape="latex").format_index(
        escape="latex", axis=1).to_latex(hrules=True))
    at("typ").write_text(typst(shown))


def typst(table):
    cell = lambda text: "[" + "".join(f"\\{c}" if c in "\\#$*_`<>@[]~" else c for c in str(text)) + "]"
    rows = [table.columns, *table.itertuples(index=False)]
    body = ",\n  ".join(", ".join(cell(c) for c in row) for row in rows)
    return f"#table(\n  columns: {len(table.columns)},\n  {body},\n)\n"


def plan_tables(study, tables, characteristics):
    """Modes, device, weight, model, and pros and cons beside the study's own numbers."""
    motor, brake = (characteristics[a][3] for a in ("motor", "brake"))
    metrics, device, control, masses = tables["metrics"], study["device"], study["control"], study["masses"]
    modes = []
    for mode in study["modes"]:
        m, b = mode.get("motor_max_v", np.nan), mode.get("brake_max_v", np.nan)
        there = ("brake", brake(b)) if b == b else ("motor", motor(m))
        back = ("motor", motor(m)) if m == m else ("brake, against the return", brake(b))
        modes.append(dict(mode=mode["label"], motor_max_v=m, brake_max_v=b, compressing=there[0],
                          compressing_max_n=float(there[1]), decompressing=back[0],
                          decompressing_max_n=float(back[1])))
    rows = [("lever length, axis to finger", 1e3 * device["lever_m"], "mm"),
            ("work space, lower end", device["theta_min_deg"], "°"),
            ("work space, upper end", device["theta_max_deg"], "°"),
            ("new values of the force sensor", device["force_rate_hz"], "Hz"),
            ("tick of the control loop", 1e3 / control["rate_hz"], "ms"),
            ("user force below which the brake lets go", control["let_go_n"], "N"),
            ("limit of the force on a finger", control["force_limit_n"], "N"),
            ("velocity from angles", control["velocity_cutoff_hz"], "Hz"),
            ("motor, mass", masses["motor_g"], "g"), ("brake, mass", masses["brake_g"], "g")]
    hybrid = study["mode"]["hybrid"]["motor_max_v"]
    share, at_hybrid = hybrid / 48.0, float(motor(hybrid))
    small = masses["motor_g"] * share
    weight = [("motor, mass", masses["motor_g"], "g", 88), ("brake, mass", masses["brake_g"], "g", 27),
              ("motor voltage in the hybrid mode", hybrid, "V", 8), ("motor force there", at_hybrid, "N", 2),
              ("motor force at its rated 48 V", at_hybrid / share, "N", 12),
              ("motor of that size, mass", small, "g", 15),
              ("hybrid: brake and small motor, mass", masses["brake_g"] + small, "g", 42),
              ("saved against the whole motor", masses["motor_g"] - masses["brake_g"] - small, "g", 35),
              ("share of the motor's power at stall", share ** 2, "1", 1 / 6)]
    scene = [("M_O", 0.005, "kg"), ("K_O", 4, "N/rad"), ("B_O", 1, "N·s/rad"), ("θ_rest", -45, "°"),
             ("M_F", 0.021, "kg"), ("K_F", 584.6, "N/m"), ("B_F", 1.53, "N·s/m"), ("L_F0", 6, "mm"), ("T", 4, "s"),
             ("h", 8.3, "ms"), ("F_ex", 4.3, "N"), ("θ_min", -45, "°"), ("θ_max", 45, "°"), ("L", 1, "m"),
             ("F_m", 3.25, "N"), ("F_b", 13, "N")]
    return {"modes": pd.DataFrame(modes), "device": pd.DataFrame(rows, columns=["quantity", "value", "unit"]),
            "weight": pd.DataFrame(weight, columns=["quantity", "value", "unit", "thesis"]),
            "model": pd.DataFrame(scene, columns=["quantity", "value", "unit"]),
            "pros_cons": pros_cons(metrics, masses, modes)}


def pros_cons(metrics, masses, modes):
    of = {mode: rows for mode, rows in metrics.groupby("mode")}
    spring = {mode: rows[rows.environment == "spring"] for mode, rows in of.items()}
    returned = {m: 100 * rows.returned_energy_share.mean() for m, rows in spring.items()}
    smooth = 100 * (of["active"].recorded_stability == "smooth").mean()
    past = np.degrees(of["active"].wall_past_max_rad.mean())
    claims = [("passive", "pro", "High force to energy consumption ratio", None, np.nan, ""),
              ("passive", "pro", "Lightweight", "mass of the brake", masses["brake_g"], "g"),
              ("passive", "pro", "Safe", None, np.nan, ""),
              ("passive", "con", "Only resistive forces", "returned share of the work", returned["passive"], "%"),
              ("passive", "con", "Can not render stiffness", "returned share of the work", returned["passive"], "%"),
              ("active", "pro", "Easy to control", "trials without fast swings", smooth, "%"),
              ("active", "pro", "Can resist and amplify", "returned share of the work", returned["active"], "%"),
              ("active", "con", "Low force to energy consumption ratio", None, np.nan, ""),
              ("active", "con", "Heavy", "mass of the motor", masses["motor_g"], "g"),
              ("active", "con", "Unsafe/weak trade off", "largest motor force", modes[0]["compressing_max_n"], "N"),
              ("active", "con", "Can not render infinite stiffness", "angle past the wall", past, "°")]
    table = pd.DataFrame(claims, columns=["actuation", "side", "claim", "metric", "value", "unit"])
    table["verdict"] = np.where(table.metric.isna(), "not measured", "supported")
    return table


def summary(study, tables, reports):
    lines = [f"# {study['study']['title']}", "", "**All data are simulated: nothing here was measured.**", "",
             f"Device: {study['device']['name']}.", "", "## What the trials show", ""]
    for row in tables["conditions"].itertuples():
        text = (f"- {row.environment}, {row.mode}: compressing gave {row.stiffness_n_per_rad:.2f} N/rad where "
                f"{study['environment'][row.environment]['stiffness_n_per_rad']:g} were asked for (mean of {row.n})")
        if row.saturation_force_n == row.saturation_force_n:
            text += f"; the force flattened at {row.saturation_force_n:.2f} N"
        if row.discrepancy_user_step_n == row.discrepancy_user_step_n:
            text += f"; the user's force fell by {row.discrepancy_user_step_n:.2f} N at the reversal"
        lines.append(text + f"; {100 * row.returned_energy_share:.0f} % of the work put in came back.")
    wall = tables["conditions"].dropna(subset="wall_past_max_rad").sort_values("wall_past_max_rad")
    lines += ["- Past the wall the lever went " + ", ".join(
        f"{np.degrees(r.wall_past_max_rad):.2f}° with {r.mode}" for r in wall.itertuples()) + "."]
    for row in tables["likert"].itertuples():
        lines.append(f"- {row.environment}: the median answer was {row.median_low} with {row.mode} (n = {row.n}).")
    lines += ["", "## Figures", ""] + [f"- [{p.stem}](figures/{p.name})" for p in sorted((reports / "figures").glob("*.png"))]
    lines += ["", "## Tables", ""] + [f"- [{stem}](tables/{stem}.md)" for stem in tables]
    return "\n".join(lines) + "\n"
