"""A loop of one's own, as scripts have it: explicit Euler, and tanh in place of the sign of the velocity."""

import platform

from engine import Setting
from scene import Floats
from stepping import drive, smoothed, switched

NAME = "Loop of one's own"
SETTINGS = [
    Setting("euler_tanh", "default", "explicit Euler, friction by tanh(θ̇ / 0.01 rad/s), 1 ms", "no documentation: what scripts have",
            {"step_s": 1e-3, "law": smoothed(0.01), "order": "explicit"}),
    Setting("euler_sign", "more", "symplectic Euler, friction by the sign of θ̇, 1 ms", "",
            {"step_s": 1e-3, "law": switched, "order": "symplectic"}),
    Setting("projected", "best", "symplectic Euler; friction and stops as what a step needs of them, within their limits (Moreau's time stepping), 0.1 ms",
            "Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008), ch. 10",
            {"step_s": 1e-4, "law": None, "order": "projected"}),
]


def versions():
    return f"Python {platform.python_version()}"


def run(scene, setting):
    options = setting.options
    step_s, law, order = options["step_s"], options["law"], options["order"]
    theta, theta_dot = scene.theta_rad, scene.theta_dot_rad_s
    inverse = 1.0 / scene.inertia

    def step(bias_n, level_n, rest_n):
        nonlocal theta, theta_dot
        if order == "projected":
            free = theta_dot + step_s * inverse * bias_n
            # Friction's impulse stops the lever if its limit allows.
            dry = rest_n if theta_dot == 0.0 else level_n
            theta_dot = free - Floats.clip(free, -step_s * inverse * dry, step_s * inverse * dry)
            theta += step_s * theta_dot
        elif order == "symplectic":
            theta_dot += step_s * inverse * law(theta_dot, bias_n, level_n, rest_n)
            theta += step_s * theta_dot
        else:
            change = step_s * inverse * law(theta_dot, bias_n, level_n, rest_n)
            theta += step_s * theta_dot
            theta_dot += change
        if not scene.low_rad <= theta <= scene.high_rad:
            theta = Floats.clip(theta, scene.low_rad, scene.high_rad)
            theta_dot = 0.0

    return drive(scene, step_s, lambda: (theta, theta_dot), step)
