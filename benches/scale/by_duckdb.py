"""Metrics of every trial of a study in DuckDB's SQL (by_duckdb.sql), for some participants at a time.

    python by_duckdb.py STUDY_FOLDER OUT.parquet [--at-a-time PARTICIPANTS]
"""

import argparse
from pathlib import Path
from string import Template

import duckdb
import pyarrow as pa
import pyarrow.parquet as pq

import study
from study import parameters, participants

RULES = {name.lower(): rule for name, rule in vars(study).items() if name.isupper()}


def literal(value):
    if isinstance(value, list):
        return ", ".join(f"'{word}'" for word in value)
    # Written as it is, a number without an exponent would be an exact DECIMAL.
    return f"'{value!r}'::DOUBLE" if isinstance(value, float) else str(value)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("study", type=Path)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("--at-a-time", type=int, default=10)
    given = arguments.parse_args()
    values = {name: literal(value) for name, value in (parameters(given.study) | RULES).items()}
    query = Template(Path(__file__).with_suffix(".sql").read_text())
    people, found = participants(given.study), []
    with duckdb.connect() as connection:
        for at in range(0, len(people), given.at_a_time):
            files = sum(people[at : at + given.at_a_time], [])
            found.append(connection.sql(query.safe_substitute(values, files=files)).to_arrow_table())
    pq.write_table(pa.concat_tables(found), given.out)


if __name__ == "__main__":
    main()
