"""Tables of all metrics that the stage `compare` makes, as they are printed: one metric's rows, its unit in the names."""

import pandas as pd
import pyarrow.parquet as parquet

SUFFIXES = {"N": "_n", "rad": "_rad", "s": "_s", "J": "_j", "N/rad": "_n_per_rad", "m": "_m", "1": ""}


def printed(folder, name):
    """The rows of a printed table, `contrasts_loop_area_j`, without the columns of which none has a value."""
    path = folder / f"{name}.parquet"
    if path.exists():
        return without_empty(pd.read_parquet(path))
    kind = max((file.stem for file in folder.glob("*.parquet") if name.startswith(f"{file.stem}_")), key=len)
    return rows(folder, kind, name.removeprefix(f"{kind}_"))


def rows(folder, kind, metric):
    """A metric's rows of the table of a kind."""
    path = folder / f"{kind}.parquet"
    frame = pd.read_parquet(path)
    frame = without_empty(frame[frame["metric"] == metric].reset_index(drop=True))
    suffix = SUFFIXES[unit_of(folder, metric)]
    fields = {field.name: field.metadata[b"unit"].decode() for field in parquet.read_schema(path)}
    # A column without a unit of its own has that of the metric.
    own = {column: column + suffix for column in frame if fields[column] == ""}
    return frame.drop(columns=["metric", "unit"], errors="ignore").rename(columns=own)


def unit_of(folder, metric):
    """The unit of a metric, as the table of the metrics compared has it."""
    metrics = pd.read_parquet(folder / "compared.parquet")
    return metrics.loc[metrics["metric"] == metric, "unit"].item()


def without_empty(frame):
    """The table as it is printed; one without rows has all columns."""
    return frame if frame.empty else frame.dropna(axis="columns", how="all")
