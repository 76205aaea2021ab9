"""The module without NumPy, pyarrow, pandas or polars, and what it refuses.

    python tests/interop/python/bare.py --root ROOT     (a folder whose study thesis-twin is up to date)
"""

import array
import ctypes
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import zwidth

ROOT = pathlib.Path(sys.argv.pop()) if len(sys.argv) > 2 and sys.argv[-2] == "--root" else pathlib.Path()
sys.argv = [argument for argument in sys.argv if argument != "--root"]
STUDY = "thesis-twin"
REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
STICKING = str(REPOSITORY / "raw" / STUDY / "scenes" / "step.toml")
SPRING = {"kind": "spring", "stiffness_n_per_rad": 4.0, "rest_rad": -0.785}


def doubles(values):
    return array.array("d", values)


def movement():
    """A raised cosine there and back on a spring with dry friction: t, theta, force, velocity."""
    t = [i / 1000 for i in range(3001)]
    phase = [math.pi * min(max(x - 0.5, 0.0), 2.0) for x in t]
    theta = [-0.785 + 0.5 * (1 - math.cos(p)) for p in phase]
    velocity = [0.5 * math.pi * math.sin(p) for p in phase]
    force = [4.0 * (x + 0.785) + math.copysign(0.1, v) for x, v in zip(theta, velocity)]
    return [doubles(values) for values in (t, theta, force, velocity)]


class Refused(unittest.TestCase):
    """Each refusal is a ZwidthError that says where, what, and what to do."""

    def refused(self, words, function, *arguments, **keywords):
        with self.assertRaises(zwidth.ZwidthError) as caught:
            function(*arguments, **keywords)
        self.assertIn(words, str(caught.exception))
        return caught.exception

    def test_what_is_no_array_of_float64(self):
        t, theta, force, _ = movement()
        for wrong in (list(t), array.array("f", t), array.array("q", range(len(t))), memoryview(t).cast("B").cast("d", (3001, 1)), "text", None):
            error = self.refused("float64", zwidth.trial_metrics, wrong, theta, force)
            self.assertEqual((error.column, error.row), ("t", None))
            self.assertIn("one-dimensional", error.remedy)

    def test_arrays_of_ctypes_are_taken_as_those_of_array(self):
        given = movement()
        by_ctypes = [(ctypes.c_double * len(values))(*values) for values in given]
        t, theta, force, velocity = by_ctypes
        found = zwidth.trial_metrics(t, theta, force, velocity=velocity)
        t, theta, force, velocity = given
        self.assertEqual(found.to_dict(), zwidth.trial_metrics(t, theta, force, velocity=velocity).to_dict())
        plane = ((ctypes.c_double * 2) * 3)()
        self.refused("float64", zwidth.trial_metrics, plane, theta, force)

    def test_numbers_that_are_none_unequal_lengths_and_time_that_stands(self):
        t, theta, force, _ = movement()
        for bad in (math.nan, math.inf):
            broken = doubles(theta)
            broken[41] = bad
            error = self.refused("is no number", zwidth.trial_metrics, t, broken, force)
            self.assertEqual((error.column, error.row), ("theta", 42))
        error = self.refused("3000 values, where t has 3001", zwidth.trial_metrics, t, theta, force[:-1])
        self.assertEqual(error.column, "force")
        standing = doubles(t)
        standing[7] = standing[6]
        error = self.refused("does not come after", zwidth.smoothness, standing, theta)
        self.assertEqual((error.column, error.row), ("t", 8))
        self.refused("0 samples", zwidth.trial_metrics, doubles([]), doubles([]), doubles([]))

    def test_scenes(self):
        t, theta, force, _ = movement()
        of = lambda scene: self.refused("", zwidth.trial_metrics, t, theta, force, scene=scene).column
        self.assertEqual(of({"kind": "cushion"}), "kind")
        self.assertEqual(of({"kind": "spring", "rest_rad": 0.0}), "stiffness_n_per_rad")
        self.assertEqual(of({"kind": "free", "wall_rad": 0.0}), "wall_rad")
        self.refused("check the path", zwidth.simulate, "no such scene.toml")
        self.refused("neither a path nor a dict", zwidth.simulate, 7)
        self.refused("not a scene", zwidth.simulate, {"name": "nothing else"})
        error = self.refused("no such key", zwidth.simulate, STICKING, plant__weight_kg=1.0)
        self.assertEqual((error.file, error.column), (STICKING, "plant.weight_kg"))
        error = self.refused("must be above 0", zwidth.simulate, STICKING, plant__mass_kg=doubles([0.1, -1.0]))
        self.assertEqual((error.column, error.row), ("plant.mass_kg", 2))
        self.refused("arrays of one length", zwidth.simulate, STICKING, plant__mass_kg=doubles([1, 2]), step_s=doubles([1, 2, 3]))
        self.refused("choose one of", zwidth.simulate, STICKING, solver="rk5")
        self.refused("2 to 2000", zwidth.stability_map, STICKING, cells=10**9)
        self.refused("choose one of", zwidth.stability_map, STICKING, x="warmth")

    def test_more_numbers_than_memory_should_hold(self):
        self.refused("numbers", zwidth.simulate, STICKING, samples=True, step_s=1e-5, plant__mass_kg=doubles([0.1] * 1000))
        self.refused("samples", zwidth.simulate, STICKING, step_s=1e-12)

    def test_answers_that_are_no_counts(self):
        level = doubles(range(1, 6))
        for positive in ([1, 2, 3, 4, 5.5], [1, 2, 3, 4, -5], [1, 2, 3, 4, 50]):
            self.refused("", zwidth.fit_psychometric, level, doubles([20] * 5), doubles(positive))

    def test_studies_and_files(self):
        self.refused("no such study", lambda: zwidth.read_study(ROOT, "no such study"))
        error = self.refused("study.toml", zwidth.read_study, ROOT, "absent")
        self.assertIn("absent", error.file)
        self.refused("", zwidth.read_trial, STICKING)
        study = zwidth.read_study(ROOT, STUDY)
        self.refused("there is no trial 999", study.trial, "P01", "S01", 999)
        self.refused("familiarisation", study.trial, "P01", "S01", 1)
        self.refused("no trial has such a column", study.samples, ["t_s", "warmth"])
        self.refused("no tasks", study.thresholds)


class Values(unittest.TestCase):
    """Numbers by closed forms."""

    def test_a_spring_with_dry_friction(self):
        t, theta, force, velocity = movement()
        found = {name: values[0] for name, values in zwidth.trial_metrics(t, theta, force, velocity=velocity, lever_m=0.045, scene=SPRING).to_dict().items()}
        self.assertAlmostEqual(found["discrepancy_user_mean_n"], 0.2, 9)
        # The loop between the onset and the end, at 10 and 5 degrees a second: 2 F_C over most of the way, times the lever.
        self.assertAlmostEqual(found["loop_area_j"], 2 * 0.1 * 1.0 * 0.045, 4)
        self.assertAlmostEqual(found["stiffness_n_per_rad"], 4.0, 2)
        begins, ends = zwidth.onset(t, velocity)
        self.assertEqual(begins, found["onset_s"])
        self.assertEqual(ends, found["end_s"])

    def test_a_minimum_jerk_movement_is_as_smooth_as_published(self):
        t = doubles(1.5 * i / 1000 for i in range(1001))
        speed = doubles(30 * (x / 1.5) ** 2 * (1 - x / 1.5) ** 2 for x in t)
        self.assertAlmostEqual(zwidth.smoothness(t, speed), -1.4024260629108702, 9)
        self.assertIsNone(zwidth.smoothness(doubles([0, 1]), doubles([0, 1])))

    def test_one_movement_twice_has_its_own_forces_as_mean(self):
        t, theta, force, velocity = movement()
        mean = zwidth.means_by_branch([t, t], [theta, theta], [force, force], SPRING, velocity=[velocity, velocity]).to_dict()
        way_in = [(x, f, sd) for branch, x, f, sd in zip(mean["branch"], mean["theta_rad"], mean["force_ex_mean_n"], mean["force_ex_sd_n"]) if branch == "in"]
        self.assertEqual(len(way_in), 101)
        for x, f, sd in way_in[5:-5]:
            self.assertAlmostEqual(f, 4 * (x + 0.785) + 0.1, 3)
            self.assertAlmostEqual(sd, 0, 12)

    def test_a_sweep_is_its_runs_one_by_one_to_the_last_bit(self):
        masses = doubles([0.05, 0.08, 0.2])
        sweep = zwidth.simulate(STICKING, plant__mass_kg=masses, duration_s=1.0).table.to_dict()
        for i, mass in enumerate(masses):
            one = zwidth.simulate(STICKING, plant__mass_kg=mass, duration_s=1.0).table.to_dict()
            self.assertEqual({name: values[0] for name, values in one.items()}, {name: values[i] for name, values in sweep.items()})
        self.assertEqual(len(set(sweep["theta_max_rad"])), 3)

    def test_the_judge_passes_the_right_answer_and_finds_a_wrong_one(self):
        run = zwidth.simulate(STICKING, samples=True).trajectory(0)
        t, theta, velocity = (doubles(run[name].to_list()) for name in ("t_s", "theta_rad", "theta_dot_rad_s"))
        self.assertEqual(zwidth.judge(STICKING, t, theta, velocity).verdict, "right")
        late = doubles([theta[0]] * 40 + list(theta[:-40]))
        judged = zwidth.judge(STICKING, t, late)
        self.assertNotIn(judged.verdict, ("right", "stands"))
        self.assertGreater(len(judged.faults), 0)

    def test_a_straight_line_is_found_and_a_threshold(self):
        command = doubles(i / 10 for i in range(60))
        response = doubles(0.4 * c + 0.02 * math.sin(37 * i) for i, c in enumerate(command))
        fit = zwidth.fit_characteristic(command, response, resamples=20)
        slope = [e for m, p, e in zip(*(fit.parameters.to_dict()[name] for name in ("model", "parameter", "estimate"))) if m == fit.model]
        self.assertTrue(any(abs(value - 0.4) < 0.01 for value in slope), slope)
        found = zwidth.fit_psychometric(doubles([2.8, 3.2, 3.6, 4, 4.4, 4.8, 5.2]), doubles([20] * 7), doubles([1, 2, 5, 10, 15, 18, 19]), lapse=(0.0, 0.0))
        self.assertAlmostEqual(found.threshold, 4.0, 6)
        low, high = found.threshold_interval
        self.assertTrue(low < found.threshold < high)
        self.assertAlmostEqual(found.share(found.threshold), 0.5, 9)

    def test_a_map_of_walls(self):
        cells = zwidth.stability_map(STICKING, cells=5, rate=1000.0)
        self.assertEqual((len(cells), cells.units["stiffness"]), (25, "N/m"))
        self.assertEqual(len(zwidth.stability_limits(STICKING)), 7)


class Study(unittest.TestCase):
    """A study without any package."""

    def test_its_tables_as_lists(self):
        study = zwidth.read_study(ROOT, STUDY)
        trials = study.trials.to_dict()
        self.assertEqual((len(study.trials), sum(trials["counts"])), (39, 36))
        self.assertEqual({why for why in trials["why_not"] if why}, {"familiarisation"})
        metrics = study.metrics()
        self.assertEqual((len(metrics), metrics.units["wall_past_max_rad"]), (36, "rad"))
        self.assertIn("SYNTHETIC", study._repr_html_())
        self.assertIn("data:image/svg+xml;base64,", study._repr_html_())
        self.assertNotIn("<svg", study._repr_html_())
        self.assertTrue("<svg" in study.figure("verdicts"))
        self.assertEqual(len(study.samples()), 36)
        self.assertEqual(study.participants().to_dict(), {"participant": ["P01"], "trials": [36]})
        with self.assertRaisesRegex(KeyError, "there are"):
            metrics["warmth"]

    def test_results_that_are_not_up_to_date_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            for part in ("raw", "derived", "reports"):
                shutil.copytree(ROOT / part / STUDY, pathlib.Path(folder) / part / STUDY)
            self.assertEqual(len(zwidth.read_study(folder, STUDY).metrics()), 36)
            zwidth.command("exclude", STUDY, "-p", "P01", "-s", "S01", "--trial", "10", "a test", "--by", "E1", "--root", folder)
            with self.assertRaisesRegex(zwidth.ZwidthError, "run: zwidth run") as caught:
                zwidth.read_study(folder, STUDY).metrics()
            self.assertIn("S01", caught.exception.file)
            made = pathlib.Path(folder) / "derived" / STUDY / "compare" / "contrasts.parquet"
            made.unlink()
            with self.assertRaisesRegex(zwidth.ZwidthError, "another one than the run made|changed|does not count"):
                zwidth.read_study(folder, STUDY).contrasts()

    def test_it_is_read_and_never_written(self):
        before = {path: path.stat().st_mtime_ns for path in ROOT.rglob("*")}
        study = zwidth.read_study(ROOT, STUDY)
        study.metrics(), study.contrasts(), study.answers(), study._repr_html_(), study.trial("P01", "S01", 10).metrics()
        self.assertEqual(before, {path: path.stat().st_mtime_ns for path in ROOT.rglob("*")})


class Command(unittest.TestCase):
    def test_it_is_of_the_module_s_version(self):
        self.assertEqual(zwidth.command("--version").stdout.split(), ["zwidth", zwidth.__version__])
        self.assertTrue(os.access(zwidth.command(), os.X_OK))

    def test_what_it_refuses_is_raised(self):
        with self.assertRaisesRegex(zwidth.ZwidthError, "absent"):
            zwidth.command("verify", "absent", "--root", str(ROOT))


class Calls(unittest.TestCase):
    def test_ctrl_c_ends_a_long_call(self):
        long = "import array, zwidth; zwidth.simulate(%r, step_s=1e-4, plant__mass_kg=array.array('d', [0.05 + i * 1e-6 for i in range(200000)]))"
        program = "print('on', flush=True); " + long % STICKING
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        child.stdout.readline()
        child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=60)
        self.assertIn("KeyboardInterrupt", said)

    def test_other_threads_go_on_meanwhile(self):
        counted = []
        done = threading.Event()

        def count():
            while not done.is_set():
                counted.append(None)
                time.sleep(0)

        other = threading.Thread(target=count)
        other.start()
        before = len(counted)
        zwidth.simulate(STICKING, plant__mass_kg=doubles([0.05 + i * 1e-4 for i in range(200)]))
        during = len(counted) - before
        done.set()
        other.join()
        self.assertGreater(during, 10)


if __name__ == "__main__":
    unittest.main()
