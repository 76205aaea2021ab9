"""Raw files beside those that pandas writes by default from the same values: bytes per file, and the time to read all
columns of one, medians of rounds.

    python sizes.py STUDY_FOLDER FOLDER [--files 360] [--rounds 7]

Files lie side by side in FOLDER. Prints JSON.
"""

import argparse
import json
import shutil
import statistics
import time
from pathlib import Path

import pandas as pd

from study import participants


def sample(study, count):
    files = sum(participants(study), [])
    return files[:: max(1, len(files) // count)][:count]


def write(files, folder):
    """Copies of the files, and what pandas makes of them."""
    pairs = []
    for place, file in enumerate(files):
        ours, theirs = (folder / f"{place:04}.{who}.parquet" for who in ("zwidth", "pandas"))
        shutil.copyfile(file, ours)
        frame = pd.read_parquet(ours)
        frame.to_parquet(theirs)
        pd.testing.assert_frame_equal(pd.read_parquet(theirs), frame)
        pairs.append((ours, theirs))
    return pairs


def seconds(file):
    """Of the clock, and of processors."""
    begun = time.perf_counter(), time.process_time()
    pd.read_parquet(file)
    return time.perf_counter() - begun[0], time.process_time() - begun[1]


def one_round(pairs, backwards):
    """Mean times of both kinds of file, read in turns, so that what else runs on the machine slows both."""
    times = [[seconds(file) for file in (pair[::-1] if backwards else pair)] for pair in pairs]
    times = [each[::-1] for each in times] if backwards else times
    return [[statistics.mean(each[kind][clock] for each in times) for clock in (0, 1)] for kind in (0, 1)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("study", type=Path)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--files", type=int, default=360)
    arguments.add_argument("--rounds", type=int, default=11)
    given = arguments.parse_args()
    pairs = write(sample(given.study, given.files), given.folder)
    rounds = [one_round(pairs, number % 2 == 1) for number in range(given.rounds)]
    found = [
        {
            "bytes": sum(pair[kind].stat().st_size for pair in pairs) / len(pairs),
            "wall_s": statistics.median(times[kind][0] for times in rounds),
            "processor_s": statistics.median(times[kind][1] for times in rounds),
        }
        for kind in (0, 1)
    ]
    print(json.dumps({"files": len(pairs), "rounds": given.rounds, "zwidth": found[0], "pandas": found[1]}))


main()
