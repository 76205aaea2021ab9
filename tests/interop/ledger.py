"""A table of ours of which every number is computed again, or listed with the reason why it is not."""

import json

import pandas as pd

import tidy
from checks import check, close, equal, run


def compared(zwidth, root, study, by):
    """The tables that `zwidth compare STUDY --by BY --json` prints, by name; each is what its Parquet file holds."""
    tables = {}
    for printed in json.loads(run(zwidth, "--root", root, "compare", study, "--by", by, "--json")):
        name = printed["table"]
        stored = tidy.printed(root / "derived" / study / "compare", name)
        # Without a row nothing is printed of the columns.
        frame = pd.DataFrame(printed["rows"], columns=None if printed["rows"] else list(stored))
        same = set(frame) == set(stored) and all(alike(frame[c], stored[c]) for c in stored)
        check(f"{study}: compare --by {by} --json prints what the table of {name} holds", same, list(stored))
        tables[name] = Ledger(f"{study}, {name}", frame, printed["notes"])
    return tables


def alike(printed, stored):
    """Whether two columns hold the same, nulls included."""
    return printed.isna().tolist() == stored.isna().tolist() and printed.dropna().tolist() == stored.dropna().tolist()


class Ledger:
    """A table with what was computed again of it."""

    def __init__(self, label, frame, notes):
        self.label, self.frame, self.notes = label, frame, notes
        # Rows in words, and the cells that were looked at.
        self.names, self.seen = {}, set()

    def row(self, **where):
        """The only row with these values."""
        rows = self.frame
        for column, value in where.items():
            rows = rows[rows[column] == value]
        if len(rows) != 1:
            raise SystemExit(f"{self.label}: {len(rows)} rows with {where}")
        self.names[rows.index[0]] = ", ".join(where.values())
        return rows.index[0]

    def counts(self, row, **expect):
        """Whole numbers and texts."""
        for column, value in expect.items():
            self.seen.add((row, column))
            equal(f"{self.label}, {self.names[row]}: {column}", self.frame.loc[row, column], value)

    def numbers(self, row, expect, relative):
        """Numbers by column, to a relative tolerance."""
        for column, value in expect.items():
            self.seen.add((row, column))
            close(f"{self.label}, {self.names[row]}: {column}", self.frame.loc[row, column], value, relative)

    def nulls(self, why, columns):
        """Columns that say nothing, for a reason that the table gives: a column of which no row has a value is left out."""
        for column in columns:
            there = int(self.frame[column].notna().sum()) if column in self.frame else 0
            check(f"{self.label}: no {column}, for {why}", there == 0, f"{there} are there")
            self.seen |= {(row, column) for row in self.frame.index}

    def closed(self, unchecked=None):
        """Every number was computed again, but those of the columns in `unchecked`, which gives the reasons."""
        unchecked = unchecked or {}
        numbers = [c for c in self.frame if pd.api.types.is_numeric_dtype(self.frame[c]) or self.frame[c].isna().all()]
        left = [(row, c) for c in numbers for row in self.frame.index if (row, c) not in self.seen]
        for column, why in unchecked.items():
            count = sum(c == column for _, c in left)
            print(f"not checked: {count} numbers {column} of {self.label}: {why}")
        silent = [cell for cell in left if cell[1] not in unchecked]
        check(f"{self.label}: every number is computed again, or the reason is listed", not silent, silent[:5])
