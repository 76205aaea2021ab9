"""A zwidth scene file as the force law that every engine is given.

All forces act on the lever's end: M L theta'' = F (docs/methods.md). Where the lever moves, F is one of two values,
`forward` or `backward`; where it stands, F is whatever between them holds it. An engine with dry friction of its own is
given the mean of the two as a force, and half of their difference as the friction's level.
"""

import copy
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path


class CannotSay(Exception):
    """An engine or a loop that cannot express a scene; the text says why."""


class Floats:
    """Operations of the law on plain numbers. Engines that trace or generate code bring their own."""

    sin = staticmethod(math.sin)
    remainder = staticmethod(math.fmod)

    @staticmethod
    def where(condition, yes, no):
        return yes if condition else no

    @staticmethod
    def clip(value, low, high):
        return min(max(value, low), high)


@dataclass(frozen=True)
class Signal:
    """An input of time: N, or rad for the end of a spring that is moved."""

    kind: str
    values: dict

    def at(self, t, ops=Floats):
        v = self.values
        if self.kind == "line":
            return v["value"] + v.get("rate", 0.0) * t
        if self.kind == "sine":
            return v["magnitude"] * (1.0 + ops.sin(v["omega_rad_s"] * t))
        # A ramp up and down over half of the period, twice.
        half = 0.5 * v["period_s"]
        phase = ops.remainder(t, half)
        rate = 4.0 * v["magnitude"] / half
        return ops.where(phase < 0.5 * half, rate * phase, rate * (half - phase))

    def piece(self, t):
        """The same between the bends around t, as one line; a signal without bends as it is."""
        if self.kind != "ramp":
            return self
        quarter = self.values["period_s"] / 4.0
        number = math.floor(t / quarter)
        rate = 2.0 * self.values["magnitude"] / quarter * (1.0 if number % 2 == 0 else -1.0)
        return Signal("line", {"value": self.at(t) - rate * t, "rate": rate})

    def breaks(self, end_s):
        """Times at which the signal bends."""
        if self.kind != "ramp":
            return []
        quarter = self.values["period_s"] / 4.0
        return [k * quarter for k in range(1, math.ceil(end_s / quarter))]


@dataclass(frozen=True)
class Zone:
    from_rad: float
    kind: str
    values: dict


class Scene:
    def __init__(self, file, path):
        """Of the tables of a scene file; `path` is what errors name."""
        self.path, self.id, self.name = Path(path), Path(path).stem, file["name"]
        self.mode, self.duration_s, self.step_s = file["mode"], file["duration_s"], file["step_s"]
        plant = file["plant"]
        self.mass_kg, self.lever_m = plant["mass_kg"], plant["lever_m"]
        self.low_rad, self.high_rad = plant.get("stops_rad", [-math.inf, math.inf])
        self.motor_n = file["motor"]["max_n"]
        brake = file["brake"]
        self.brake_n = brake["max_n"]
        # A passive brake is always in charge, and follows its command up and down with the first constant.
        self.lag_s = brake["lag_on_off_s"][0] if "lag_on_off_s" in brake else None
        if brake["law"] != "coulomb" or "dead_zone_n" in brake or "let_go_n" in brake or "lag_s" in file["motor"]:
            raise CannotSay(f"{path}: this bench reads brakes by law = \"coulomb\" without dead zone and let-go rule, and motors without lag")
        if self.lag_s is not None and self.mode != "passive":
            raise CannotSay(f"{path}: this bench reads lags of brakes in the passive mode alone")
        self.input = signal(path, file["input"])
        pull = file.get("pull")
        self.pull = pull and (pull["stiffness_n_per_rad"], signal(path, pull["displacement"]))
        friction = file.get("friction", {})
        self.static_n = friction.get("static_n", 0.0)
        self.kinetic_n = friction.get("kinetic_n", 0.0)
        self.viscous = friction.get("viscous_ns_per_rad", 0.0)
        self.finger = file.get("finger")
        if self.finger and (self.finger["law"] != "consistent" or "length_m" in self.finger):
            raise CannotSay(f"{path}: this bench reads fingers by law = \"consistent\" without length_m")
        self.zones = [zone(entry) for entry in file["environment"]["zones"]]
        start = file["start"]
        self.theta_rad, self.theta_dot_rad_s = start["theta_rad"], start.get("theta_dot_rad_s", 0.0)
        self.dry = self.kinetic_n > 0.0 or self.static_n > 0.0 or self.mode != "active"
        if "gravity" in file:
            raise CannotSay(f"{path}: this bench reads no gravity")

    @property
    def inertia(self):
        """M L: N at the lever's end per rad/s²."""
        return self.mass_kg * self.lever_m

    def edges(self):
        return [zone.from_rad for zone in self.zones[1:]]

    def piece(self, t):
        """The same scene with the pieces of its inputs that hold around t."""
        part = copy.copy(self)
        part.input = self.input.piece(t)
        part.pull = self.pull and (self.pull[0], self.pull[1].piece(t))
        return part

    def breaks(self):
        ends = self.input.breaks(self.duration_s) + (self.pull[1].breaks(self.duration_s) if self.pull else [])
        return sorted(set(ends))

    def tissue(self, x, x_dot):
        """What the finger's tissue, pressed by x (m), gives to the lever, N."""
        return self.finger["stiffness_n_per_m"] * x + self.finger["damping_ns_per_m"] * x_dot

    def command(self, low, high, full_up, theta, damping, zone, ops):
        """The force that the environment asks of an actuator with these limits, N; above 0 resists."""
        values = zone.values
        if zone.kind == "full":
            return high
        if zone.kind == "full_up":
            return full_up
        if zone.kind == "force":
            return ops.clip(values["force_n"], low, high)
        k, b = values["stiffness_n_per_rad"], values["damping_ns_per_rad"]
        return ops.clip(k * (theta - values["rest_rad"]) + b * damping, low, high)

    def commands(self, theta, theta_dot, zone, ops=Floats):
        """Forces of the actuators where the lever moves forward and backward, N, and the brake's level."""
        motor = lambda: self.command(-self.motor_n, self.motor_n, -self.motor_n, theta, theta_dot, zone, ops)
        brake = lambda damping: self.command(0.0, self.brake_n, self.brake_n, theta, damping, zone, ops)
        if self.mode == "active":
            u = motor()
            return -u, -u, 0.0
        if self.mode == "hybrid":
            level = brake(theta_dot)
            return -level, -motor(), level
        # The damping of a brake asks nothing of a lever that slips back.
        damped = zone.values.get("damping_ns_per_rad", 0.0) > 0.0
        level = brake(ops.where(theta_dot > 0.0, theta_dot, 0.0) if damped else 0.0)
        return -level, level, level

    def zone_at(self, theta, theta_dot=0.0):
        """Where it stands on an edge, a lever that goes down is below it."""
        at = 0
        for i, edge in enumerate(self.edges()):
            if theta > edge or (theta == edge and theta_dot >= 0.0):
                at = i + 1
        return at

    def forces(self, t, theta, theta_dot, level=None, tip=None, zone=None, ops=Floats):
        """Sum of all forces on the lever's end but for the stops' where it moves forward and where it moves backward,
        N. `level` is that of a brake with a lag, `tip` the force of a finger."""
        shared = self.input.at(t, ops) if tip is None else tip
        if self.pull:
            stiffness, displacement = self.pull
            shared = shared + stiffness * (displacement.at(t, ops) - theta)
        shared = shared - self.viscous * theta_dot
        if zone is not None:
            up, down, _ = self.commands(theta, theta_dot, self.zones[zone], ops)
        else:
            up, down, _ = self.commands(theta, theta_dot, self.zones[0], ops)
            for edge, beyond in zip(self.edges(), self.zones[1:]):
                other = self.commands(theta, theta_dot, beyond, ops)
                up = ops.where(theta >= edge, other[0], up)
                down = ops.where(theta >= edge, other[1], down)
        if level is not None:
            up, down = -level, level
        return shared + up - self.kinetic_n, shared + down + self.kinetic_n

    def level_asked(self, theta, theta_dot):
        """What a brake with a lag is commanded, N."""
        return self.commands(theta, theta_dot, self.zones[self.zone_at(theta, theta_dot)])[2]


def signal(path, table):
    (kind, values), = table.items()
    if kind not in ("line", "sine", "ramp"):
        raise CannotSay(f"{path}: this bench reads inputs line, sine and ramp, not {kind}")
    return Signal(kind, values)


def zone(entry):
    demand = entry["demand"]
    if isinstance(demand, str):
        return Zone(entry.get("from_rad", 0.0), demand, {})
    (kind, values), = demand.items()
    return Zone(entry.get("from_rad", 0.0), kind, values)


def read(path):
    return Scene(tomllib.loads(Path(path).read_text()), path)


def scenes(folder=Path(__file__).parent / "scenes"):
    order = ("stick", "slip_stick", "stop_push", "light_lever", "stiff_wall", "grazing", "two_events", "brake_let_go",
             "finger", "hybrid", "chattering", "ten_minutes")
    return [read(folder / f"{name}.toml") for name in order]
