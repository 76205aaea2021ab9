"""A stage of a study's own in Python: the largest push of each trial and how fast it grows, and a figure of both.

It needs pandas, pyarrow and matplotlib, and lies as analysis/<study>/push.py beside raw/. In study.toml:

    [[stage]]
    id = "push"
    command = ["python3", "push.py"]
    files = ["push.py"]
    inputs = ["samples"]
    columns = ["t_s", "force_ex_n"]
    gives = [
        { id = "push_peak", unit = "N", label = "largest push" },
        { id = "push_rate", unit = "N/s", label = "fastest growth of the push" },
    ]
    figures = [{ file = "push.svg", caption = "Largest push, trial by trial." }]

Then `zwidth allow STUDY`, and `zwidth run STUDY`.
"""

import matplotlib.pyplot as pyplot
import pandas as pd
import pyarrow.parquet as parquet

KEY = ["participant", "session", "trial", "environment", "mode"]

# A row group a trial: however long the study is, memory holds one trial.
samples = parquet.ParquetFile("in/samples.parquet")
rows = []
for group in range(samples.num_row_groups):
    trial = samples.read_row_group(group, columns=[*KEY, "t_s", "force_ex_n"]).to_pandas()
    force = trial["force_ex_n"]
    # A trial whose force was not recorded has no value: an empty cell, not NaN, which is refused.
    peak = force.abs().max() if force.notna().any() else None
    rate = (force.diff() / trial["t_s"].diff()).abs().max() if force.notna().any() else None
    rows.append({**trial[KEY].iloc[0], "push_peak": peak, "push_rate": rate})
table = pd.DataFrame(rows)
table[["participant", "session", "trial", "push_peak", "push_rate"]].to_parquet("out/table.parquet", index=False)

# Without this salt and without the date, no two SVGs are the same.
pyplot.rcParams["svg.hashsalt"] = "push"
figure, axes = pyplot.subplots(figsize=(4, 3))
for mode, own in table.groupby("mode"):
    axes.plot(own["push_peak"].to_numpy(), "o", label=mode)
axes.set_xlabel("trial")
axes.set_ylabel("largest push in N")
axes.legend()
figure.tight_layout()
figure.savefig("out/figures/push.svg", metadata={"Date": None})
