"""MuJoCo MJX: MuJoCo's equations in JAX, on the processor; a run is one compiled scan."""

import time

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from engine import Setting
from engines.mujoco import mjcf
from stepping import STANDS_RAD_S, TOO_LONG_S, TooSlow

NAME = "MuJoCo MJX"
BOOK = "MuJoCo documentation, MuJoCo XLA (MJX), "
SETTINGS = [
    Setting("default", "default", "timestep 2 ms, Euler, float32", BOOK + "“Feature Parity”", {"step_s": 2e-3, "x64": False}),
    Setting("stiff", "best", "float64, timestep 0.1 ms, solimp of friction 0.9999, time constant of friction 2 steps, of limits 5",
            BOOK + "“Feature Parity” (no NoSlip); “Solver parameters”",
            {"step_s": 1e-4, "x64": True, "solref": (5e-4, 1.0), "friction": (2e-4, 1.0), "impedance": 0.9999}),
]


# Instead of a dry friction of 0, N.
LEAST_N = 1e-9


class Arrays:
    sin, where, clip, remainder = jnp.sin, jnp.where, jnp.clip, jnp.fmod


def versions():
    return f"mujoco-mjx {__import__('importlib.metadata').metadata.version('mujoco-mjx')}, mujoco {mujoco.__version__}, jax {jax.__version__}"


def run(scene, setting):
    options = dict(setting.options)
    jax.config.update("jax_enable_x64", options.pop("x64"))
    plain = mujoco.MjModel.from_xml_string(mjcf(scene, **options))
    model = mjx.put_model(plain)
    steps = round(scene.duration_s / plain.opt.timestep)
    h, lever_m = plain.opt.timestep, scene.lever_m
    data = mjx.make_data(plain)
    data = data.replace(qpos=data.qpos.at[0].set(scene.theta_rad), qvel=data.qvel.at[0].set(scene.theta_dot_rad_s))

    def step(carry, k):
        data, level, finger, finger_dot = carry
        theta, theta_dot, t = data.qpos[0], data.qvel[0], k * h
        if scene.lag_s:
            asked = scene.commands(theta, theta_dot, scene.zones[0], Arrays)[2]
            for edge, beyond in zip(scene.edges(), scene.zones[1:]):
                asked = jnp.where(theta >= edge, scene.commands(theta, theta_dot, beyond, Arrays)[2], asked)
            level = level + (asked - level) * -jnp.expm1(-h / scene.lag_s)
        tip = None
        if scene.finger:
            tip = scene.tissue(finger - lever_m * theta, finger_dot - lever_m * theta_dot)
            finger_dot = finger_dot + h * (scene.input.at(t, Arrays) - tip) / scene.finger["mass_kg"]
            finger = finger + h * finger_dot
        forward, backward = scene.forces(t, theta, theta_dot, level if scene.lag_s else None, tip, None, Arrays)
        # Rounding can put it below 0; a friction of exactly 0 would hold without limit.
        moving = jnp.maximum(0.5 * (backward - forward), LEAST_N)
        dry = jnp.where(jnp.abs(theta_dot) < STANDS_RAD_S, moving + scene.static_n - scene.kinetic_n, moving)
        posed = model.replace(dof_frictionloss=model.dof_frictionloss.at[0].set(lever_m * dry)) if scene.dry else model
        data = data.replace(qfrc_applied=data.qfrc_applied.at[0].set(lever_m * 0.5 * (forward + backward)))
        data = mjx.step(posed, data)
        return (data, level, finger, finger_dot), (theta, theta_dot)

    # Counted in blocks, so that a run that takes too long can be given up.
    block = min(steps, 20_000)
    scan = jax.jit(lambda carry, begin: jax.lax.scan(step, carry, begin + jnp.arange(block)))
    zero = jnp.zeros((), data.qpos.dtype)
    carry = (data, zero, zero + lever_m * scene.theta_rad, zero + lever_m * scene.theta_dot_rad_s)
    scan = scan.lower(carry, 0).compile()
    found = []
    start = time.process_time()
    for begin in range(0, steps, block):
        carry, out = scan(carry, begin)
        found.append(np.asarray(out, dtype=float))
        if time.process_time() - start > TOO_LONG_S:
            raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {begin * h:.3g} s of {scene.duration_s:g} s")
    seconds = time.process_time() - start
    found = np.concatenate(found, axis=1)[:, :steps + 1]
    last = np.array([[float(carry[0].qpos[0])], [float(carry[0].qvel[0])]])
    if found.shape[1] == steps:
        found = np.concatenate([found, last], axis=1)
    return np.arange(steps + 1) * h, found[0], found[1], seconds
