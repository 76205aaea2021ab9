//! A program for Drake: a leaf system whose events are witness functions.

use super::equations::{ACTUATORS, INPUTS, MOTION, NUMBERS, SAMPLES, WRITE};
use super::writer::{Comment, Form, Writer};

pub(super) const WRITER: Writer = Writer {
    files: &[Form {
        ending: "drake.py",
        comment: Comment::Hash,
        templates: &[
            ("", HEAD),
            ("", NUMBERS),
            ("", INPUTS),
            ("", ACTUATORS),
            ("", MOTION),
            ("", SAMPLES),
            ("", SYSTEM),
            ("", WRITE),
        ],
    }],
    remarks: r"
        |theta is the lever's angle in rad, theta = 0 is upright, and forces are at the lever's end: MASS LEVER theta'' = their sum. Above 0 is into the object.
        |Run it: `python FILE trajectory.csv` writes t_s, theta_rad, theta_dot_rad_s every STEP seconds.
        |The lever is a leaf system with its own equations, not a MultibodyPlant: a plant's joints have no dry friction that holds, and no stops that are rigid. As a body for a plant, write the scene as sdf or urdf.
        |Drake looks for events between its own steps and samples: two of one kind within a step are missed. MAX_STEP bounds the steps.
zones   |At an edge of the environment where both sides push back, a bounce of less than 2e-10 rad is rest.
hybrid lags|Lagging actuators follow the command of holding or releasing while the lever rests.
    ",
    refused: &[],
};

const HEAD: &str = r#"
        |@head@
        |
series  |import bisect
        |import math
        |import sys
        |from dataclasses import dataclass
        |from functools import partial
        |
        |import numpy as np
        |from pydrake.common.value import AbstractValue
        |from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
        |from pydrake.systems.framework import LeafSystem, UnrestrictedUpdateEvent, WitnessFunctionDirection
        |
"#;

const SYSTEM: &str = r#"
        |
        |
        |ACCURACY = 1e-8  # of a step, relative; events are located to it
        |MAX_STEP = DURATION / 400  # s; events are looked for between steps
        |JUST_ABOVE = 1e-12  # N, rad, rad/s: a witness falls only from above 0, and a region may begin at 0
        |KINDS = ("reversal", "zone", "stop", "forward", "backward", "let go", "pressed", "stretched", "lifts off")
        |
        |
        |class Lever(LeafSystem):
        |    """The state of the equations above; the region that holds is an abstract state."""
        |
        |    def __init__(self):
        |        super().__init__()
        |        self.DeclareContinuousState(@entries@)
        |        self.DeclareAbstractState(AbstractValue.Make(Region(0.0)))
        |        falls = WitnessFunctionDirection.kPositiveThenNonPositive
        |        self.witnesses = {}
        |        for kind in KINDS:
        |            event = UnrestrictedUpdateEvent(partial(self.carry_out, kind))
        |            self.witnesses[kind] = self.MakeWitnessFunction(kind, falls, partial(self.left, kind), event)
        |
        |    def now(self, context):
        |        """Time, state and region."""
        |        return context.get_time(), context.get_continuous_state_vector().CopyToVector(), context.get_abstract_state(0).get_value()
        |
        |    def DoCalcTimeDerivatives(self, context, derivatives):
        |        derivatives.SetFromVector(slope(*self.now(context)))
        |
        |    def DoGetWitnessFunctions(self, context):
        |        return [self.witnesses[kind] for kind in exits(self.now(context)[2])]
        |
        |    def left(self, kind, context):
        |        """Above 0 until the event is there."""
        |        t, y, region = self.now(context)
        |        return exits(region)[kind](t, y) + JUST_ABOVE
        |
        |    def carry_out(self, kind, context, event, state):
        |        t, y, region = self.now(context)
        |        region = after(kind, t, y, region)
        |        state.get_mutable_continuous_state().SetFromVector(y)
        |        state.get_mutable_abstract_state(0).set_value(region)
        |
        |
        |def simulate():
        |    """Times in steps of STEP, s, and the state at each."""
        |    times = sample_times()
        |    states = np.empty((len(times), @entries@))
        |    lever = Lever()
        |    simulator = Simulator(lever)
        |    ResetIntegratorFromFlags(simulator, "runge_kutta3", MAX_STEP).set_target_accuracy(ACCURACY)
        |    context = simulator.get_mutable_context()
        |    context.SetAccuracy(ACCURACY)
        |    end = stretch_end(0.0)
        |    region = settled(0.0, first_state(), end / 2)
        |    context.SetContinuousState(first_state())
        |    context.SetAbstractState(0, region)
        |    simulator.Initialize()
        |    for i, time in enumerate(times):
        |        while end < time:  # the next stretch of the input
        |            simulator.AdvanceTo(end)
        |            t, y, region = lever.now(context)
        |            end = stretch_end(t)
        |            context.SetAbstractState(0, settled(t, y, (t + end) / 2@region_contact@))
        |            simulator.Initialize()
        |        simulator.AdvanceTo(time)
        |        states[i] = lever.now(context)[1]
        |    return times, states
"#;
