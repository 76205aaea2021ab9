"""Metrics of every trial of a study in polars: lazy scans of the files of some participants at a time, expressions.

    python by_polars.py STUDY_FOLDER OUT.parquet [--engine streaming|in-memory] [--at-a-time PARTICIPANTS] [--series]

With `--series` those too that need a transform of each trial, in NumPy by a process for each core (series.py).
Definitions: docs/analysis.md. Rows of a trial follow each other, `k` is its number and `i` the sample's.
"""

import argparse
import os
from contextlib import nullcontext
from multiprocessing import get_context
from pathlib import Path

import polars as pl

from series import COLUMNS, of_trial
from study import BETTER, BRAKE_ON, FLAT, KEYS, LEAST_RAD, LEAST_SAMPLES, LEAST_SHARE, LEAST_SPAN, MOTOR_ON, OUTSIDE
from study import RETREAT, SAME, STEP_WINDOW, parameters, participants

MOTION = ["t_s", "theta_rad", "theta_dot_rad_s"]
SIGNALS = [*MOTION, "force_ex_n", "force_age_s", "force_cmd_n", "voltage_motor_v", "voltage_brake_v", "state_bits"]
# Columns of a trial that others are made of.
HELPERS = ["environment", "mode", "last_s", "theta_min_rad", "forward", "backward"]
HELPERS += ["put_in", "taken_out", "chord", "goes_on", "commanded", "bound", "contacts"]
col = pl.col
k, i, t, x, v, f = (col(name) for name in ("k", "i", "t", "x", "v", "f"))
onset, reversal, end = col("onset"), col("reversal"), col("end")
WAY, BACK, MOVE = i.is_between(onset, reversal), i.is_between(reversal, end), i.is_between(onset, end)


def before(a):
    """The value one row earlier in the same trial."""
    return pl.when(k == k.shift(1)).then(a.shift(1))


def first(a, where):
    return a.filter(where).first()


def samples(files):
    """The samples of all trials that count."""
    scan = pl.scan_parquet(files, hive_partitioning=True, include_file_paths="file")
    scan = scan.filter(col("kind").cast(pl.String) == "trial")
    keys = [col(key) for key in KEYS]
    words = [col(name).cast(pl.String) for name in ("environment", "mode")]
    rows = scan.select(*keys, *SIGNALS, *words, k=col("file").rle_id())
    rows = rows.rename(dict(zip(MOTION, "txv"))).cast({"voltage_motor_v": pl.Float64})
    return rows.with_columns(i=pl.int_range(pl.len()).over("k"))


def with_polyline(rows, at, points, on, y, name):
    """The polyline through points (on, y), rising in each trial, at each row; null outside."""
    points = points.select("k", x1=on, y1=y, x0=before(on), y0=before(y))
    rows = rows.join_asof(
        points, left_on=at, right_on="x1", by="k", strategy="forward", coalesce=False, check_sortedness=False
    )
    x0, x1, y0, y1, here = col("x0"), col("x1"), col("y0"), col("y1"), col(at)
    value = pl.when(x1 == here).then(y1).otherwise(y0 + (here - x0) / (x1 - x0) * (y1 - y0))
    return rows.with_columns(value.alias(name)).drop("x0", "x1", "y0", "y1")


def updates_of(rows):
    """The values of the force sensor, at the times at which it gave them."""
    age = col("force_age_s").cast(pl.Float64)
    is_new = (age < before(age) + (t - before(t)) / 2).fill_null(True)
    updates = rows.filter(is_new).select("k", taken=t - age, value="force_ex_n")
    updates = updates.with_columns(latest=col("taken").cum_max().over("k"))
    return updates.filter((col("taken") > before(col("latest"))).fill_null(True))


def with_force(rows):
    """The force at each sample between its sensor's own updates; the last one's after it."""
    updates = updates_of(rows)
    rows = with_polyline(rows, "t", updates, col("taken"), col("value"), "f")
    rows = rows.join(updates.group_by("k").agg(col("value").last()), on="k", how="left", maintain_order="left")
    return rows.with_columns(f=f.fill_null(col("value")))


def with_phases(rows, p):
    fast, slow = v.abs() > p["onset"], v.abs() < p["offset"]
    rows = rows.with_columns(onset=first(i, fast).over("k"), last=i.filter(fast).last().over("k"), n=pl.len().over("k"))
    rows = rows.with_columns(ended=first(i, slow & (i >= col("last"))).over("k"))
    rows = rows.with_columns(end=col("ended").fill_null(col("n") - 1))
    rows = rows.with_columns(top=x.filter(MOVE).max().over("k"), lowest=x.min().over("k"), highest=x.max().over("k"))
    rows = rows.with_columns(reversal=first(i, MOVE & (x == col("top"))).over("k"))
    rows = rows.with_columns(returns=first(i, BACK & (v < -p["onset"])).over("k"))
    stays = (i >= reversal) & (i < col("returns")) & (v >= -p["offset"])
    begins = pl.max_horizontal(reversal, i.filter(stays).last().over("k") + 1)
    return rows.with_columns(begins=pl.when(col("returns").is_not_null()).then(begins))


def until(there, gone):
    """From each sample that is `there` to the next that is `gone`."""
    return pl.when(there).then(True).when(gone).then(False).forward_fill().over("k").fill_null(False)


def with_steps(rows, p):
    """What each metric adds up: the trapezoids between a sample and the one before, and those past the wall."""
    trapezoid = lambda y, x: (x - before(x)) * (y + before(y)) / 2
    past = x > p["wall"]
    passes = (p["wall"] - before(x)) / (x - before(x))
    begin, stop = pl.when(before(past)).then(0.0).otherwise(passes), pl.when(past).then(1.0).otherwise(passes)
    middle = lambda y: before(y) + (begin + stop) / 2 * (y - before(y))
    on = lambda bit, voltage: (col("state_bits") & bit != 0) | (col(voltage) != 0)
    braked, driven = on(BRAKE_ON, "voltage_brake_v"), on(MOTOR_ON, "voltage_motor_v")
    brakes, drives = braked != before(braked), driven != before(driven)
    held = lambda y: before(y) * (t - before(t))
    retreat = RETREAT * (col("highest") - col("lowest"))
    return rows.with_columns(
        way=trapezoid(v.abs(), t),
        work=trapezoid(f, x),
        off=(f - col("force_cmd_n")) ** 2,
        pressing=WAY & (x - p["rest"] >= p["slope_from"]) & ((col("environment") != p["walled"]) | (x < p["wall"])),
        past=past,
        either=past | before(past),
        dwell=(stop - begin) * (t - before(t)),
        impulse=middle(f) * (stop - begin) * (t - before(t)),
        energy=middle(f) * (stop - begin) * (x - before(x)),
        hit_v=before(v) + passes * (v - before(v)),
        hit_f=before(f) + passes * (f - before(f)),
        releases=before(past) & before(braked) & ~braked,
        brakes=brakes,
        drives=drives,
        switches=brakes | drives,
        commanded=held(col("force_cmd_n").abs()),
        heat=held(col("voltage_motor_v") ** 2),
        driven=before(col("force_cmd_n").abs()) * (x - before(x)).abs() * before(col("voltage_motor_v") != 0),
        at_low=until(x <= p["low"], x - p["low"] > retreat),
        at_high=until(x >= p["high"], p["high"] - x > retreat),
        at_wall=until(past, x < p["wall"] - retreat),
        still=past & (v.abs() < p["offset"]),
    )


def scalars(rows, p):
    """One row per trial of what needs no more than one pass."""
    there, back, moving = (i > onset) & (i <= reversal), (i > reversal) & (i <= end), (i > onset) & (i <= end)
    at = lambda a, index: first(a, i == index)
    arrivals = lambda there: (there & ~before(there)).sum()
    rows = rows.group_by("k", maintain_order=True).agg(
        *(col(key).first() for key in [*KEYS, "environment", "mode"]),
        onset_s=at(t, onset),
        reversal_s=at(t, reversal),
        end_s=at(t, col("ended")),
        last_s=at(t, end),
        theta_max_rad=x.max(),
        theta_min_rad=x.min(),
        work_space_hits_low=arrivals(col("at_low")),
        work_space_hits_high=arrivals(col("at_high")),
        forward=col("way").filter(there).sum(),
        backward=col("way").filter(back).sum(),
        velocity_forward_peak_rad_s=v.abs().filter(WAY).max(),
        velocity_backward_peak_rad_s=v.abs().filter(BACK).max(),
        put_in=col("work").filter(there).sum(),
        taken_out=col("work").filter(back).sum(),
        chord=(at(x, onset) - at(x, end)) * (at(f, onset) + at(f, end)) / 2,
        goes_on=(reversal + 1 < col("n")).first(),
        force_rms_error_n=col("off").filter(col("pressing")).mean().sqrt(),
        return_force_n=at(f, col("begins")),
        motor_switches=col("drives").filter(moving).sum(),
        brake_switches=col("brakes").filter(moving).sum(),
        actuator_switches=col("switches").filter(moving).sum(),
        bound=col("heat").sum() / p["motor_ohm"] + p["lever"] * col("driven").sum(),
        commanded=col("commanded").sum(),
        wall_dwell_s=col("dwell").filter(col("either")).sum(),
        wall_impulse_n_s=col("impulse").filter(col("either")).sum(),
        wall_energy_j=p["lever"] * col("energy").filter(col("either")).sum(),
        wall_impact_velocity_rad_s=first(col("hit_v"), col("past")),
        wall_force_max_n=f.filter(col("past")).max(),
        wall_force_rise_n=f.filter(col("past")).max() - first(col("hit_f"), col("past")),
        wall_brake_releases=col("releases").sum(),
        contacts=(col("at_wall") & ~before(col("at_wall")).fill_null(False)).sum(),
    )
    mean = lambda way, a, b: pl.when(b > a).then(way / (b - a))
    begun, turned, ended, energy = (col(name) for name in ("onset_s", "reversal_s", "last_s", "bound"))
    in_time = ended - begun <= p["limit"]
    outside = OUTSIDE * (p["high"] - p["low"])
    rows = rows.with_columns(
        duration_s=col("end_s") - begun,
        velocity_forward_mean_rad_s=mean(col("forward"), begun, turned),
        velocity_backward_mean_rad_s=mean(col("backward"), turned, ended),
        returned_energy_share=pl.when((col("put_in") > 0) & col("goes_on")).then(-col("taken_out") / col("put_in")),
        loop_area_j=p["lever"] * (col("put_in") + col("taken_out") + col("chord")),
        protocol_in_time=pl.when(col("end_s").is_not_null() | ~in_time).then(in_time),
        protocol_inside=(col("theta_min_rad") >= p["low"] - outside) & (col("theta_max_rad") <= p["high"] + outside),
        bound=pl.when(col("mode").is_in(p["motor_alone"])).then(energy),
        wall_past_max_rad=col("theta_max_rad") - p["wall"],
        wall_depth_m=p["lever"] * (col("theta_max_rad") - p["wall"]),
        wall_rebounds=col("contacts") - 1,
    )
    has_wall = col("environment") == p["walled"]
    touches = has_wall & (col("theta_max_rad") > p["wall"])
    rows = rows.with_columns(pl.when(touches).then(pl.col("^wall_.*$")).name.keep())
    rows = rows.with_columns(
        wall_reached=pl.when(has_wall).then(touches),
        wall_contacts=pl.when(has_wall).then(col("contacts")),
        electrical_energy_max_j=energy,
        force_per_power_n_per_w=pl.when((col("commanded") > 0) & (energy > 0)).then(col("commanded") / energy),
    )
    return rows.drop(*HELPERS)


def discrepancy(rows, p):
    """Compression over decompression on a grid of angles that both reach."""
    way = rows.filter(WAY).select("k", "x", "f", most=x.cum_max().over("k"))
    back = rows.filter(BACK).select("k", "x", "f", least=x.cum_min().over("k"))
    there = way.filter((x > before(col("most"))).fill_null(True))
    here = back.filter((x < before(col("least"))).fill_null(False)).sort("k", "x")
    ends = there.group_by("k").agg(a=x.first(), b=x.last())
    ends = ends.join(here.group_by("k").agg(c=x.first(), d=x.last()), on="k")
    low, high, share = col("low"), col("high"), col("share")
    ends = ends.with_columns(low=pl.max_horizontal("a", "c"), high=pl.min_horizontal("b", "d"))
    ends = ends.filter((high > low) & (high - low >= LEAST_SHARE * (col("b") - col("a"))))
    ends = ends.select("k", "low", "high", turned="b")
    shares = pl.LazyFrame({"share": [j / (p["points"] - 1) for j in range(p["points"])]})
    grid = ends.join(shares, how="cross").with_columns(at=pl.min_horizontal(low + (high - low) * share, high))
    grid = grid.with_columns(at=pl.when(share == 1).then(high).otherwise(col("at"))).sort("k", "at")
    grid = with_polyline(grid, "at", there, x, f, "pressed")
    grid = with_polyline(grid, "at", here, x, f, "let")
    gap, at = col("gap"), col("at")
    grid = grid.with_columns(gap=col("pressed") - col("let"))
    grid = grid.with_columns(area=(at - before(at)) * (gap + before(gap)) / 2)
    last = p["points"] - (p["points"] - 1) // STEP_WINDOW - 1
    slope, at_zero, _ = line(gap.slice(last), at.slice(last) - at.last())
    return grid.group_by("k").agg(
        discrepancy_user_mean_n=col("area").sum() / (at.last() - at.first()),
        discrepancy_user_max_n=gap.max(),
        discrepancy_user_step_n=at_zero + slope * (col("turned").first() - at.last()),
    )


def line(y, x):
    """The line of y on x: slope, intercept, residual sum of squares."""
    dx, dy = x - x.mean(), y - y.mean()
    slope = (dx * dy).sum() / (dx * dx).sum()
    return slope, y.mean() - slope * x.mean(), ((dy - slope * dx) ** 2).sum()


def stiffness(rows, p):
    """The line of the compression, up to where its force saturates: the best of all divisions into line and plateau."""
    u = col("u")
    press = rows.filter(col("pressing")).select("k", "f", u=x - p["rest"]).sort("k", "u", maintain_order=True)
    press = press.with_columns(a=u - u.mean().over("k"), b=f - f.mean().over("k"))
    press = press.with_columns(m=pl.int_range(1, pl.len() + 1).over("k"))
    a, b, m, size = col("a"), col("b"), col("m"), col("m").max().over("k")
    sums = {"sa": a, "sb": b, "aa": a * a, "ab": a * b, "bb": b * b}
    press = press.with_columns(size=size, **{name: value.cum_sum().over("k") for name, value in sums.items()})
    press = press.with_columns(all_b=b.sum().over("k"), all_bb=(b * b).sum().over("k"))
    sa, sb, aa, ab, bb = (col(name) for name in sums)
    rest, rest_b = col("size") - m, col("all_b") - sb
    press = press.with_columns(slope=(ab - sa * sb / m) / (aa - sa * sa / m))
    slope, meets, rss = col("slope"), col("meets"), col("rss")
    press = press.with_columns(
        meets=(rest_b / rest - (sb - slope * sa) / m) / slope,
        rss=bb - sb * sb / m - slope * (ab - sa * sb / m) + (col("all_bb") - bb) - rest_b**2 / rest,
    )
    follows = pl.when(m < col("size")).then(a.shift(-1))
    may = (m >= LEAST_SAMPLES) & (rest >= LEAST_SAMPLES) & (a <= meets) & (meets <= follows)
    press = press.with_columns(may=may)
    press = press.with_columns(best=rss.filter(col("may")).min().over("k"))
    press = press.with_columns(division=first(m, col("may") & (rss == col("best"))).over("k"))
    division = col("division")
    press = press.with_columns(u_s=(first(meets, m == division) + u.mean()).over("k"))
    below, above, u_s = m <= division, m > division, col("u_s").first()
    found = press.group_by("k").agg(
        u_s=u_s,
        rise=line(f.filter(below), u.filter(below))[0],
        goes_on=line(f.filter(above), u.filter(above))[0],
        is_long=u.last() - u_s >= LEAST_SPAN * (u.last() - u.first()),
        is_better=col("best").first() <= BETTER * line(f, u)[2],
    )
    saturates = col("is_long") & (col("rise") > 0) & (col("goes_on") < FLAT * col("rise")) & col("is_better")
    found = found.filter(saturates).select("k", until="u_s")
    press = press.join(found, on="k", how="left")
    below = col("until").is_null() | (u < col("until"))
    k_s, f_0, left = line(f.filter(below), u.filter(below))
    return press.group_by("k").agg(
        stiffness_n_per_rad=k_s,
        stiffness_error_n_per_rad=k_s - p["stiffness"],
        stiffness_r2=1 - left / ((f.filter(below) - f.filter(below).mean()) ** 2).sum(),
        stiffness_samples=below.sum(),
        force_at_rest_n=f_0,
        saturation_force_n=f.filter(~below).mean(),
        saturation_theta_rad=p["rest"] + col("until").first(),
    )


def at_wall(rows, p):
    """Where a wall is passed: the line of the way in, the force's growth over the lever's way, the longest rest."""
    past, most, count, held, holds = (col(name) for name in ("past", "most", "count", "held", "holds"))
    u = x - p["wall"]
    rows = rows.filter((col("environment") == p["walled"]) & (col("highest") > p["wall"]))
    step = x.sort().diff()
    rows = rows.with_columns(
        deepest=first(i, x == col("highest")).over("k"),
        force_max=f.filter(past).max().over("k"),
        count=pl.when(step > LEAST_RAD).then(step).min().over("k").fill_null(0.0),
        rest=(col("still") != before(col("still"))).fill_null(True).cum_sum(),
    )
    rows = rows.with_columns(
        held=past & (col("highest") - x <= SAME * count), most=first(i, past & (f == col("force_max"))).over("k")
    )
    rows = rows.with_columns(holds=first(i, held).over("k"))
    rows = rows.with_columns(lets_go=first(i, (i > holds) & ~held).over("k").fill_null(col("n")))
    is_in = past & (i <= col("deepest"))
    while_held = f.filter((i >= holds) & (i < col("lets_go")))
    found = rows.group_by("k").agg(
        wall_stiffness_n_per_rad=pl.when(is_in.sum() >= 3).then(line(f.filter(is_in), u.filter(is_in))[0]),
        grown=col("force_max").first() - first(col("hit_f"), past),
        moved=x.filter(i <= most).max() - p["wall"],
        count=count.first(),
        held=while_held.max() - while_held.first(),
    )
    grown, moved, held = col("grown"), col("moved"), col("held")
    way = pl.max_horizontal(moved, count)
    found = found.select(
        "k",
        "wall_stiffness_n_per_rad",
        wall_rigidity_n_per_rad=pl.when((grown > 0) & (way > 0)).then(grown / way),
        wall_rigidity_at_least=pl.when((grown > 0) & (way > 0)).then(moved <= count),
        wall_hold_rigidity_min_n_per_rad=pl.when((held > 0) & (count > 0)).then(held / count),
    )
    rests = rows.group_by("k", "rest").agg(col("still").first(), long=t.last() - t.first())
    rests = rests.group_by("k").agg(wall_still_s=col("long").filter(col("still")).max().fill_null(0.0))
    return found.join(rests, on="k")


def series(rows, pool):
    """What needs a transform of each trial: its samples are handed to NumPy."""
    trials = rows.group_by("k", maintain_order=True).agg(t, x, v, *(phase.first() for phase in (onset, reversal, end)))
    updates = updates_of(rows).group_by("k", maintain_order=True).agg("taken", "value")
    trials = trials.join(updates, on="k", maintain_order="left").collect()
    arrays = [[one.to_numpy() for one in trials[name]] for name in ("t", "x", "v", "taken", "value")]
    phases = [trials[name].to_list() for name in ("onset", "reversal", "end")]
    found = pool.map(of_trial, zip(*arrays, *phases), chunksize=9)
    columns = dict(zip(COLUMNS, zip(*found)))
    return pl.LazyFrame({"k": trials["k"], **columns}, schema_overrides={name: pl.Float64 for name in COLUMNS})


def metrics(files, p, engine, pool):
    # Collected once: left lazy, the samples are read anew for each part, and it takes twice as long.
    rows = with_steps(with_phases(with_force(samples(files)), p), p).collect(engine=engine).lazy()
    found = scalars(rows, p)
    for part in (discrepancy, stiffness, at_wall):
        found = found.join(part(rows, p), on="k", how="left", maintain_order="left")
    if pool:
        found = found.join(series(rows, pool), on="k", how="left", maintain_order="left")
    has_loop = col("discrepancy_user_mean_n").is_not_null()
    found = found.with_columns(loop_area_j=pl.when(has_loop).then(col("loop_area_j"))).drop("k")
    return found.collect(engine=engine)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("study", type=Path)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("--engine", default="in-memory")
    arguments.add_argument("--at-a-time", type=int, default=5)
    arguments.add_argument("--series", action="store_true")
    given = arguments.parse_args()
    p, people = parameters(given.study), participants(given.study)
    parts = [sum(people[at : at + given.at_a_time], []) for at in range(0, len(people), given.at_a_time)]
    # A new process each: one that is forked would inherit the locks of polars' threads.
    with get_context("spawn").Pool(os.cpu_count()) if given.series else nullcontext() as pool:
        pl.concat([metrics(files, p, given.engine, pool) for files in parts]).write_parquet(given.out)


if __name__ == "__main__":
    main()
