"""Writes docs/engines.md and its figure from results.json.

    python page.py RESULTS PAGE
"""

import json
import math
import os
import platform
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt

import words
from scene import scenes

# Scenes of the figure: bodies under dry friction, a stiff wall, and the thesis' drive.
DRAWN = ["chattering", "stiff_wall", "hybrid"]
# Errors below this are drawn at it: they are rounding, rad.
LEAST_RAD = 1e-13


def degrees(error_rad):
    if error_rad == "" or not math.isfinite(error_rad):
        return "–"
    value = math.degrees(error_rad)
    return "0" if value < 1e-11 else f"{value:.1e}" if value < 0.01 else f"{value:.2g}"


def seconds(row):
    if "seconds" not in row:
        return "–"
    return f"{row['seconds']:.2g}" + (" (wall clock)" if row.get("clock") == "wall" else "")


def is_right(row):
    return row["verdict"].startswith(("right", "stands"))


def felt(row):
    """Behind a verdict that something is wrong."""
    return "" if is_right(row) or row["is_felt"] is None else " (felt)" if row["is_felt"] else " (not felt)"


def summary(engines, rows):
    lines = ["| engine | setting | right | wrong, not felt | wrong, felt | not run | which a person can tell |", "|---|---|--:|--:|--:|--:|---|"]
    for engine in engines:
        for setting in engine["settings"]:
            if setting["kind"] == "more":
                continue
            mine = [r for r in rows if r["engine"] == engine["engine"] and r["setting"] == setting["name"]]
            ran = [r for r in mine if "file" in r or "failed" in r]
            wrong = [r["scene"] for r in ran if not is_right(r)]
            felt = [r["scene"] for r in ran if not is_right(r) and r["is_felt"] is not False]
            kind = "defaults" if setting["kind"] == "default" else "best"
            lines.append(f"| {engine['name']} | {kind} | {len(ran) - len(wrong)} | {len(wrong) - len(felt)} | {len(felt)} | "
                         f"{len(words.SHORT) - len(ran)} | {', '.join(words.SHORT[s] for s in felt)} |")
    return lines


def scene_table(scene, engines, rows):
    lines = ["| engine | defaults: time, s | largest error of θ, ° | verdict | best: time, s | error, ° | verdict |", "|---|--:|--:|---|--:|--:|---|"]
    for engine in engines:
        cells = [engine["name"]]
        for kind in ("default", "best"):
            name = next(s["name"] for s in engine["settings"] if s["kind"] == kind)
            row = next((r for r in rows if (r["engine"], r["setting"], r["scene"]) == (engine["engine"], name, scene.id)), None)
            cells += ["–", "–", "not run"] if row is None else [seconds(row), degrees(row["error_rad"]), row["verdict"].replace("|", "/") + felt(row)]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def others(engines, rows):
    """Settings of the figure that are neither defaults nor best, in words."""
    lines = ["| engine | setting | right of | what |", "|---|---|--:|---|"]
    for engine in engines:
        for setting in engine["settings"]:
            if setting["kind"] == "more":
                mine = [r for r in rows if r["engine"] == engine["engine"] and r["setting"] == setting["name"] and "file" in r]
                lines.append(f"| {engine['name']} | {setting['about']} | {sum(map(is_right, mine))}/{len(mine)} | {words.MORE.get((engine['engine'], setting['name']), '')} |")
    return lines


def draw(engines, rows, known, path):
    """One panel per scene: time against error, a mark per engine and setting."""
    plt.rcParams.update({"font.size": 9, "font.family": "DejaVu Sans", "axes.spines.top": False, "axes.spines.right": False})
    figure, panels = plt.subplots(1, len(DRAWN), figsize=(11, 4.6), sharey=True, layout="constrained")
    colours = [*plt.get_cmap("tab10").colors, (0, 0, 0), (0.55, 0.7, 0.1), (0.35, 0.2, 0.6)]
    marks = "osD^v<>PXph*d"
    for panel, scene in zip(panels, DRAWN):
        for i, engine in enumerate(engines):
            mine = [r for r in rows if r["engine"] == engine["engine"] and r["scene"] == scene and "seconds" in r and math.isfinite(r["error_rad"])]
            for row in mine:
                panel.loglog(max(row["error_rad"], LEAST_RAD), row["seconds"], marks[i % len(marks)], ms=6, mew=1, color=colours[i % len(colours)],
                             mfc=colours[i % len(colours)] if is_right(row) else "none")
        panel.set_title(known[scene].name, fontsize=10)
        panel.set_xlabel("largest error of θ, rad")
        panel.grid(True, which="major", lw=0.3)
    panels[0].set_ylabel("time of the run, s")
    filled = []
    for i, engine in enumerate(engines):
        filled.append(plt.Line2D([], [], ls="", marker=marks[i % len(marks)], color=colours[i % len(colours)], label=engine["name"]))
    filled += [plt.Line2D([], [], ls="", marker="o", mfc="none", color="black", label="open: wrong by its verdict")]
    figure.legend(handles=filled, loc="outside lower center", ncols=7, frameon=False, fontsize=8.5)
    figure.savefig(path, dpi=110)


def main():
    results, page = Path(sys.argv[1]), Path(sys.argv[2])
    told = json.loads(results.read_text())
    engines, rows = told["engines"], told["rows"]
    known = {s.id: s for s in scenes()}
    picture = page.parent / "pictures" / "engines.png"
    draw(engines, rows, known, picture)
    lines = [*words.HEAD.strip().splitlines(), "", "## In one glance", "", *words.GLANCE.strip().splitlines(), "", *summary(engines, rows), "",
             "![Time against error, three scenes](pictures/engines.png)", "", *words.FIGURE.strip().splitlines(), "",
             "## What each does wrong, and the cure", ""]
    for engine in engines:
        lines += [f"### {engine['name']}", "", f"{engine['versions']}.", ""]
        for setting in engine["settings"]:
            if setting["kind"] != "more":
                kind = "Defaults" if setting["kind"] == "default" else "Best"
                lines.append(f"* {kind}: {setting['about']} ({setting['source']}).")
        lines += ["", *words.REMARKS.get(engine["engine"], "").strip().splitlines(), ""]
    lines += ["## Engines that were not run", "", *words.ABSENT.strip().splitlines(), "", "## What was said before, and what these versions do", "",
              *words.CLAIMS.strip().splitlines(), "", "## The scenes", ""]
    for scene in known.values():
        lines += [f"### {scene.name}", "", *words.SCENES[scene.id].strip().splitlines(), "", *scene_table(scene, engines, rows), ""]
    lines += ["## Other settings", "", *others(engines, rows), ""]
    extremes = results.parent / "extremes.json"
    if extremes.exists():
        lines += [*words.extremes(json.loads(extremes.read_text())), ""]
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    lines += ["## Machine", "", f"{platform.machine()}, {os.cpu_count()} cores, one used per run; Linux; load average when the page was written {load}. "
              "Times are medians of the processor's time in the stepping loop alone, beside other work on the machine: their first digit is worth something, their second is not."]
    page.write_text("\n".join(lines).rstrip() + "\n")


if __name__ == "__main__":
    main()
