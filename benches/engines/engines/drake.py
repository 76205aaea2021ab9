"""Drake: a MultibodyPlant that is stepped, and the lever as a hybrid system with witness functions."""

import time
from importlib.metadata import version

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import LeafSystem, UnrestrictedUpdateEvent, WitnessFunctionDirection

from engine import Setting
from machine import Machine, Mode
from stepping import TOO_LONG_S, TooSlow, drive, smoothed

NAME = "Drake"
BOOK = "Drake documentation, "
SETTINGS = [
    Setting("plant", "default", "MultibodyPlant(time_step = 1 ms); friction by tanh(θ̇ / 0.01 rad/s) as a force, for a joint has none",
            BOOK + "MultibodyPlant (“Discrete systems”, “joint limits”); RevoluteJoint (damping alone)", {"step_s": 1e-3}),
    Setting("witness", "best", "a LeafSystem with witness functions, runge_kutta3, accuracy 1e-9; steps of at most 0.04 ms where there are edges to cross",
            BOOK + "System::GetWitnessFunctions, Simulator (“witness functions”), SimulatorConfig (integration_scheme, accuracy)", {"accuracy": 1e-9}),
    Setting("plant_100us", "more", "MultibodyPlant(time_step = 0.1 ms)", "", {"step_s": 1e-4}),
]


def versions():
    return f"drake {version('drake')}"


def run(scene, setting):
    return stepped(scene, **setting.options) if "step_s" in setting.options else hybrid(scene, **setting.options)


def stepped(scene, step_s):
    plant = MultibodyPlant(step_s)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    inertia = SpatialInertia(scene.mass_kg, [scene.lever_m, 0, 0], UnitInertia.PointMass([scene.lever_m, 0, 0]))
    body = plant.AddRigidBody("lever", inertia)
    joint = plant.AddJoint(RevoluteJoint("lever", plant.world_frame(), body.body_frame(), [0, 0, 1], scene.low_rad, scene.high_rad, 0.0))
    plant.AddJointActuator("push", joint)
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    joint.set_angle(context, scene.theta_rad)
    joint.set_angular_rate(context, scene.theta_dot_rad_s)
    push = plant.get_actuation_input_port().FixValue(context, [0.0])
    simulator.Initialize()
    law = smoothed(0.01)
    steps = 0

    def read():
        return joint.get_angle(context), joint.get_angular_rate(context)

    def step(bias_n, level_n, rest_n):
        nonlocal steps
        steps += 1
        push.GetMutableData().set_value(np.array([scene.lever_m * law(joint.get_angular_rate(context), bias_n, level_n, rest_n)]))
        simulator.AdvanceTo(steps * step_s)

    return drive(scene, step_s, read, step)


class Lever(LeafSystem):
    """The machine of modes, its mode as abstract state."""

    def __init__(self, scene):
        super().__init__()
        self.scene = scene
        self.machine = Machine(scene)
        y, mode = self.machine.start()
        self.first = y
        self.DeclareContinuousState(len(y))
        self.mode = self.DeclareAbstractState(Value((mode.motion, mode.zone)))
        self.witnesses = {}

    def part(self, t):
        """The machine with the piece of the input around t."""
        return Machine(self.scene.piece(t)) if self.scene.breaks() else self.machine

    def now(self, context):
        mode = Mode(*context.get_abstract_state(int(self.mode)).get_value())
        return context.get_time(), context.get_continuous_state_vector().CopyToVector().tolist(), mode

    def DoCalcTimeDerivatives(self, context, derivatives):
        t, y, mode = self.now(context)
        derivatives.get_mutable_vector().SetFromVector(self.part(t).slope(mode)(t, y))

    def DoGetWitnessFunctions(self, context):
        t, y, mode = self.now(context)
        blocked = self.machine.blocked(y, mode)
        return [self.witness(mode, name, g) for name, g in self.machine.guards(mode) if name not in blocked]

    def witness(self, mode, name, g):
        if (mode, name) not in self.witnesses:
            def value(context):
                t, y, _ = self.now(context)
                return dict(self.part(t).guards(mode))[name](t, y)

            def change(context, event, state):
                t, y, _ = self.now(context)
                y, after = self.machine.after(t, y, mode, name)
                state.get_mutable_continuous_state().SetFromVector(np.array(y))
                state.get_mutable_abstract_state(int(self.mode)).set_value((after.motion, after.zone))

            self.witnesses[mode, name] = self.MakeWitnessFunction(
                name, WitnessFunctionDirection.kPositiveThenNonPositive, value, UnrestrictedUpdateEvent(change))
        return self.witnesses[mode, name]


def hybrid(scene, accuracy):
    lever = Lever(scene)
    simulator = Simulator(lever)
    ResetIntegratorFromFlags(simulator, "runge_kutta3", scene.step_s)
    simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    if scene.edges():
        # A witness function is looked at at the ends of steps alone, and one that begins at 0 must be seen above it.
        simulator.get_mutable_integrator().set_maximum_step_size(4e-5)
    context = simulator.get_mutable_context()
    context.SetAccuracy(accuracy)  # how closely an event is isolated
    context.get_mutable_continuous_state_vector().SetFromVector(np.array(lever.first))
    simulator.Initialize()
    steps = round(scene.duration_s / scene.step_s)
    times, out = np.linspace(0.0, scene.duration_s, steps + 1), np.empty((2, steps + 1))
    start = time.process_time()
    for k, t in enumerate(times):
        simulator.AdvanceTo(t)
        out[:, k] = context.get_continuous_state_vector().CopyToVector()[:2]
        if time.process_time() - start > TOO_LONG_S:
            raise TooSlow(f"given up after {TOO_LONG_S:g} s, at {t:.3g} s of {scene.duration_s:g} s")
    return times, out[0], out[1], time.process_time() - start
