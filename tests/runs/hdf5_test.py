"""h5py and numpy open the files of `hystcan export --hdf5`, even from a killed run.

hdf5_test.py HYSTCAN BENCH_RECORDER: BENCH_RECORDER records 8 axes at 4 kHz until it is killed.
"""
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import h5py
import numpy

HYSTCAN, RECORDER = sys.argv[1:3]
KILLS = 5


def hystcan(*words, folder):
    subprocess.run([HYSTCAN, *map(str, words)], cwd=folder, check=True, capture_output=True, text=True)


class Hdf5(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def killed_run(self, seconds):
        """Every row belongs to a whole cycle of eight axes, until the kill, after at least 40 ms of cycles."""
        folder = self.folder / str(seconds)
        recorder = subprocess.Popen([RECORDER, "3600", folder], stdout=subprocess.DEVNULL)
        while not any(csv.stat().st_size > 400_000 for csv in folder.glob("run_*/cycles_0001.csv")):
            time.sleep(0.01)
        time.sleep(seconds)
        recorder.send_signal(signal.SIGKILL)
        recorder.wait()
        return next(folder.glob("run_*"))

    def test_killed_runs_open_in_h5py_with_every_row_of_the_csv(self):
        moments = random.Random(20261123)
        for _ in range(KILLS):
            run = self.killed_run(moments.uniform(0.0, 1.0))
            hystcan("export", run, "--hdf5", folder=self.folder)
            _, header, *lines = (run / "cycles_0001.csv").read_text().splitlines()
            names = header.split(",")
            rows = [line.split(",") for line in lines]
            if len(rows[-1]) != len(names):
                rows.pop()
            with h5py.File(self.folder / (run.name + ".h5")) as file:
                self.assertEqual(file.attrs["ended"], "")
                for axis in (f"axis{i}" for i in range(8)):
                    cycles = [int(row[names.index("cycle")]) for row in rows if row[names.index("axis")] == axis]
                    numpy.testing.assert_array_equal(numpy.asarray(file[f"{axis}/cycle"]), cycles)

    def test_columns_match_the_csv_with_units_and_words(self):
        run = self.killed_run(0.1)
        hystcan("export", run, "--axis", "axis3", "--output", "a.h5", folder=self.folder)
        hystcan("export", run, "--axis", "axis3", "--output", "a.csv", folder=self.folder)
        lines = [line for line in (self.folder / "a.csv").read_text().splitlines() if not line.startswith("#")]
        csv = numpy.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8")
        with h5py.File(self.folder / "a.h5") as file:
            axis = file["axis3"]
            self.assertEqual(set(axis), set(csv.dtype.names))
            self.assertEqual(axis["drive"].attrs["unit"], "V")
            self.assertEqual(axis.attrs["drive_unit"], "V")
            for name in ("time_s", "reference_um", "position_um", "drive", "turnaround_us"):
                numpy.testing.assert_array_equal(numpy.asarray(axis[name]), csv[name])
            words = {number: word for word, number in h5py.check_enum_dtype(axis["state"].dtype).items()}
            self.assertEqual([words[state] for state in axis["state"]], list(csv["state"]))
            self.assertIn("[bus]", file["config/piezo.toml"][()].decode())

    def test_interval_and_signals_are_selected(self):
        run = self.killed_run(0.1)
        hystcan("export", run, "--hdf5", "--axis", "axis0", "--signals", "drive", "--from", "0.01", "--to", "0.02",
                "--output", "part.h5", folder=self.folder)
        with h5py.File(self.folder / "part.h5") as file:
            self.assertEqual(set(file["axis0"]), {"time_s", "drive"})
            self.assertEqual((file["axis0/time_s"][0], file["axis0/time_s"][-1]), (0.01, 0.02))

    def test_rows_of_simulate_are_written_and_read(self):
        with h5py.File(self.folder / "in.h5", "w") as file:
            file["time_s"] = numpy.arange(1000) * 1e-3
            file["input"] = 50 + 40 * numpy.sin(numpy.arange(1000) * 0.01)
            file["input"].attrs["unit"] = "V"
        model = pathlib.Path(__file__).parents[2] / "config/piezo.model.toml"
        hystcan("simulate", model, "--input", "in.h5", "--output", "out.h5", folder=self.folder)
        with h5py.File(self.folder / "in.h5") as given, h5py.File(self.folder / "out.h5") as made:
            numpy.testing.assert_array_equal(given["input"], made["input"])
            self.assertEqual(made["output"].attrs["unit"], "um")
            self.assertTrue(numpy.isfinite(made["output"]).all())

    def refused_export(self, environment, before=""):
        (self.folder / "no_h5py").write_text('#!/bin/sh\nexec /usr/bin/python3 -S "$@"\n')
        (self.folder / "no_h5py").chmod(0o755)
        run = self.killed_run(0.1)
        result = subprocess.run(["sh", "-c", f"{before} exec '{HYSTCAN}' export '{run}' --output run.h5"], text=True,
                                cwd=self.folder, env=environment, capture_output=True, check=False)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual([file.name for file in self.folder.glob("run.h5*")], [])
        hystcan("export", run, "--axis", "axis0", "--output", "run.csv", folder=self.folder)
        return result.stderr

    def test_without_python_the_package_is_named_and_csv_is_exported(self):
        self.assertIn("cannot be started: No such file or directory; install python3-h5py\n",
                      self.refused_export({"HYSTCAN_PYTHON": "/nonexistent"}))

    def test_without_h5py_the_package_is_named_and_csv_is_exported(self):
        self.assertIn("the Python module h5py is missing; install python3-h5py, or use CSV\n",
                      self.refused_export({"HYSTCAN_PYTHON": str(self.folder / "no_h5py")}))

    def test_a_full_disk_leaves_no_file(self):
        self.assertIn("cannot be written: File too large\n", self.refused_export({}, "ulimit -f 16;"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
