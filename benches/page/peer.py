"""A static page of a study by plotly: means by condition, paired dots, a browser of trials with every sample in the page.

    python peer.py ROOT STUDY OUT.html

Reads the trials of raw/ and the table of metrics of derived/. Samples stand in the page as one JSON, gzipped, in base64, and are
unpacked when the page is opened: the way of MultiQC.
"""

import base64
import gzip
import html
import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pyarrow.parquet as parquet
from plotly.offline import get_plotlyjs

COLUMNS = ["t_s", "theta_rad", "force_ex_n"]
METRICS = ["discrepancy_user_mean_n", "stiffness_n_per_rad", "theta_max_rad", "wall_past_max_rad", "duration_s"]
# θ to 1e-6 rad and forces to 1e-4 N: what a reader of a plot needs, and a third of the bytes.
DIGITS = 6
SCRIPT = """
const choose = (id) => document.getElementById(id);
async function unpack() {
  const packed = Uint8Array.from(atob(choose("samples").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  window.samples = JSON.parse(await new Response(stream).text());
  for (const id of ["participant", "condition"]) choose(id).addEventListener("change", show);
  show();
}
function show() {
  const of = window.samples[choose("participant").value][choose("condition").value] ?? [];
  const lines = of.flatMap((trial, i) => [
    { x: trial[0], y: trial[1], name: `repeat ${i + 1}`, mode: "lines", xaxis: "x", yaxis: "y" },
    { x: trial[0], y: trial[2], mode: "lines", showlegend: false, xaxis: "x", yaxis: "y2" },
    { x: trial[1], y: trial[2], mode: "lines", showlegend: false, xaxis: "x2", yaxis: "y2" },
  ]);
  const layout = { grid: { rows: 2, columns: 2, subplots: [["xy", ""], ["xy2", "x2y2"]] }, xaxis: { title: { text: "t (s)" } }, xaxis2: { title: { text: "θ (rad)" } },
    yaxis: { title: { text: "θ (rad)" } }, yaxis2: { title: { text: "F (N)" } }, height: 600 };
  Plotly.react("browser", lines, layout).then(() => { document.body.dataset.drawn = Number(document.body.dataset.drawn ?? 0) + 1; });
}
addEventListener("load", unpack);
"""


def samples(root, study):
    """participant → condition → the columns of each repeat."""
    found = {}
    for path in sorted((root / "raw" / study / "trials").glob("participant=*/session=*/trial-*.parquet")):
        table = parquet.ParquetFile(path).read(columns=[*COLUMNS, "kind", "environment", "mode"])
        kind, environment, mode = (table[name][0].as_py() for name in ("kind", "environment", "mode"))
        if kind != "trial":
            continue
        columns = [np.round(table[name].to_numpy(), DIGITS).tolist() for name in COLUMNS]
        participant, condition = path.parents[1].name.split("=")[1], f"{environment} {mode}"
        found.setdefault(participant, {}).setdefault(condition, []).append(columns)
    return found


def means(metrics):
    """The table of means and standard deviations by condition."""
    by = metrics.groupby(["environment", "mode"], sort=False)[METRICS].agg(["mean", "std"])
    cell = lambda mean, sd: "" if pd.isna(mean) else f"{mean:.4g} ± {sd:.2g}"
    rows = [[*key, *(cell(row[m, "mean"], row[m, "std"]) for m in METRICS)] for key, row in by.iterrows()]
    head = "".join(f"<th>{html.escape(name)}</th>" for name in ["environment", "mode", *METRICS])
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def dots(metrics):
    """Of each metric a figure: participants' means by condition, those of one participant joined."""
    figures = []
    of = metrics.groupby(["environment", "participant", "mode"], sort=False)[METRICS].mean().reset_index()
    for metric in METRICS:
        figure = go.Figure()
        for environment, rows in of.groupby("environment", sort=False):
            wide = rows.pivot(index="participant", columns="mode", values=metric)
            # One trace of all participants' lines, with gaps between: as many traces would take minutes.
            x = [place for _ in wide.index for place in [*wide.columns, None]]
            y = [value for row in wide.to_numpy() for value in [*row, None]]
            figure.add_scattergl(x=x, y=y, mode="lines+markers", name=environment, marker={"size": 3}, line={"width": 0.5}, opacity=0.5)
        figure.update_layout(title=metric, height=400)
        figures.append(figure.to_html(full_html=False, include_plotlyjs=False))
    return "".join(figures)


def main():
    root, study, out = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    metrics = pd.read_parquet(root / "derived" / study / "metrics.parquet")
    trials = samples(root, study)
    packed = base64.b64encode(gzip.compress(json.dumps(trials, separators=(",", ":")).encode(), 6)).decode()
    options = lambda names: "".join(f"<option>{html.escape(name)}</option>" for name in names)
    conditions = list(dict.fromkeys(condition for one in trials.values() for condition in one))
    out.write_text(f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(study)}</title>
<h1>{html.escape(study)}</h1><h2>Means by condition</h2>{means(metrics)}
<script>{get_plotlyjs()}</script>
<h2>Trials</h2><select id="participant">{options(trials)}</select><select id="condition">{options(conditions)}</select><div id="browser"></div>
<h2>Participants</h2>{dots(metrics)}
<script type="text/plain" id="samples">{packed}</script><script>{SCRIPT}</script></html>""")


main()
