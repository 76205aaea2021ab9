"""What the page says of the engines, beside what was measured."""

# In the table of the glance.
SHORT = {
    "stick": "stick", "slip_stick": "slip and stick", "stop_push": "stop", "light_lever": "light lever", "stiff_wall": "stiff wall",
    "grazing": "tangential touch", "two_events": "two events", "brake_let_go": "brake", "finger": "finger", "hybrid": "hybrid",
    "chattering": "chattering", "ten_minutes": "ten minutes",
}

HEAD = """
# Engines: other people's simulators on twelve scenes

This page is written by [`benches/engines/run.sh`](../benches/engines/README.md). It shows what the simulators that people of this field use make of a lever
with dry friction, stops, a virtual wall, a brake and a finger. Each scene is a file that zwidth reads (`benches/engines/scenes/`). The right
answer is that of `exact` ([verdict.md](verdict.md)). Every engine is given the same forces, and is run twice: at its **defaults**, and at the
**best** setting that its own documentation offers. What an engine has (dry friction of a joint, stops) it does itself; what it lacks (a
brake, a finger, the law of a hybrid drive) its user computes in the loop, step by step, as users do. Engines without
dry friction get tanh(θ̇ / 0.01 rad/s) in place of the sign of the velocity, as scripts have it.

Solvers of differential equations (SciPy, diffrax, CasADi, diffsol, Drake's best) are given one smooth equation per mode of motion, and end it by
the events that they locate. Their defaults are their default method and tolerances.
"""

GLANCE = """
Of how many scenes a run is right, by `zwidth judge` at its default tolerances, which are strict: θ off by more than half a degree, an event more than 1 ms late or a creep
above 10⁻⁵ °/s makes a run wrong. Of those that are wrong, how many a person could tell from the right motion ([trade.md](trade.md)). "Not run" are scenes that an engine cannot say, or that would have
taken more than 100 s.
"""

FIGURE = """
Processor's time of a run against its largest error of θ, for every setting that was tried. The lower left is better. Open marks are wrong by their verdict.
Fixed-step engines lie on lines of slope −1: ten times as exact costs ten times as much. Solvers that locate events are a thousand times to a
million times as exact for the same time.
"""

REMARKS = {
    "mujoco": """
What it does wrong at its defaults:

* **It creeps.** A joint's friction is a soft constraint: it needs a speed to give a force. Under half of its friction the lever turns at
  (force / inertia) (1 − d) / (d b), b = 2 / (0.95 × 0.02 s): 3.0°/s, whatever the step and the integrator; 30°/s with a tenth of the mass
  ([script](../findings/mujoco-frictionloss-creeps.sh)).
* **It runs on.** What friction should stop runs on, a light lever to four times the distance, and the no-slip solver hardly helps
  ([script](../findings/mujoco-noslip-stops-late.sh)).
* **Stops are soft.** A lever that arrives with 8.9 rad/s goes 3.2° beyond its stop at a step of 2 ms, and 3.8° at 0.02 ms.

The cure: `noslip_iterations` (10 or more), `solreffriction` of two steps, `solreflimit` of five (at two, which the documentation allows, fast levers bounce),
and a step of 0.1 ms. A lever that arrives at 15 rad/s still sinks 0.2° into its stop, and comes back from it slowly. Without no-slip, `solimpfriction="0.9999 0.9999 0.001"` leaves a thousandth of the creep.
""",
    "mjx": """
It creeps as MuJoCo does: 0.3 % less in float32, its default, and the same to 2·10⁻⁶ in float64. It takes `noslip_iterations` and ignores it without a word
([script](../findings/mjx-ignores-noslip.sh)). The cure is `solimpfriction` near 1, which leaves a thousandth. A `dof_frictionloss` that is
set to 0 in a model that was built with one holds the joint without limit ([script](../findings/mjx-zero-friction-holds.sh)): 10⁻⁹ lets it go. In float32 a lever at 0.7 rad that moves at 10⁻⁵ rad/s
stands still by rounding, and one that moves at twice that speed is half as fast again: set `jax_enable_x64`.
""",
    "mujoco_warp": """
It creeps as MuJoCo does, to three digits, in float32 only. It has the no-slip solver. On the processor a step takes milliseconds, a thousand times
MuJoCo's: it is made for thousands of worlds on a graphics card, and its times here say nothing about that.
""",
    "newton": """
A joint's friction is kept by two of its seven solvers for jointed bodies, SolverMuJoCo (which creeps as MuJoCo does) and SolverKamino (which stands). Featherstone,
SemiImplicit, XPBD and VBD drop it; Steel does unless asked, and then needs CUDA. None says so when it is given a model with friction
([script](../findings/newton-drops-joint-friction.sh)). Stops are springs of 10⁴ N m/rad by default in Featherstone and SemiImplicit: with the inertia of a
hand-held lever and a step of 1 ms they throw it off, to infinity. The cure is SolverKamino, at tens of milliseconds a step on a processor.
""",
    "drake": """
Its joints have damping, and no dry friction: a URDF's is ignored with a warning. With tanh in its place the plant creeps and chatters as any loop does. Its stops
are good. As a hybrid system with witness functions it is right on all that it was run on, with three precautions: the accuracy
must be set in the context, or events are not isolated; a witness function that is 0 where a mode begins is not "positive", so a return within one step
is missed (the lever then falls through the wall), which steps of at most 0.04 ms prevent; and a system in Python takes seconds.
""",
    "pybullet": """
The friction of a URDF is read, told by `getJointInfo`, and not simulated ([script](../findings/pybullet-urdf-joint-friction.sh)). As its guide
says, the joint's motor (velocity 0, force = friction) is the way, and it is right: the lever stands to the last bit. Every joint
begins with such a motor switched on, which holds a lever against anything. Links are damped by 0.04 unless `changeDynamics`
says otherwise. The default step of 1/240 s is long for a hand-held lever: it goes through a stiff wall.
""",
    "dart": """
Right wherever its step is short enough: `setCoulombFriction` stands, and stops hold. Limits of a joint do nothing until `setLimitEnforcement(True)`.
""",
    "siconos": """
Debian's python3-siconos 4.4.0, which calls itself 4.5.0. Made for this, and right at steps short enough for the scene: friction and stops are inclusions, solved in each step. Its friction needs a contact in two dimensions: here a slider
that 1 N presses on a plane, so that the coefficient is the level. Stops are met to a step's motion (no projection). The iterative solver
takes long where the lever stands, at a tolerance of 10⁻¹².
""",
    "diffrax": """
Without a root finder an event is the end of the step in which it happens, and adaptive steps are long where the motion is smooth: a ball from 1 m
lands 0.53 to 0.64 s late, some 4 m below the floor. This is what its documentation says, if read closely. `root_finder=optimistix.Newton(…)` is the cure, and
`dtmax` where an edge may be crossed twice within a step. float32 is JAX's default. The time to compile (10 to 60 s per scene) is not counted.
""",
    "casadi": """
Events are marked as experimental. Without a `transition`, an event sets every state to 0 and the run goes on
([script](../findings/casadi-event-zeroes-the-state.sh)). The third guess of an event's time is taken as the event, 5 ms off where outputs are far apart
([script](../findings/casadi-event-accepted-early.sh)). An event function that is 0 where a run begins (a lever on an edge) is not seen to
become negative before the next output, however short the steps. The cure: `transition`, `max_event_iter = 50`, a fine output grid.
""",
    "diffsol": """
The fastest of those that locate events. Its own resets are not safe: a ball that is reset to its floor falls through it
([script](../findings/pydiffsol-ball-through-the-floor.sh)). Here each mode is a model that ends at its stop condition; right on all scenes with tsit45, and a short
first part after an edge. Its default (bdf at 10⁻⁶) misses the tangential touch.
""",
    "scipy": """
Located events with a direction pass on all scenes. Two traps: max(0, θ − stop) as an event is 0 at once, and ends the run at its first step
([script](../findings/scipy-event-fires-at-rest.sh)); and events that come and go within one step are missed, as the documentation says (`max_step`,
`first_step`). With tanh for the friction RK45 creeps at 0.31°/s, whatever the tolerance, for that is what tanh says, and takes a hundred to a thousand times as long.
""",
    "loop": """
"Best" is not from a documentation here, but from the textbook that is named. Explicit Euler with tanh chatters or creeps wherever the lever should stand, and makes energy at a stiff wall. The sign of the velocity chatters. What a step needs
of friction and stops, within their limits (three lines: `projected` in `engines/loop.py`), is within a step's motion of the right answer on
all scenes.
""",
}

MORE = {
    ("scipy", "max_0"): "ends at its first step on every scene",
    ("mujoco", "noslip_default"): "no-slip alone: stands, and runs on",
    ("newton", "xpbd"): "no joint friction", ("newton", "featherstone"): "no joint friction; thrown off by its stops",
    ("newton", "semiimplicit"): "no joint friction; thrown off by its stops", ("newton", "vbd"): "no joint friction", ("newton", "steel"): "no joint friction on a processor",
}

ABSENT = """
* **Pinocchio** 4.1.0 (`pin`) has models of joint friction and of stops as constraints, and solvers for them, and no step of time: that would have
  been this bench's own. The simulator that is built on it, `simple`, is in none of the package registries that were looked at (Python, Debian).
* **Siconos** is in no Python registry; Debian's `python3-siconos` was taken.
* **Genesis, Brax, Rapier** were left out without a try: Genesis needs PyTorch (gigabytes), Brax hands jointed bodies to MJX, Rapier's
  Python package counts in float32 alone. **Chrono and SOFA** have no package of that kind for this Python in the registries that were looked at.
"""

CLAIMS = """
| said of | in the versions above |
|---|---|
| MuJoCo creeps by 3°/s whatever the step, faster the lighter | holds: 3.024°/s from 2 ms to 0.01 ms, 30.2°/s with a tenth of the mass; it follows from the documented defaults |
| MJX creeps 0.5 % less, Warp as MuJoCo | MJX 0.3 % less for this lever, by its float32: with float64 the difference is 2·10⁻⁶; Warp the same to three digits |
| with no-slip MuJoCo passes | stick and light lever: yes. What comes to rest: only with `solreffriction` of two steps as well |
| Newton drops joint friction in four of six solvers | in five of seven now (Steel is new, and drops it on a processor) |
| diffrax reports the end of a step as the event, 0.66 s late | holds: 0.53 s or 0.64 s late for a ball from 1 m, by its first step |
| diffsol falls through the floor after a reset to its edge | holds, for some solvers and resets; bdf with the height put to 0 bounces well |
| CasADi sets every state to 0 at an event | holds without a `transition` |
| SciPy's `max(0, x − wall)` fires everywhere but at contact | holds: at the first step |
| JAX's float32 stands still by rounding | holds: 10⁻⁵ rad/s at 0.7 rad with steps of 2 ms |
| DART, PyBullet's motor, located SciPy pass | hold, at steps short enough for the scene |
"""

SCENES = {
    "stick": "A lever of 50 g at 0.1 m under half of its dry friction (0.25 of 0.5 N), 2 s. It stands.",
    "slip_stick": "A spring of 20 N/rad whose end moves at 0.2 rad/s, static friction 1 N, kinetic 0.6 N, 3 s. Sticks and slips by 0.04 rad, eleven times.",
    "stop_push": "1 N to a stop at 0.2 rad, without friction, 1 s. Arrives after 44.7 ms with 8.9 rad/s and stays.",
    "light_lever": "As the first, with 5 g, 1 s.",
    "stiff_wall": "1 N on a wall of 2,000 N/rad and 1 N s/rad from 0.1 rad, rendered at 1 kHz, 0.3 s. Bounces that die out.",
    "grazing": "A swing to 0.1 rad without losses, and a wall of 5 N from 0.0999 rad: in contact for 0.09 ms each time, 2 s.",
    "two_events": "A ridge of 20 N, 1 mrad wide, crossed at 5 rad/s within 0.22 ms, then a stop at 45°, 0.2 s.",
    "brake_let_go": "A brake of 1 N under a growing push gives way at 0.833 s, is switched off beyond 0.1 rad with a lag of 15 ms, 1.5 s.",
    "finger": "A fingertip of 21 g behind tissue of 585 N/m pushes the lever over dry friction against a spring, 1 Hz, 2 s.",
    "hybrid": "The thesis' drive (`scenes/sine.toml`): the brake while compressing, the motor while holding and releasing, 4 s.",
    "chattering": "A lever on a spring, from 0.31 rad, that dry friction brings to rest at 0.01 rad after six half swings, 2 s.",
    "ten_minutes": "A push of 0.25 Hz over dry friction against a spring for 600 s: 600 stops and starts.",
}


def extremes(told):
    """The table of random scenes."""
    kinds = ("stands", "arrives", "stops")
    lines = ["## Random scenes, up to ten thousand", "",
             "Levers of random mass (2 to 200 g), length (4 to 20 cm) and dry friction (0.05 to 1 N), judged by `zwidth judge` (`benches/engines/extremes.py`, seed "
             f"{told[0]['seed']}): under 5 to 95 % of its friction a lever *stands*; pushed beyond it, it *arrives* at a stop at a known time and stays; thrown, it *stops* at a known "
             "angle. Each has an answer in closed form too; the last column counts runs that the judge calls right and that are further from it than half a degree, a millisecond and "
             "two steps, or a creep of 10⁻⁵ rad/s.", "",
             "| engine | setting | scenes | stands: right | creeps | chatters | other | arrives: right | late | beyond the stop | other | stops: right | creeps | chatters | late | other | creep, median (largest), °/s | against the closed form |",
             "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"]
    named = {"stands": ("stands", "creeps", "chatters"), "arrives": ("right", "event late", "goes beyond the stop"), "stops": ("right", "creeps", "chatters", "event late")}
    for run in told:
        cells = [run["name"], run["about"], f"{run['number']:,}"]
        for kind in kinds:
            counts = run["counts"][kind]
            cells += [str(counts.get(word, 0)) for word in named[kind]]
            cells.append(str(sum(n for word, n in counts.items() if word not in named[kind])))
        creep = run["creep"]
        cells.append(f"{creep['median_deg_s']:.2g} ({creep['largest_deg_s']:.2g})" if creep else "–")
        cells.append(str(run["contradicted"]))
        lines.append("| " + " | ".join(cells) + " |")
    return lines
