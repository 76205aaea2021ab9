# %% [markdown]
# # A study in a notebook
#
# `zwidth run` makes every table and figure; Python reads them. This is a script of cells (`# %%`), which Jupyter, VS Code and
# Spyder open as a notebook; `python a_study.py ROOT` runs it. It needs polars.

# %%
import sys

import polars as pl

import zwidth

root = sys.argv[1] if len(sys.argv) > 1 else "."
zwidth.command("run", "thesis-twin", "--root", root, "--quiet")  # nothing, if all is up to date
study = zwidth.read_study(root, "thesis-twin")
study  # a notebook shows the modes compared, and a figure of every difference

# %% [markdown]
# Which trials count, and why others do not:

# %%
trials = pl.DataFrame(study.trials)
print(trials.group_by("counts", "why_not").len().sort("counts"))

# %% [markdown]
# Metrics are one row a trial, in SI units; the unit and the meaning of each column come along.

# %%
metrics = pl.DataFrame(study.metrics())
past = metrics.filter(pl.col("environment") == "spring_wall").group_by("mode").agg(pl.col("wall_past_max_rad").degrees().mean())
print(study.metrics().meanings["wall_past_max_rad"])
print(past.sort("mode"))

# %% [markdown]
# Differences between modes, as the run tested them, each in the unit of its row.

# %%
contrasts = pl.DataFrame(study.contrasts())
print(contrasts.select("metric", "environment", "contrast", "n", "difference", "p_adjusted", "unit", "verdict").head(5))

# %% [markdown]
# The samples themselves, trial by trial, never all of them at once: here the largest force of each.

# %%
largest = (
    pl.DataFrame(study.samples(["force_ex_n"]))
    .group_by("trial", "mode", maintain_order=True)
    .agg(pl.col("force_ex_n").abs().max().alias("largest_n"))
)
print(largest.head(3))

# What a run computes of a trial is what is computed here, to the last bit.
row = metrics.row(0, named=True)
own = study.trial(row["participant"], row["session"], row["trial"]).metrics().to_dict()
assert all(values == [row[name]] for name, values in own.items())
