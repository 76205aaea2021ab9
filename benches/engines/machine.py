"""A scene as a machine of its modes of motion, for solvers of smooth equations that locate events.

In each mode (forward, backward, at rest; a zone of the environment) the right-hand side is smooth but for bends where an
actuator saturates. A mode ends where one of its guards falls through 0. The state is theta, theta_dot, and where the
scene has them the level of a brake with a lag, and position and velocity of the finger relative to the lever's end.
"""

from dataclasses import dataclass

import numpy as np

from scene import Floats

# A scene of this bench has far fewer modes per second than this; more means that an event is found again and again.
MOST_MODES_PER_S = 2000
# Forces below this do not move a lever at rest: they are what rounding leaves of none, N.
ROUNDING_N = 1e-12


@dataclass(frozen=True)
class Mode:
    """motion is 1, -1 or 0. Where there is nothing dry it is 1 for any motion: the forces are then the same either way."""

    motion: int
    zone: int


class Machine:
    def __init__(self, scene):
        self.scene = scene
        self.lagged = scene.lag_s is not None
        self.size = 2 + self.lagged + 2 * (scene.finger is not None)

    def start(self):
        scene = self.scene
        y = [scene.theta_rad, scene.theta_dot_rad_s] + [0.0] * (self.size - 2)
        zone = scene.zone_at(scene.theta_rad, scene.theta_dot_rad_s)
        if scene.theta_dot_rad_s != 0.0:
            return y, Mode(1 if scene.theta_dot_rad_s > 0.0 or not scene.dry else -1, zone)
        return y, self.from_rest(0.0, y, zone)

    def parts(self, y):
        """Level of the brake, and the finger's two."""
        level = y[2] if self.lagged else None
        return level, (y[-2], y[-1]) if self.scene.finger else None

    def forces(self, t, y, zone, ops=Floats):
        level, finger = self.parts(y)
        tip = None if finger is None else self.scene.tissue(*finger)
        return self.scene.forces(t, y[0], y[1], level, tip, zone, ops)

    def from_rest(self, t, y, zone):
        """The mode of a lever that has come to rest."""
        scene = self.scene
        margin = scene.static_n - scene.kinetic_n + ROUNDING_N
        forward, backward = self.forces(t, y, zone)
        if forward > margin and y[0] < scene.high_rad:
            return Mode(1, zone)
        if backward < -margin and y[0] > scene.low_rad:
            return Mode(-1 if scene.dry else 1, zone)
        return Mode(0, zone)

    def slope(self, mode, ops=Floats):
        """Right-hand side f(t, y) of a mode, as a list."""
        scene = self.scene

        def f(t, y):
            level, finger = self.parts(y)
            if mode.motion == 0:
                out = [0.0 * y[0], 0.0 * y[0]]
            else:
                force = self.forces(t, y, mode.zone, ops)[0 if mode.motion > 0 else 1]
                out = [y[1], force / scene.inertia]
            if level is not None:
                asked = scene.commands(y[0], y[1], scene.zones[mode.zone], ops)[2]
                out.append((asked - level) / scene.lag_s)
            if finger is not None:
                net = scene.input.at(t, ops) - scene.tissue(*finger)
                out += [finger[1], net / scene.finger["mass_kg"] - scene.lever_m * out[1]]
            return out
        return f

    def guards(self, mode, ops=Floats):
        """What ends a mode where it falls through 0, as pairs of a name and g(t, y)."""
        scene, zone = self.scene, mode.zone
        if mode.motion == 0:
            margin = scene.static_n - scene.kinetic_n + ROUNDING_N
            return [("forward", lambda t, y: margin - self.forces(t, y, zone, ops)[0]),
                    ("backward", lambda t, y: margin + self.forces(t, y, zone, ops)[1])]
        guards, edges = [], scene.edges()
        if scene.dry:
            guards.append(("rest", lambda t, y: mode.motion * y[1]))
        if mode.motion > 0:
            guards.append(("stop_high", lambda t, y: scene.high_rad - y[0]))
            if zone < len(edges):
                guards.append(("edge_up", lambda t, y: edges[zone] - y[0]))
        if mode.motion < 0 or not scene.dry:
            guards.append(("stop_low", lambda t, y: y[0] - scene.low_rad))
            if zone > 0:
                guards.append(("edge_down", lambda t, y: y[0] - edges[zone - 1]))
        return guards

    def after(self, t, y, mode, guard):
        """State and mode after an event."""
        scene, y = self.scene, list(y)
        if guard == "edge_up":
            y[0] = scene.edges()[mode.zone]
            return y, Mode(mode.motion, mode.zone + 1)
        if guard == "edge_down":
            y[0] = scene.edges()[mode.zone - 1]
            return y, Mode(mode.motion, mode.zone - 1)
        if guard == "forward":
            return y, Mode(1, mode.zone)
        if guard == "backward":
            return y, Mode(-1 if scene.dry else 1, mode.zone)
        if guard != "rest":
            y[0] = scene.high_rad if guard == "stop_high" else scene.low_rad
        before, y[1] = y[1], 0.0
        if scene.finger:  # its velocity is relative to the lever's end
            y[-1] += scene.lever_m * before
        return y, self.from_rest(t, y, mode.zone)

    def blocked(self, y, mode):
        """Guards of a lever at rest that a stop makes void."""
        return {name for name, at in (("forward", y[0] >= self.scene.high_rad), ("backward", y[0] <= self.scene.low_rad))
                if mode.motion == 0 and at}


def run(scene, phase, times):
    """theta and theta_dot at the times. `phase(machine, mode, t0, t1, y0, times, blocked)` runs one mode and returns the
    states at the times within it (a row each), its end, the state there, and the guard that ended it, or None."""
    machine = Machine(scene)
    y, mode = machine.start()
    t, done = 0.0, 0
    out = np.empty((2, len(times)))
    ends = [*scene.breaks(), scene.duration_s]
    most = MOST_MODES_PER_S * scene.duration_s + 100
    while ends:
        machine = Machine(scene.piece(0.5 * (t + ends[0])))
        most -= 1
        if most < 0:
            raise ArithmeticError(f"an event is found again and again at {t} s")
        until = done + int(np.searchsorted(times[done:], ends[0], side="right"))
        states, t_end, y_end, guard = phase(machine, mode, t, ends[0], y, times[done:until], machine.blocked(y, mode))
        found = len(states)
        if found:
            out[:, done:done + found] = np.asarray(states)[:, :2].T
        done += found
        t, y = t_end, list(y_end)
        if guard is None:
            ends.pop(0)
        else:
            y, mode = machine.after(t, y, mode, guard)
    out[:, done:] = np.array(y[:2])[:, None]
    return out
