# %% [markdown]
# # Scenes: a thousand runs, a judge, and a map of walls
#
# `python scenes.py SCENE.toml` runs it. It needs NumPy.

# %%
import sys

import numpy as np
import zwidth

scene = sys.argv[1] if len(sys.argv) > 1 else "raw/thesis-twin/scenes/step.toml"

# %% [markdown]
# A run for each mass, on all cores. The exact solver's error does not depend on the step.

# %%
masses = np.linspace(0.02, 0.2, 1000)
runs = zwidth.simulate(scene, plant__mass_kg=masses, step_s=0.01)
peak = np.asarray(runs.table["theta_max_rad"])
print(f"{len(runs)} runs: the largest angle from {np.degrees(peak.min()):.2f}° to {np.degrees(peak.max()):.2f}°")

# %% [markdown]
# One run with its samples, and what it is worth:

# %%
run = zwidth.simulate(scene, samples=True)
trajectory = run.trajectory(0)
print(run.table["verdict"].to_list(), trajectory.columns)

# %% [markdown]
# Another program's trajectory beside the right one. Here it is ours, 10 ms late: the judge says what is wrong with it.

# %%
t, theta, velocity = (np.asarray(trajectory[name]) for name in ("t_s", "theta_rad", "theta_dot_rad_s"))
print(zwidth.judge(scene, t, theta, velocity))
delayed = np.interp(t - 0.01, t, theta)
judged = zwidth.judge(scene, t, delayed, np.interp(t - 0.01, t, velocity))
print(judged, judged.faults.to_dict()["fault"][:2])

# %% [markdown]
# Which walls its device renders stably, by every limit:

# %%
limits = zwidth.stability_limits(scene, rate=1000.0)
for limit, stiffness in zip(limits.to_dict()["limit"], limits.to_dict()["stiffness_n_per_m"]):
    print(f"{limit:20} {'says nothing' if stiffness is None else f'{stiffness:9.1f} N/m'}")
walls = zwidth.stability_map(scene, "delay", "stiffness", cells=40, rate=1000.0)
stable = np.asarray(walls["lifted_map"]) < 1
print(f"{stable.mean():.0%} of {walls.title} are stable")
