"""The module beside pyarrow, pandas, polars and NumPy: what they read is what the files hold, to the last bit.

    python tests/interop/python/packages.py --root ROOT     (a folder whose study thesis-twin is up to date)

A package that is not installed is left out: the step `python` of .ci/long runs this in an environment for each.
"""

import argparse
import gc
import importlib.util
import math
import pathlib
import sys
import unittest

import zwidth

STUDY = "thesis-twin"
parser = argparse.ArgumentParser()
parser.add_argument("--root", type=pathlib.Path, required=True)
given, rest = parser.parse_known_args()
ROOT = given.root
sys.argv = [sys.argv[0], *rest]


def has(package):
    return unittest.skipUnless(importlib.util.find_spec(package), f"without {package}")


def memory_mib():
    """What the process has in memory, MiB (Linux)."""
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


@has("pyarrow")
class Pyarrow(unittest.TestCase):
    def setUp(self):
        import pyarrow
        import pyarrow.parquet

        self.pa, self.read = pyarrow, pyarrow.parquet.read_table
        self.study = zwidth.read_study(ROOT, STUDY)

    def same(self, own, file, but=()):
        """Columns of the file but these are ours, to the last bit, with their units."""
        own = self.pa.table(own)
        self.assertEqual(own.num_rows, file.num_rows)
        names = [name for name in file.column_names if name not in but]
        self.assertEqual(own.column_names, names)
        for name in names:
            self.assertTrue(own[name].combine_chunks().equals(file[name].combine_chunks()), name)
            self.assertEqual(own.schema.field(name).metadata, file.schema.field(name).metadata, name)

    def test_derived_tables_are_those_of_the_run(self):
        derived = ROOT / "derived" / STUDY
        self.same(self.study.metrics(), self.read(derived / "metrics.parquet"))
        self.same(self.study.contrasts(), self.read(derived / "compare" / "contrasts.parquet"))
        self.same(self.study.answers(), self.read(derived / "answers.parquet"))
        self.same(self.study.trials, self.read(derived / "trials.parquet"), but=["read_with_care"])

    def test_metrics_computed_here_are_those_of_the_run(self):
        of_run = self.read(ROOT / "derived" / STUDY / "metrics.parquet").to_pylist()
        for row in of_run[::7]:
            own = self.pa.table(self.study.trial(row["participant"], row["session"], row["trial"]).metrics()).to_pylist()[0]
            self.assertGreater(len(own), 90)
            # Equal floats of these are equal bits: none of them is a zero of either sign or no number.
            self.assertEqual(own, {name: row[name] for name in own})

    def test_one_s_own_arrays_give_the_metrics_of_the_run(self):
        self.assertIn("lever_m = 0.045", (ROOT / "raw" / STUDY / "study.toml").read_text())
        row = next(row for row in self.read(ROOT / "derived" / STUDY / "metrics.parquet").to_pylist() if (row["environment"], row["mode"]) == ("spring", "hybrid"))
        trial = self.study.trial(row["participant"], row["session"], row["trial"])
        own = zwidth.trial_metrics(trial["t_s"], trial["theta_rad"], trial["force_ex_n"], velocity=trial["theta_dot_rad_s"], lever_m=0.045)
        for name in ("onset_s", "end_s", "reversal_s", "theta_max_rad", "path_rad", "sparc_forward", "sparc_backward"):
            self.assertEqual(own[name].to_list(), [row[name]], name)

    def test_samples_are_those_of_the_recordings(self):
        table = self.pa.table(self.study.samples())
        whole = {}
        for batch in self.pa.RecordBatchReader.from_stream(self.study.samples()):
            whole[batch["trial"][0].as_py()] = batch
        self.assertEqual(sum(batch.num_rows for batch in whole.values()), table.num_rows)
        for number, batch in list(whole.items())[::5]:
            raw = self.read(next((ROOT / "raw" / STUDY / "trials").rglob(f"trial-{number:03d}.parquet")))
            for name in ("t_s", "theta_rad", "theta_dot_rad_s", "force_ex_n", "state_bits"):
                self.assertTrue(batch[name].equals(raw[name].combine_chunks().cast(batch[name].type)), (number, name))

    def test_what_was_handed_over_outlives_who_gave_it(self):
        def column():
            return self.pa.array(zwidth.read_study(ROOT, STUDY).metrics()["sparc_forward"])

        kept = [column() for _ in range(20)]
        gc.collect()
        self.assertTrue(all(other.equals(kept[0]) for other in kept))


@has("polars")
class Polars(unittest.TestCase):
    def test_tables_and_samples(self):
        import polars

        study = zwidth.read_study(ROOT, STUDY)
        of_run = polars.read_parquet(ROOT / "derived" / STUDY / "metrics.parquet")
        self.assertTrue(polars.DataFrame(study.metrics()).equals(of_run))
        samples = polars.DataFrame(study.samples(["t_s", "theta_rad"]))
        self.assertEqual(samples["trial"].n_unique(), 36)
        self.assertEqual(samples.columns[-2:], ["t_s", "theta_rad"])
        self.assertEqual(polars.Series(study.metrics()["sparc_forward"]).to_list(), of_run["sparc_forward"].to_list())


@has("pandas")
class Pandas(unittest.TestCase):
    def test_tables_and_columns(self):
        import pandas

        study = zwidth.read_study(ROOT, STUDY)
        if importlib.util.find_spec("pyarrow"):
            frame = pandas.DataFrame.from_arrow(study.metrics())
            self.assertEqual(frame.shape, (36, len(study.metrics().columns)))
        frame = pandas.DataFrame(study.metrics().to_dict())
        self.assertEqual(frame["sparc_forward"].to_list(), study.metrics()["sparc_forward"].to_list())
        trial = study.trial("P01", "S01", 10)
        arrays = pandas.DataFrame({name: trial[name].to_list() for name in ("t_s", "theta_dot_rad_s")})
        self.assertEqual(zwidth.smoothness(arrays["t_s"], arrays["theta_dot_rad_s"]), zwidth.smoothness(trial["t_s"], trial["theta_dot_rad_s"]))


@has("numpy")
class Numpy(unittest.TestCase):
    def test_columns_are_arrays_and_arrays_may_be_strided(self):
        import numpy

        trial = zwidth.read_study(ROOT, STUDY).trial("P01", "S01", 10)
        t, velocity = numpy.asarray(trial["t_s"]), numpy.asarray(trial["theta_dot_rad_s"])
        self.assertEqual((t.dtype, len(t)), (numpy.float64, len(trial)))
        both = numpy.column_stack([t, velocity])
        self.assertFalse(both[:, 0].flags["C_CONTIGUOUS"])
        self.assertEqual(zwidth.smoothness(both[:, 0], both[:, 1]), zwidth.smoothness(t, velocity))
        for wrong in (both, t.astype("float32"), t.astype("int64"), t.astype(">f8"), numpy.array(["a"])):
            with self.assertRaisesRegex(zwidth.ZwidthError, "float64"):
                zwidth.smoothness(wrong, velocity)

    def test_a_hundred_thousand_calls_leak_nothing(self):
        import numpy

        t = numpy.arange(200) / 100
        velocity = numpy.sin(t)
        bad = velocity.copy()
        bad[3] = math.nan

        def calls(count):
            for _ in range(count):
                zwidth.onset(t, velocity)
                try:
                    zwidth.onset(t, bad)
                except zwidth.ZwidthError:
                    pass

        def tables(count):
            study = zwidth.read_study(ROOT, STUDY)
            trial = study.trial("P01", "S01", 10)
            for _ in range(count):
                numpy.asarray(trial["t_s"])
                study.participants().__arrow_c_stream__()
                zwidth.smoothness(t, velocity)

        calls(5_000), tables(300)
        before = memory_mib()
        calls(50_000), tables(2_000)
        gc.collect()
        self.assertLess(memory_mib() - before, 8)


if __name__ == "__main__":
    unittest.main()
