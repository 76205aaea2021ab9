# %% [markdown]
# # One's own arrays
#
# Metrics, means and fits of numbers that no study holds. SI units: s, rad, N. `python own_arrays.py` runs it. It needs NumPy.

# %%
import numpy as np

import zwidth

t = np.arange(0, 3, 1e-3)
phase = np.pi * np.clip(t - 0.5, 0, 2)
theta = -0.785 + 0.5 * (1 - np.cos(phase))
velocity = 0.5 * np.pi * np.sin(phase)
noise = np.random.default_rng(1).normal(0, 0.02, (5, len(t)))
force = 4.0 * (theta + 0.785) + 0.1 * np.sign(velocity) + noise
spring = {"kind": "spring", "stiffness_n_per_rad": 4.0, "rest_rad": -0.785}

# %% [markdown]
# The metrics of one movement, each defined in docs/analysis.md:

# %%
metrics = zwidth.trial_metrics(t, theta, force[0], velocity=velocity, lever_m=0.045, scene=spring)
for name in ("onset_s", "end_s", "discrepancy_user_mean_n", "stiffness_n_per_rad", "loop_area_j"):
    print(f"{name:26}{metrics[name].to_list()[0]:9.4f}  {metrics.meanings[name]}")
print(zwidth.onset(t, velocity), zwidth.smoothness(t, velocity))

# %% [markdown]
# The mean of five movements by branch, at equal angles: where repeats turn at different angles, a mean over time would pass
# through pairs of force and angle that occur in none of them.

# %%
mean = zwidth.means_by_branch([t] * 5, [theta] * 5, list(force), spring, velocity=[velocity] * 5)
print(mean, mean["force_ex_mean_n"].to_list()[50])

# %% [markdown]
# An actuator's characteristic, chosen among curves by cross-validation:

# %%
volts = np.linspace(0, 10, 200)
newtons = 0.02 * volts**2 + np.random.default_rng(2).normal(0, 0.02, 200)
fit = zwidth.fit_characteristic(volts, newtons, resamples=200)
print(fit.model, "—", fit.reason)

# %% [markdown]
# A person's threshold and JND, with profile intervals:

# %%
level = np.array([2.8, 3.2, 3.6, 4.0, 4.4, 4.8, 5.2])
answers = zwidth.fit_psychometric(level, np.full(7, 20.0), np.array([1.0, 2, 5, 10, 15, 18, 19]))
print(answers, answers.threshold_interval, answers.jnd_interval)

# %% [markdown]
# What cannot be is refused in words:

# %%
try:
    zwidth.smoothness(t, np.where(t > 1, np.nan, velocity))
except zwidth.ZwidthError as error:
    print(error, "| column", error.column, "| row", error.row)
