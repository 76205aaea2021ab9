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
from study import BETTER, BRAKE_ON, FLAT, KEYS, LEAST_SAMPLES, LEAST_SHARE, LEAST_SPAN, parameters, participants

MOTION = ["t_s", "theta_rad", "theta_dot_rad_s"]
SIGNALS = [*MOTION, "force_ex_n", "force_age_s", "force_cmd_n", "voltage_brake_v", "state_bits"]
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
    rows = scan.select(*keys, *SIGNALS, environment=col("environment").cast(pl.String), k=col("file").rle_id())
    rows = rows.rename(dict(zip(MOTION, "txv")))
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
    rows = rows.with_columns(top=x.filter(MOVE).max().over("k"))
    return rows.with_columns(reversal=first(i, MOVE & (x == col("top"))).over("k"))


def with_steps(rows, p):
    """What each metric adds up: the trapezoids between a sample and the one before, and those past the wall."""
    trapezoid = lambda y, x: (x - before(x)) * (y + before(y)) / 2
    past = x > p["wall"]
    passes = (p["wall"] - before(x)) / (x - before(x))
    begin, stop = pl.when(before(past)).then(0.0).otherwise(passes), pl.when(past).then(1.0).otherwise(passes)
    middle = lambda y: before(y) + (begin + stop) / 2 * (y - before(y))
    on = (col("state_bits") & BRAKE_ON != 0) | (col("voltage_brake_v") != 0)
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
        releases=before(past) & before(on) & ~on,
    )


def scalars(rows, p):
    """One row per trial of what needs no more than one pass."""
    there, back = (i > onset) & (i <= reversal), (i > reversal) & (i <= end)
    at = lambda a, index: first(a, i == index)
    rows = rows.group_by("k", maintain_order=True).agg(
        *(col(key).first() for key in [*KEYS, "environment"]),
        onset_s=at(t, onset),
        reversal_s=at(t, reversal),
        end_s=at(t, col("ended")),
        last_s=at(t, end),
        theta_max_rad=x.max(),
        forward=col("way").filter(there).sum(),
        backward=col("way").filter(back).sum(),
        velocity_forward_peak_rad_s=v.abs().filter(WAY).max(),
        velocity_backward_peak_rad_s=v.abs().filter(BACK).max(),
        put_in=col("work").filter(there).sum(),
        taken_out=col("work").filter(back).sum(),
        chord=(at(x, onset) - at(x, end)) * (at(f, onset) + at(f, end)) / 2,
        goes_on=(reversal + 1 < col("n")).first(),
        force_rms_error_n=col("off").filter(col("pressing")).mean().sqrt(),
        wall_dwell_s=col("dwell").filter(col("either")).sum(),
        wall_impulse_n_s=col("impulse").filter(col("either")).sum(),
        wall_energy_j=p["lever"] * col("energy").filter(col("either")).sum(),
        wall_impact_velocity_rad_s=first(col("hit_v"), col("past")),
        wall_force_max_n=f.filter(col("past")).max(),
        wall_force_rise_n=f.filter(col("past")).max() - first(col("hit_f"), col("past")),
        wall_brake_releases=col("releases").sum(),
    )
    mean = lambda way, a, b: pl.when(b > a).then(way / (b - a))
    begun, turned, ended = col("onset_s"), col("reversal_s"), col("last_s")
    rows = rows.with_columns(
        duration_s=col("end_s") - begun,
        velocity_forward_mean_rad_s=mean(col("forward"), begun, turned),
        velocity_backward_mean_rad_s=mean(col("backward"), turned, ended),
        returned_energy_share=pl.when((col("put_in") > 0) & col("goes_on")).then(-col("taken_out") / col("put_in")),
        loop_area_j=p["lever"] * (col("put_in") + col("taken_out") + col("chord")),
        wall_past_max_rad=col("theta_max_rad") - p["wall"],
    )
    touches = (col("environment") == p["walled"]) & (col("theta_max_rad") > p["wall"])
    rows = rows.with_columns(pl.when(touches).then(pl.col("^wall_.*$")).name.keep())
    return rows.drop("environment", "last_s", "forward", "backward", "put_in", "taken_out", "chord", "goes_on")


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
    ends = ends.filter((high > low) & (high - low >= LEAST_SHARE * (col("b") - col("a")))).select("k", "low", "high")
    shares = pl.LazyFrame({"share": [j / (p["points"] - 1) for j in range(p["points"])]})
    grid = ends.join(shares, how="cross").with_columns(at=pl.min_horizontal(low + (high - low) * share, high))
    grid = grid.with_columns(at=pl.when(share == 1).then(high).otherwise(col("at"))).sort("k", "at")
    grid = with_polyline(grid, "at", there, x, f, "pressed")
    grid = with_polyline(grid, "at", here, x, f, "let")
    gap, at = col("gap"), col("at")
    grid = grid.with_columns(gap=col("pressed") - col("let"))
    grid = grid.with_columns(area=(at - before(at)) * (gap + before(gap)) / 2)
    mean = col("area").sum() / (at.last() - at.first())
    return grid.group_by("k").agg(discrepancy_user_mean_n=mean, discrepancy_user_max_n=gap.max())


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
    press = press.join(found, on="k", how="left").filter(col("until").is_null() | (u < col("until")))
    k_s, f_0, _ = line(f, u)
    return press.group_by("k").agg(stiffness_n_per_rad=k_s, force_at_rest_n=f_0, stiffness_samples=pl.len())


def stiffness_of_wall(rows, p):
    """Where a wall is passed: the line of the way in."""
    is_in = (x > p["wall"]) & (i <= first(i, x == x.max()).over("k")) & (col("environment") == p["walled"])
    slope = line(f, x - p["wall"])[0]
    return rows.filter(is_in).group_by("k").agg(wall_stiffness_n_per_rad=pl.when(pl.len() >= 3).then(slope))


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
    for part in (discrepancy, stiffness, stiffness_of_wall):
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
