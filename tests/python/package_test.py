"""The package gives the results of the command line, and names what it refuses. package_test.py HYSTCAN"""
import copy
import json
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import tomllib
import unittest
import warnings

import hystcan
import numpy

PROGRAM = sys.argv.pop(1)
MODEL = hystcan.shipped("piezo.model.toml")
STAGE = hystcan.shipped("piezo.toml")


def oscillation(rows, amplitude=45.0):
    t = numpy.arange(rows) * 1e-3
    return t, 50 + amplitude * numpy.sin(5 * t) * numpy.cos(0.3 * t)


class Scratch(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def write(self, name, header, *columns):
        numpy.savetxt(self.folder / name, numpy.column_stack(columns), delimiter=",", header=header, comments="",
                      fmt="%.17g")

    def hystcan(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], cwd=self.folder, check=True, capture_output=True, text=True)
        return done.stdout

    def columns(self, name):
        return numpy.loadtxt(self.folder / name, delimiter=",", skiprows=1, unpack=True)


class Models(Scratch):
    def test_simulate_gives_the_bits_of_the_command(self):
        t, u = oscillation(5000)
        self.write("in.csv", "time_s,input", t, u)
        for kind in ("piezo", "galfenol"):
            model = hystcan.shipped(kind + ".model.toml")
            self.hystcan("simulate", model, "--overwrite", "--input", "in.csv", "--output", "out.csv")
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                y = hystcan.Model.load(model).simulate(u)
            numpy.testing.assert_array_equal(y, self.columns("out.csv")[2])

    def test_inverse_and_simulate_are_a_round_trip(self):
        model = hystcan.Model.load(MODEL)
        y = 15 + 12 * numpy.sin(numpy.arange(2000) * 0.02)
        numpy.testing.assert_allclose(model.simulate(model.inverse(y)), y, atol=1e-9)

    def test_a_memory_continues_from_its_state(self):
        model = hystcan.Model.load(MODEL)
        _, u = oscillation(1000)
        memory = model.memory()
        parts = [model.simulate(part, memory) for part in (u[:300], u[300:])]
        numpy.testing.assert_array_equal(numpy.concatenate(parts), model.simulate(u))

    def test_copies_of_a_memory_are_independent(self):
        memory = hystcan.Model.load(MODEL).memory()
        memory.step(80.0)
        for same in (memory.copy(), copy.copy(memory), copy.deepcopy(memory)):
            same.step(10.0)
        self.assertEqual(memory.input, 80.0)

    def test_a_saved_memory_is_restored_to_the_bit(self):
        model = hystcan.Model.load(MODEL)
        memory = model.memory()
        model.simulate(oscillation(500)[1], memory)
        memory.save(self.folder / "memory.toml")
        again = model.load_memory(self.folder / "memory.toml")
        numpy.testing.assert_array_equal(again.turning_inputs, memory.turning_inputs)
        _, u = oscillation(500, 30.0)
        numpy.testing.assert_array_equal(model.simulate(u, again), model.simulate(u, memory))

    def test_inputs_beyond_the_thresholds_are_limited_with_a_warning(self):
        model = hystcan.Model.load(MODEL)
        with self.assertWarnsRegex(RuntimeWarning, "1 of 2 inputs are out of range"):
            y = model.simulate([120.0, 50.0])
        self.assertAlmostEqual(y[0], model.output_range()[1])

    def test_an_invalid_signal_is_refused(self):
        model = hystcan.Model.load(MODEL)
        with self.assertRaisesRegex(ValueError, r"u\[1\] is nan, expected a finite number"):
            model.simulate([1.0, numpy.nan])
        with self.assertRaisesRegex(ValueError, "u has 2 dimensions, expected 1"):
            model.simulate(numpy.zeros((2, 2)))
        with self.assertRaisesRegex(ValueError, "belongs to another model"):
            model.simulate([1.0], hystcan.Model.load(MODEL).memory())
        with self.assertRaisesRegex(hystcan.Error, "none.toml: cannot be read"):
            hystcan.Model.load(self.folder / "none.toml")

    def test_creep_gives_the_bits_of_the_command(self):
        model, t, u = self.creeping_model()
        self.assertEqual(model.creep, {"per_decade": 0.023, "from_s": 0.01, "to_s": 3.0})
        self.write("in.csv", "time_s,input", t, u)
        self.hystcan("simulate", "stage.toml", "--input", "in.csv", "--output", "out.csv", "--save-memory", "end.toml")
        memory = model.memory()
        y = model.simulate(u, memory, t=t)
        numpy.testing.assert_array_equal(y, self.columns("out.csv")[2])
        self.assertEqual((memory.output, memory.time_s), (y[-1], t[-1]))
        memory.save(self.folder / "again.toml")
        self.assertEqual(tomllib.loads((self.folder / "again.toml").read_text()),
                         tomllib.loads((self.folder / "end.toml").read_text()))

    def test_creep_is_inverted_exactly_at_uneven_times(self):
        model, t, _ = self.creeping_model()
        y = 15 + 12 * numpy.sin(numpy.arange(t.size) * 0.02)
        numpy.testing.assert_allclose(model.simulate(model.inverse(y, t=t), t=t), y, rtol=0, atol=1e-9)

    def test_creep_continues_from_a_saved_memory(self):
        model, t, u = self.creeping_model()
        whole, memory = model.simulate(u, t=t), model.memory()
        model.simulate(u[:300], memory, t=t[:300])
        memory.save(self.folder / "memory.toml")
        again = model.load_memory(self.folder / "memory.toml")
        lowest, highest = model.output_range(again)
        self.assertTrue(lowest < again.output < highest)
        self.assertEqual([again.step(*row) for row in zip(u[300:310], t[300:310])], list(whole[300:310]))
        numpy.testing.assert_array_equal(model.simulate(u[310:], again, t=t[310:]), whole[310:])

    def test_creep_needs_increasing_times(self):
        model, t, u = self.creeping_model()
        with self.assertRaisesRegex(ValueError, "stage.toml: the model has creep, expected the times t"):
            model.simulate(u)
        with self.assertRaisesRegex(ValueError, "t has 499 values, expected 500"):
            model.inverse(u[:500], t=t[:499])
        with self.assertRaisesRegex(ValueError, r"t\[1\] is 1 after 1, expected an increasing time"):
            model.simulate([0.0, 1.0], t=[1.0, 1.0])
        memory = model.memory()
        memory.step(50.0, 3.0)
        for late in (lambda: memory.step(60.0, 3.0), lambda: model.simulate([60.0], memory, t=[2.0])):
            with self.assertRaisesRegex(ValueError, "after 3, expected an increasing time"):
                late()
        with self.assertRaisesRegex(ValueError, "has creep, expected the time t"):
            memory.step(60.0)

    def test_quasi_static_is_the_model_without_creep(self):
        model, t, u = self.creeping_model()
        alone, plain = model.quasi_static(), hystcan.Model.load(MODEL)
        self.assertIsNone(alone.creep)
        numpy.testing.assert_array_equal(alone.simulate(u), plain.simulate(u, t=t))
        with self.assertRaisesRegex(ValueError, "belongs to another model"):
            alone.simulate(u, model.memory())
        record = t, u, model.simulate(u, t=t)
        self.assertLess(hystcan.validate(model, *record)["rms_percent"], 1e-6)
        self.assertGreater(hystcan.validate(alone, *record)["rms_percent"], 0.1)

    def creeping_model(self):
        """The shipped model with creep, and inputs at uneven times."""
        text = pathlib.Path(MODEL).read_text() + "\n[creep]\nper_decade = 0.023\nfrom_s = 0.01\nto_s = 3.0\n"
        (self.folder / "stage.toml").write_text(text)
        u = oscillation(1000)[1]
        t = numpy.cumsum(numpy.where(numpy.arange(u.size) % 50 == 0, 2.0, 1e-3))
        return hystcan.Model.load(self.folder / "stage.toml"), t, u

    def test_arrays_of_other_kinds_are_accepted(self):
        model = hystcan.Model.load(MODEL)
        u = numpy.arange(20, dtype=numpy.int32)
        numpy.testing.assert_array_equal(model.simulate(u[::2]), model.simulate(u.astype(float)[::2].copy()))


class Identification(Scratch):
    def test_identify_gives_the_model_of_the_command(self):
        t, u = oscillation(4000)
        y = hystcan.Model.load(MODEL).simulate(u)
        self.write("record.csv", "time_s,input,output", t, u, y)
        command = json.loads(self.hystcan("identify", "record.csv", "--output", "model.toml", "--json", "--order", "4"))
        found = hystcan.identify(t, u, y, order=4)
        self.assertEqual(found.report, command)
        found.save(self.folder / "again.toml")
        self.assertEqual((self.folder / "again.toml").read_text(), (self.folder / "model.toml").read_text())
        numpy.testing.assert_array_equal(found.model.simulate(u),
                                         hystcan.Model.load(self.folder / "model.toml").simulate(u))
        command = json.loads(self.hystcan("validate", "model.toml", "record.csv", "--json"))
        report = hystcan.validate(found.model, t, u, y)
        self.assertEqual(report.pop("predicted").size, t.size)
        self.assertEqual(command.pop("findings"), [])  # of the file: arrays are used unchanged
        self.assertEqual(report, command)

    def test_several_records_are_one_model(self):
        records = [oscillation(3000), oscillation(3000, 30.0)]
        model = hystcan.Model.load(MODEL)
        t, u = zip(*records)
        found = hystcan.identify(t, u, [model.simulate(each) for each in u], order=4)
        self.assertEqual(len(found.report["records"]), 2)

    def test_an_invalid_record_is_refused(self):
        t, u = oscillation(100)
        with self.assertRaisesRegex(ValueError, "100, 100, 99 values"):
            hystcan.identify(t, u, u[1:])
        with self.assertRaisesRegex(ValueError, "expected an increasing time"):
            hystcan.identify(t[::-1], u, u)
        with self.assertRaisesRegex(ValueError, "expected \"none\", \"even\" or \"butterfly\""):
            hystcan.identify(t, u, u, symmetry="odd")
        with self.assertRaises(hystcan.Error):
            hystcan.identify(t, u, numpy.zeros(100))

    def test_a_unit_with_a_control_character_is_refused(self):
        t = numpy.arange(100.0)
        with self.assertRaisesRegex(ValueError, "input_unit contains a control character"):
            hystcan.identify(t, t, t, input_unit="V\n[creep]")


class Rehearsals(Scratch):
    def test_a_rehearsal_equals_the_demo(self):
        self.hystcan("demo", "--output", "demo")
        demo = hystcan.Run.open(self.folder / "demo/inverse+pi.csv").read(["reference_um", "position_um"], axis="x")
        ours = hystcan.Rehearsal(STAGE).run()["x"]
        rows = min(demo["time_s"].size, ours["time_s"].size) - 20  # at the end, the demo holds and the rehearsal repeats
        self.assertGreater(rows, 2000)
        numpy.testing.assert_allclose(ours["position_um"][:rows], demo["position_um"][:rows], atol=1e-6)

    def test_settings_change_between_steps(self):
        stage = hystcan.Rehearsal(STAGE)
        stage.step(2.0)
        self.assertEqual(stage.status(), {"x": "tracking", "y": "tracking"})
        stage.go_to("x", 12.5)
        stage.set("x", "kp", 0.1)
        stage.step(1.0)
        self.assertAlmostEqual(stage.signals("x")["true_position_um"][-1], 12.5, delta=0.05)
        with self.assertRaises(hystcan.Error):
            stage.set("x", "kp", -1.0)
        with self.assertRaisesRegex(hystcan.Error, "outside"):
            stage.go_to("x", 1e3)

    def test_another_trajectory_is_followed_once(self):
        t = numpy.linspace(0.0, 1.0, 101)
        y = 10 + 4 * numpy.sin(2 * numpy.pi * t) ** 2
        stage = hystcan.Rehearsal(STAGE, reference={"x": (t, y)}, settings={"axis[0].control.kp": 0.05})
        x = stage.run()["x"]
        tracked = x["state"] == 4
        self.assertAlmostEqual(numpy.nanmax(x["reference_um"][tracked]), 14.0, places=2)
        self.assertLess(numpy.sqrt(numpy.nanmean(x["error_um"][tracked] ** 2)), 0.3)

    def test_refusals_of_the_controller_are_raised(self):
        with self.assertRaisesRegex(hystcan.Error, "kp"):
            hystcan.Rehearsal(STAGE, settings={"axis[0].control.kp": -5})
        with self.assertRaisesRegex(hystcan.Error, "ranges from 0 to 1e\\+09 um, expected"):
            hystcan.Rehearsal(STAGE, reference={"x": ([0, 1], [0, 1e9])})
        with self.assertRaisesRegex(hystcan.Error, "unknown axis z, expected one of x, y"):
            hystcan.Rehearsal(STAGE, reference={"z": ([0, 1], [1, 2])})


class Runs(Scratch):
    def setUp(self):
        super().setUp()
        (self.folder / "c.csv").write_text("cycle,time_s,axis,state,fault,error_um,position_um\n"
                                           "1,0.001,x,tracking,none,0.5,1.25\n2,0.002,x,tracking,none,,1.5\n")

    def test_a_run_is_read_as_arrays(self):
        run = hystcan.Run.open(self.folder / "c.csv")
        self.assertEqual(run.axes, ["x"])
        x = run.read(["position_um", "error_um"])
        numpy.testing.assert_array_equal(x["position_um"], [1.25, 1.5])
        self.assertTrue(numpy.isnan(x["error_um"][1]))
        self.assertEqual(run.words()["state"][4], "tracking")
        self.assertEqual(run.units()["position_um"], "um")
        self.assertEqual(run.read(from_s=0.0015)["cycle"], [2.0])

    def test_a_step_has_the_figures_of_the_report_and_of_plot(self):
        before, _, after = STAGE.read_text().partition("[[axis.control.setpoint]]")
        step = '[[axis.control.setpoint]]\nkind = "step"\nfrom_um = 2.0\nto_um = 5.0\ndwell_s = 0.3\n'
        text = before + step + after[after.index("[axis.twin]"):]
        (self.folder / "stage.toml").write_text(text.replace('= "piezo.', f'= "{STAGE.parent}/piezo.')
                                                .replace('"hystcan.dbc"', f'"{STAGE.parent}/hystcan.dbc"'))
        demo = json.loads(self.hystcan("demo", "--config", "stage.toml", "--output", "demo", "--json"))
        report = {column["structure"]: column["segments"][0]["steps"] for column in demo["columns"]}["inverse+pi"]
        x = hystcan.Run.open(self.folder / "demo/inverse+pi.csv").read(axis="x")
        x["position_um"][x["sample_missing"] == 1] = numpy.nan
        rows = [x[name][x["state"] == 4] for name in ("time_s", "reference_um", "position_um")]
        ours = hystcan.step_response(*rows, tolerance_um=report["band_um"])
        self.assertAlmostEqual(ours["settling_s"], report["settling_s"], places=12)
        self.assertAlmostEqual(ours["overshoot_percent"], report["overshoot_percent"], places=9)
        table = self.hystcan("plot", "demo/inverse+pi.csv", "--kind", "step", "--axis", "x", "--table", "csv")
        ours = hystcan.step_response(*rows)  # the band of a CSV
        self.assertEqual(table.splitlines()[1].split(",")[-3:],
                         [f"{1e3 * ours['rise_s']:.1f}", f"{ours['overshoot_percent']:.1f}",
                          f"{1e3 * ours['settling_s']:.1f}"])

    def test_a_transition_is_not_a_step(self):
        nan = float("nan")
        reference = [0.0] * 20 + [nan] * 5 + [9.0] * 20 + [10.0] * 20
        step = hystcan.step_response(range(65), reference, reference)
        self.assertEqual((step["from_um"], step["to_um"], step["begin_s"]), (9.0, 10.0, 45.0))

    def test_missing_signals_are_refused(self):
        run = hystcan.Run.open(self.folder / "c.csv")
        with self.assertRaisesRegex(hystcan.Error, "no signal speed"):
            run.read(["speed"])
        with self.assertRaisesRegex(hystcan.Error, "no axis z"):
            run.read(axis="z")
        with self.assertRaises(hystcan.Error):
            hystcan.Run.open(self.folder)


class Commands(Scratch):
    """A test server answers as documented in docs/control_socket.md."""

    def serve(self, *answers):
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(self.folder / "s"))
        listener.listen()
        self.asked = []
        left = list(answers)

        def answer(connection):
            with connection, connection.makefile("rw") as lines:
                while left and (line := lines.readline()):
                    self.asked.append(json.loads(line))
                    lines.write(json.dumps(left.pop(0)) + "\n")
                    lines.flush()

        def accept():
            while True:
                threading.Thread(target=answer, args=(listener.accept()[0],), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        return self.folder / "s"

    def test_commands_are_lines_of_the_protocol(self):
        path = self.serve({"ok": True}, {"ok": True, "position_um": 12.5}, {"ok": True, "changed": []})
        with hystcan.Client(path) as stage:
            stage.go_to("x", 12.5)
            self.assertEqual(stage.wait("x", 5.0), 12.5)
            stage.set("x", "kp", 0.08)
        self.assertEqual(self.asked, [{"do": "go_to", "axis": "x", "position_um": 12.5},
                                      {"do": "wait", "axis": "x", "timeout_s": 5.0},
                                      {"do": "set", "axis": "x", "key": "kp", "value": 0.08}])

    def test_an_exception_stops_the_stage(self):
        path = self.serve({"ok": False, "error": "x: faulted"}, {"ok": True})
        with self.assertRaisesRegex(hystcan.Refused, "x: faulted"):
            with hystcan.Client(path) as stage:
                stage.enable("x")
        self.assertEqual(self.asked[-1], {"do": "stop"})

    def test_a_socket_without_a_listener_is_an_os_error(self):
        with self.assertRaises(OSError):
            hystcan.Client(self.folder / "none")


class Misuse(Scratch):
    """Misuse raises an exception; a notebook with a day of work continues."""

    def python(self, text):
        return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)

    def test_new_makes_no_object_that_was_never_constructed(self):
        for kind in (hystcan.Model, hystcan.Memory, hystcan.Identified, hystcan.Run):
            with self.assertRaises(TypeError):
                kind.__new__(kind)
            with self.assertRaises(TypeError):
                kind()
        with self.assertRaises(TypeError):
            copy.copy(hystcan.Model.load(MODEL))
        stage = hystcan.Rehearsal.__new__(hystcan.Rehearsal)
        for use in (lambda: stage.step(1.0), stage.run, stage.signals, stage.status, lambda: stage.go_to("x", 1.0),
                    lambda: stage.axes, lambda: stage.time_s, lambda: stage.set("x", "kp", 1)):
            with self.assertRaisesRegex(TypeError, "__init__ was not called"):
                use()
        stage.__init__(STAGE)
        stage.step(0.1)

    def test_a_daemon_thread_inside_a_long_call_does_not_abort_the_end(self):
        for call in ("stage.step(1000.0)", "hystcan.identify(t, u, model.simulate(u))"):
            ended = self.python(f"""
import hystcan, numpy, threading, time
stage = hystcan.Rehearsal(hystcan.shipped("piezo.toml"))
model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
t = numpy.arange(50000) * 1e-3
u = 50 - 50 * (1 - t / 100) * numpy.cos(7 * t)
begins = threading.Event()
threading.Thread(target=lambda: (begins.set(), {call}), daemon=True).start()
begins.wait()
time.sleep(0.5)  # the call takes time; on a slow machine the end is closer to its start
""")
            self.assertEqual((ended.returncode, ended.stderr), (0, ""))

    def test_a_rehearsal_is_used_by_one_thread_at_a_time(self):
        stage = hystcan.Rehearsal(STAGE)
        refusals = 0
        while not refusals:  # a busy machine may give this thread no time during a step
            thread = threading.Thread(target=stage.step, args=(100.0,))
            thread.start()
            while thread.is_alive():
                try:
                    stage.status()
                except RuntimeError as refused:
                    self.assertIn("another thread", str(refused))
                    refusals += 1

    def test_memory_and_file_errors_are_python_exceptions(self):
        many = numpy.broadcast_to(numpy.float32(1.0), (2**44,))
        with self.assertRaises(MemoryError):
            hystcan.Model.load(MODEL).simulate(many)
        with self.assertRaises(OSError):
            hystcan.Model.load(MODEL).memory().save(self.folder / "none" / "memory.toml")

    def test_values_that_no_fit_can_square_are_refused(self):
        t, u = oscillation(2000)
        y = hystcan.Model.load(MODEL).simulate(u)
        for scale in (1e160, 1e-320, 1e300):
            with self.assertRaisesRegex(ValueError, "output"):
                hystcan.identify(t, u, y * scale)


if __name__ == "__main__":
    unittest.main()
