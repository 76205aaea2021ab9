"""
A study's tables as Arrow, and what the stages compute on one's own arrays.
"""

from _typeshed import Incomplete, SupportsGetItem
from os import PathLike
from types import CapsuleType
from typing import Any, SupportsFloat, SupportsIndex, final

@final
class Characteristic:
    """
    The response of an actuator or a sensor to its command: every candidate curve, and which one was chosen, why.
    """
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @property
    def model(self, /) -> str:
        """
        The chosen model.
        """
    @property
    def models(self, /) -> Table:
        """
        A row for each candidate: its errors, and why it was chosen or not.
        """
    @property
    def noise(self, /) -> float | None:
        """
        Scatter that no curve explains, in the unit of the response; None without a degree of freedom.
        """
    @property
    def parameters(self, /) -> Table:
        """
        A row for each parameter of each candidate, with its bootstrap interval.
        """
    @property
    def reason(self, /) -> str:
        """
        Why it was chosen, in a sentence.
        """

@final
class Column:
    """
    One column: `numpy.asarray(c)`, `pyarrow.array(c)`, `polars.Series(c)`, or `c.to_list()`.
    """
    def __array__(self, /, dtype: Any | None = None, copy: bool | None = None) -> Any:
        """
        A copy for NumPy. Numbers that are missing are NaN, because NumPy knows no other way.
        """
    def __arrow_c_array__(self, /, requested_schema: Any | None = None) -> tuple[CapsuleType, CapsuleType]: ...
    def __arrow_c_schema__(self, /) -> CapsuleType: ...
    def __len__(self, /) -> int: ...
    def __repr__(self, /) -> str: ...
    @property
    def meaning(self, /) -> str:
        """
        What it means.
        """
    @property
    def name(self, /) -> str:
        """
        Its name, with its unit as suffix.
        """
    def to_list(self, /) -> list:
        """
        Its values; None where one is missing.
        """
    @property
    def unit(self, /) -> str:
        """
        Its unit.
        """

@final
class Judgement:
    """
    What a trajectory is worth.
    """
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @property
    def faults(self, /) -> Table:
        """
        A row for each fault, the gravest first.
        """
    @property
    def table(self, /) -> Table:
        """
        One row: errors, energy, creep, how far the right answer is proven.
        """
    @property
    def verdict(self, /) -> str:
        """
        "right", "stands", or the gravest fault: "late", "creeps", "energy made", …
        """

@final
class Psychometric:
    """
    What the answers of one person tell: a threshold and a JND with their intervals, or why there are none.
    """
    def __repr__(self, /) -> str: ...
    @property
    def deviance(self, /) -> float | None:
        """
        The deviance of the curve.
        """
    @property
    def guess(self, /) -> float | None:
        """
        The guess rate γ.
        """
    @property
    def jnd(self, /) -> float | None:
        """
        The JND, half of x(F = 3/4) − x(F = 1/4), in the unit of the stimulus.
        """
    @property
    def jnd_interval(self, /) -> tuple[float | None, float | None]:
        """
        Its profile-likelihood interval.
        """
    @property
    def lapse(self, /) -> float | None:
        """
        The lapse rate λ.
        """
    def share(self, /, level: SupportsFloat | SupportsIndex) -> float | None:
        """
        The share of positive answers that the curve has at a level; None without a curve.
        """
    @property
    def threshold(self, /) -> float | None:
        """
        The level at F = 1/2, in the unit of the stimulus.
        """
    @property
    def threshold_interval(self, /) -> tuple[float | None, float | None]:
        """
        Its profile-likelihood interval.
        """
    @property
    def trials(self, /) -> int:
        """
        Trials that were answered.
        """
    @property
    def verdict(self, /) -> str:
        """
        "estimated", or why not: "below" or "above" the levels, "steep", "falling", "flat", "too few".
        """

@final
class Runs:
    """
    Runs of a scene, one for each value of the keys that were varied.
    """
    def __len__(self, /) -> int: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @property
    def table(self, /) -> Table:
        """
        A row for each run: the keys that were varied, the largest angle and when, the state at the end, events, and if the
        runs were judged, the verdict.
        """
    def trajectory(self, /, run: SupportsIndex) -> Table:
        """
        The samples of a run, counted from 0: time, state, forces by part. Only where `samples=True` asked for them.
        """

@final
class Samples:
    """
    The samples of many trials: keys of the trial, then signals, one batch for each trial. Files are read as a reader asks
    for batches, so a study of any length can be read; each reader begins anew. `for batch in samples` gives a trial at a
    time.
    """
    def __arrow_c_schema__(self, /) -> CapsuleType: ...
    def __arrow_c_stream__(self, /, requested_schema: Any | None = None) -> CapsuleType: ...
    def __len__(self, /) -> int:
        """
        How many trials there are.
        """
    def __repr__(self, /) -> str: ...
    @property
    def columns(self, /) -> list[str]:
        """
        The names of the columns.
        """

@final
class Study:
    """
    A study as it is on the disk: its trials, samples, answers and people, and what a run made of them. Nothing is written.

    Trials of sealed sessions do not count until `zwidth unseal`: their modes are codes, and their samples are not given.
    """
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str:
        """
        The study as a notebook shows it: its matrix of means, and the figure of every difference.
        """
    def answers(self, /) -> Table:
        """
        Every answer as it was given, one row each; `counts` says whether it enters anything.
        """
    def contrasts(self, /) -> Table:
        """
        Every difference between modes with its interval, test and verdict, as the last run wrote them. Numbers are in the
        unit that the column `unit` names. Refused unless they are up to date.
        """
    def figure(self, /, name: str) -> str:
        """
        A figure of the last run as SVG, by its name. Refused unless it is up to date.
        """
    @property
    def figures(self, /) -> list[str]:
        """
        The names of the figures that the last run drew.
        """
    @property
    def findings(self, /) -> list[str]:
        """
        What could not be read and was left out, and what is to be read with care: a sentence each.
        """
    @property
    def id(self, /) -> str:
        """
        Its id, the name of its folder.
        """
    def metrics(self, /) -> Table:
        """
        The metrics of every trial that counts, as the last run wrote them: one row a trial, SI units. Refused unless they are
        up to date.
        """
    def participants(self, /) -> Table:
        """
        Everybody who has a trial or a row in the participants' file, with what that file says of them.
        """
    def samples(self, /, columns: SupportsGetItem[int, str] | None = None) -> Samples:
        """
        The samples of every trial that counts, one batch for each trial: participant, session, trial, repeat, environment,
        mode, source, then the columns asked for, such as `["t_s", "theta_rad", "force_ex_n"]`; all that any trial has without
        `columns`, null where a trial lacks one. SI units, as they were recorded, never resampled.
        """
    def thresholds(self, /, *, over_people: bool = False) -> Table:
        """
        Thresholds and JNDs as the last run wrote them: of everybody in each session and mode, or with `over_people=True` those
        over people. Refused unless they are up to date; a study without tasks has none.
        """
    @property
    def title(self, /) -> str:
        """
        Its title.
        """
    def trial(self, /, participant: str, session: str, number: SupportsIndex) -> Trial:
        """
        A trial that counts, by participant, session and number: `study.trial("P01", "S01", 3)`.
        """
    @property
    def trials(self, /) -> Table:
        """
        Every trial: who, when, condition, source, whether it counts (`counts`), and why not (`why_not`).
        """

@final
class Table:
    """
    A table: columns that know their unit and what they mean.

    pyarrow, polars and pandas read it by Arrow's interface: `pyarrow.table(t)`, `polars.DataFrame(t)`,
    `pandas.DataFrame.from_arrow(t)`. Units and meanings come along as the metadata of fields. Without any of them,
    `to_dict()` gives lists.
    """
    def __arrow_c_schema__(self, /) -> CapsuleType: ...
    def __arrow_c_stream__(self, /, requested_schema: Any | None = None) -> CapsuleType: ...
    def __getitem__(self, column: str, /) -> Column: ...
    def __len__(self, /) -> int: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str:
        """
        The table as a notebook shows it, in the units of people.
        """
    @property
    def columns(self, /) -> list[str]:
        """
        The names of the columns.
        """
    @property
    def meanings(self, /) -> dict[str, str]:
        """
        What each column means.
        """
    @property
    def notes(self, /) -> list[str]:
        """
        What is to be read below the table.
        """
    @property
    def title(self, /) -> str:
        """
        The title, a phrase.
        """
    def to_dict(self, /) -> dict:
        """
        The columns as lists by name; None where a value is missing.
        """
    @property
    def units(self, /) -> dict[str, str]:
        """
        The unit of each column; "1" of a pure number or a word, "" where a column `unit` says it row by row.
        """

@final
class Trial:
    """
    A trial: what is known of it, and its samples by name (`trial["theta_rad"]`).
    """
    def __arrow_c_schema__(self, /) -> CapsuleType: ...
    def __arrow_c_stream__(self, /, requested_schema: Any | None = None) -> CapsuleType: ...
    def __getitem__(self, column: str, /) -> Column: ...
    def __len__(self, /) -> int: ...
    def __repr__(self, /) -> str: ...
    @property
    def columns(self, /) -> list[str]:
        """
        The names of its columns.
        """
    @property
    def environment(self, /) -> str:
        """
        What was rendered.
        """
    def metrics(self, /) -> Table:
        """
        Its metrics, as a run computes them, without those that rest on the identified plant or come from outside: a table of
        one row.
        """
    @property
    def mode(self, /) -> str:
        """
        How it was rendered; a code in the file of a sealed session.
        """
    @property
    def number(self, /) -> int:
        """
        Its number in the session, from 1.
        """
    @property
    def participant(self, /) -> str:
        """
        Who.
        """
    @property
    def repeat(self, /) -> int:
        """
        Which repeat of its condition, from 1.
        """
    @property
    def session(self, /) -> str:
        """
        In which session.
        """
    @property
    def source(self, /) -> str:
        """
        Where its numbers come from: recorded, twin, imported or simulated. Of twin and simulated nothing was measured.
        """

def fit_characteristic(command: Any, response: Any, *, command_unit: str = "V", response_unit: str = "N", resamples: SupportsIndex = 1000, seed: SupportsIndex = 1, level: SupportsFloat | SupportsIndex = 0.95) -> Characteristic:
    """
    Fits every candidate curve to the response of an actuator or a sensor and chooses one by cross-validation, as
    `zwidth run` does of a study's sweeps.

    `command` and `response` are arrays of one sweep, or lists of arrays with one for each sweep. Intervals are from
    `resamples` bootstrap resamples at `level`; of one `seed` always the same.
    """

def fit_psychometric(level: Any, trials: Any, positive: Any, *, asks: str = "which_was_more", sigmoid: str = "norm", lapse: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] = ..., constant: bool = True, confidence: SupportsFloat | SupportsIndex = 0.95) -> Psychometric:
    """
    The psychometric function of one person's answers, by maximum likelihood with profile intervals.

    `level` in the unit of the stimulus, `trials` and `positive` (more, right, or yes) at each, as float64. `asks` is
    "which_was_more" (γ = λ), "right_or_wrong" (γ = 1/2) or "yes_no" (γ free); `sigmoid` "norm", "logistic" or "weibull";
    `lapse` the least and the largest λ. `constant` says that levels were chosen before the first answer; of staircases
    answers are not overdispersed by their levels. The lapse's bounds decide more than the sigmoid does.
    """

def judge(scene: Any, t: Any, theta: Any, velocity: Any | None = None, *, force: Any | None = None, tolerance_rad: SupportsFloat | SupportsIndex | None = None, tolerance_s: SupportsFloat | SupportsIndex | None = None, **parameters) -> Judgement:
    """
    Judges a trajectory that another program computed for a scene, as `zwidth judge` does.

    `t` in s from the scene's start, `theta` in rad, `velocity` in rad/s (computed by central differences if it is not given),
    `force` that the program applied, N. `tolerance_rad` and `tolerance_s` are allowed of the angle and of an event's time.
    Keyword arguments change numbers of the scene, as for `simulate`.
    """

def means_by_branch(t: SupportsGetItem[int, Any], theta: SupportsGetItem[int, Any], force: SupportsGetItem[int, Any], scene: dict, *, velocity: SupportsGetItem[int, Any] | None = None) -> Table:
    """
    Mean force over the angle by branch (in, held, out), as a study's averages are made: at one angle the mean of the forces
    of all movements, with SD and a pointwise interval.

    `t`, `theta`, `force` and `velocity` are lists of arrays, one for each movement, in the units of `trial_metrics`; so is
    `scene`, which may not be free.
    """

def onset(t: Any, velocity: Any, *, onset_rad_s: SupportsFloat | SupportsIndex | None = None, offset_rad_s: SupportsFloat | SupportsIndex | None = None) -> tuple[float | None, float | None]:
    """
    When a movement begins and ends, s: the first time with a speed above `onset_rad_s`, and the first one below
    `offset_rad_s` after the speed was last above `onset_rad_s`; None where there is none.

    `t` in s, `velocity` in rad/s; thresholds without a value are those of a study, 10 °/s and 5 °/s.
    """

def read_study(root: str | PathLike[str], study: str) -> Study:
    """
    Reads the study `study` below `root`: its study.toml, the footers of its trials, sessions and events. Samples are read
    when they are asked for.
    """

def read_trial(path: str | PathLike[str]) -> Trial:
    """
    Reads a trial's file, all of its columns, and checks them as `zwidth verify` does. SI units.
    """

def simulate(scene: Any, *, solver: str = "exact", tolerance: SupportsFloat | SupportsIndex = 1e-9, judged: bool = False, samples: bool = False, **parameters) -> Runs:
    """
    Runs a scene, once or for each value of some of its keys.

    `scene` is the path of a scene's file, or a dict as `tomllib.load` gives it. Keyword arguments name numbers of the scene,
    sections apart by two underscores (`plant__mass_kg=0.06`, `environment__zones__0__from_rad=…`), in the units of its file:
    a number for all runs, or arrays of float64 of one length with a value for each run. `step_s` is the time between samples.

    `solver` is one of those of `zwidth simulate`, `tolerance` its relative error per step where it adapts its step. `judged`
    says what each run is worth, which takes several times as long; `samples` keeps the samples.

    Runs go side by side on all cores, without the GIL. Ctrl-C ends them. More than 2**27 numbers are refused.
    """

def smoothness(t: Any, velocity: Any) -> float | None:
    """
    Smoothness of a movement: the spectral arc length of its speed (SPARC; Balasubramanian et al. 2015), dimensionless and
    below 0; a minimum-jerk movement has −1.40. None for fewer than three samples, fewer than 20 a second, or no movement.

    `t` in s, `velocity` in any unit; its sign does not count.
    """

def stability_limits(scene: Any, **quantities) -> Table:
    """
    The stiffest wall that a device renders stably, by every limit, as `zwidth stability` tells it.

    `scene` has the device; keyword arguments set its quantities, as for `stability_map`.
    """

def stability_map(scene: Any, x: str = "wall_damping", y: str = "stiffness", *, x_ends: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None = None, y_ends: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None = None, cells: SupportsIndex = 100, **quantities) -> Table:
    """
    A map of every limit over two quantities, as `zwidth stability` draws it: a row for each cell, with how far each limit is
    exceeded there (above 1).

    `scene` has the device and its spring. `x` and `y` are quantities: step, mass, damping, wall_damping, stiffness, lever,
    finger, delay, rate; `x_ends` and `y_ends` the ends of their axes in SI units. Keyword arguments set quantities of the
    device: `delay=0.002`, `rate=1000`.
    """

def trial_metrics(t: Any, theta: Any, force: Any, *, velocity: Any | None = None, lever_m: SupportsFloat | SupportsIndex | None = None, scene: dict | None = None) -> Table:
    """
    Every metric of one movement: a table of one row, the columns of `metrics.parquet` without those that name a trial.

    `t` in s, `theta` in rad, `force` of the user in N (above 0 pushes into the object), `velocity` in rad/s; without it
    central differences of `theta` are taken, which show the steps of an angle sensor. `lever_m` is the lever's length: without
    it there is no work in J. `scene` says what was rendered: `{"kind": "spring", "stiffness_n_per_rad": 4.0, "rest_rad":
    -0.78}`, kinds free, spring, wall (`wall_rad`), spring_wall, force (`force_n`); free without it.
    """

def __getattr__(name: str) -> Incomplete: ...
