"""The folders raw/<study>/trials and raw/<study>/sweeps, in other people's readers with their default arguments."""

import json
from collections import Counter
from pathlib import Path

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from checks import check, equal, run


def partition(path, key):
    """The value of a Hive folder `key=value` in a path."""
    return next(part.split("=", 1)[1] for part in path.parts if part.startswith(f"{key}="))


def readers(folder):
    """Every reader, each with its default arguments: name → number of rows."""
    sql = "select count(*) from read_parquet('{}')"
    return {
        "DuckDB, folder/**/*.parquet": lambda: duckdb.sql(sql.format(f"{folder}/**/*.parquet")).fetchall()[0][0],
        "DuckDB, folder": lambda: duckdb.sql(sql.format(folder)).fetchall()[0][0],
        "pandas.read_parquet": lambda: len(pd.read_parquet(folder)),
        "pyarrow.parquet.read_table": lambda: pq.read_table(folder).num_rows,
        "pyarrow.dataset.dataset": lambda: ds.dataset(folder).count_rows(),
        "pyarrow.dataset.dataset, hive": lambda: ds.dataset(folder, partitioning="hive").count_rows(),
        "polars.read_parquet": lambda: pl.read_parquet(folder).height,
        "polars.scan_parquet": lambda: pl.scan_parquet(folder).select(pl.len()).collect().item(),
    }


def rows(label, folder, files):
    """Every reader sees as many rows as the files' footers add up to."""
    expect = sum(pq.ParquetFile(f).metadata.num_rows for f in files)
    check(f"{label}: there are rows", expect > 0, folder)
    for name, count in readers(folder).items():
        equal(f"{label}: rows in {name}", count(), expect)


def from_path(label, folder, files, keys):
    """The partition keys come from the path and stand in no file; every reader groups by them alike."""
    names = set(pq.read_schema(files[0]).names)
    equal(f"{label}: {', '.join(keys)} in the path only", names & set(keys), set())
    expect = Counter()
    for file in files:
        expect[tuple(partition(file, k) for k in keys)] += pq.ParquetFile(file).metadata.num_rows
    group = ", ".join(keys)
    sql = f"select {group}, count(*) from read_parquet('{folder}/**/*.parquet') group by {group}"
    in_duckdb = {tuple(map(str, r[:-1])): r[-1] for r in duckdb.sql(sql).fetchall()}
    in_pandas = pd.read_parquet(folder)[keys].astype(str).value_counts()
    in_polars = pl.read_parquet(folder).group_by(keys).len().rows()
    equal(f"{label}: {group} in DuckDB", in_duckdb, dict(expect))
    equal(f"{label}: {group} in pandas", {tuple(k): n for k, n in in_pandas.items() if n}, dict(expect))
    equal(f"{label}: {group} in polars", {tuple(map(str, r[:-1])): r[-1] for r in in_polars}, dict(expect))


def units(label, folder, files, keys):
    """Every column says unit and description, in the schema of the folder; the footers repeat the units."""
    for name, schema in [
        ("pyarrow.parquet.read_table", pq.read_table(folder).schema),
        ("pyarrow.dataset.dataset", ds.dataset(folder).schema),
    ]:
        silent = [f.name for f in schema if f.name not in keys and not (said(f, b"unit") and said(f, b"description"))]
        equal(f"{label}: columns without unit or description in {name}", silent, [])
    for file in files:
        schema = pq.read_schema(file)
        footer = json.loads(pq.read_metadata(file).metadata[b"units"])
        if footer != {f.name: said(f, b"unit") for f in schema}:
            check(f"{label}: units in the footer of {file}", False, footer)
            return
    check(f"{label}: the footers' units are those of the fields", True)
    sql = f"select decode(value) from parquet_kv_metadata('{files[0]}') where decode(key) = 'units'"
    equal(f"{label}: units in DuckDB", json.loads(duckdb.sql(sql).fetchall()[0][0]), json.loads(
        pq.read_metadata(files[0]).metadata[b"units"]))


def said(field, key):
    """A field's unit or description, empty where it has none."""
    return (field.metadata or {}).get(key, b"").decode()


def nulls(label, files, keys):
    """No NaN anywhere; a column of a file has all its values or none."""
    for file in files:
        table = pq.ParquetFile(file).read()
        for name in table.column_names:
            column = table[name]
            some = 0 < column.null_count < len(column)
            nan = pa.types.is_floating(column.type) and np.isnan(column.drop_null().to_numpy()).any()
            if some or nan:
                check(f"{label}: {name} of {file} is whole or null", False, f"nulls: {some}, NaN: {nan}")
                return
    check(f"{label}: no NaN, and every column of a file whole or null", True)


def same_values(label, folder, order):
    """DuckDB, pandas and polars give the same bits, whatever order they read the files in."""
    frame = pd.read_parquet(folder).sort_values(order, ignore_index=True)
    table = pl.read_parquet(folder).sort(order)
    names = ", ".join(order)
    relation = duckdb.sql(f"select * from read_parquet('{folder}/**/*.parquet') order by {names}").df()
    for name in [c for c in frame.columns if frame[c].dtype == np.float64]:
        others = [table[name].cast(pl.Float64).to_numpy(), relation[name].to_numpy(np.float64, na_value=np.nan)]
        values = [frame[name].to_numpy(), *others]
        same = all(np.array_equal(values[0], v, equal_nan=True) for v in values[1:])
        if not same:
            check(f"{label}: {name} alike in DuckDB, pandas and polars", False, [v[:3] for v in values])
            return
    check(f"{label}: the same bits in DuckDB, pandas and polars", True)


def trials(label, folder, listing):
    """The folder of trials of a study."""
    files = sorted(folder.glob("**/*.parquet"))
    counts = [s["trials_that_count"] + s["familiarisation"] + len(s["left_out"]) for s in listing["sessions"]]
    equal(f"{label}: files are those of `zwidth list`", len(files), sum(counts))
    everything = [p for p in folder.rglob("*") if p.is_file()]
    equal(f"{label}: nothing else lies in the folder", sorted(everything), files)
    keys = ["participant", "session"]
    whole(label, folder, files, keys, [*keys, "trial", "t_s"])
    per_file = {(partition(f, "participant"), partition(f, "session"), int(f.stem.split("-")[1])):
                pq.ParquetFile(f).metadata.num_rows for f in files}
    sql = f"select participant, session, trial, count(*) from read_parquet('{folder}/**/*.parquet') group by all"
    equal(f"{label}: rows of every trial", {r[:3]: r[3] for r in duckdb.sql(sql).fetchall()}, per_file)
    frame = pd.read_parquet(folder)
    equal(f"{label}: words of kind", set(frame["kind"].unique()) - {"trial", "familiarisation"}, set())
    equal(f"{label}: words of status", set(frame["status"].unique()) - {"complete", "incomplete"}, set())
    channels = [c["id"] for c in listing["channels"]]
    equal(f"{label}: each channel of the study is a column", [c for c in frame.columns if c in channels], channels)
    answers = {event["value"] for event in events(folder.parent) if event["event"] == "answer"}
    equal(f"{label}: answers lie on the five-point scale", answers - {1, 2, 3, 4, 5}, set())
    check(f"{label}: status bits are a column and no attribute of the frame", frame.state_bits is not None, frame.shape)
    still = frame.groupby(["participant", "session", "trial"], observed=True)["t_s"].diff().dropna()
    check(f"{label}: time runs forward in every trial", bool((still > 0).all()), still.min())


def counted(label, root, name, listing):
    """The lines of docs/data.md that read the samples of trials that count, and of no others."""
    lines = (Path(__file__).parents[2] / "docs/data.md").read_text()
    lines = lines.replace("raw/thesis-twin", f"{root}/raw/{name}").replace("derived/thesis-twin", f"{root}/derived/{name}")
    blocks = [block.split("```")[0] for block in lines.split("```")[1:]]
    python = [block.removeprefix("python\n") for block in blocks if block.startswith("python\n") and "samples =" in block]
    sql = [block.removeprefix("sql\n") for block in blocks if block.startswith("sql\n") and "SEMI JOIN" in block]
    equal(f"{label}: lines of Python and SQL in docs/data.md", (len(python), len(sql)), (2, 1))
    rows = []
    for block in python:
        names = {"pl": pl}
        exec(block, names)
        rows.append(len(names["samples"]))
        trials = names.get("trials", None)
        if trials is not None:
            expect = sum(session["trials_that_count"] for session in listing["sessions"])
            equal(f"{label}: trials that count", int(trials.counts.sum()), expect)
            equal(f"{label}: who does not count has a reason", int((trials.why_not.isna() == trials.counts).sum()), len(trials))
            files = trials.path[trials.counts]
            rows.append(sum(pq.ParquetFile(root / path).metadata.num_rows for path in files))
    rows.append(len(duckdb.sql(sql[0]).df()))
    equal(f"{label}: samples of the trials that count", set(rows), {rows[0]})


def events(raw):
    """Every event of a study's sessions, in order."""
    for log in sorted((raw / "sessions").glob("*.events.jsonl")):
        yield from (json.loads(line)["what"] for line in log.read_text().splitlines())


def sweeps(label, folder, listing):
    """The folder of sweeps of a study."""
    files = sorted(folder.glob("**/*.parquet"))
    equal(f"{label}: files are those of `zwidth list`", len(files), sum(listing["sweeps"].values()))
    frame = pl.read_parquet(folder)
    order = ["actuator", "sweep"] + (["t_s"] if frame["t_s"].null_count() == 0 else ["command", "response"])
    whole(label, folder, files, ["actuator"], order)


def whole(label, folder, files, keys, order):
    """What trials and sweeps share."""
    rows(label, folder, files)
    from_path(label, folder, files, keys)
    units(label, folder, files, keys)
    nulls(label, files, keys)
    same_values(label, folder, order)


def study(zwidth, root, name):
    """Both folders of a study."""
    listing = json.loads(run(zwidth, "--root", root, "list", name, "--json"))[0]
    raw = root / "raw" / name
    if (raw / "trials").exists():
        trials(f"{name}/trials", raw / "trials", listing)
        if (root / "derived" / name / "trials.parquet").exists():
            counted(f"{name}/trials.parquet", Path(root), name, listing)
    if (raw / "sweeps").exists():
        sweeps(f"{name}/sweeps", raw / "sweeps", listing)
