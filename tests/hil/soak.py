#!/usr/bin/python3
"""soak.py PROGRAM CONFIG MINUTES SEED: controller, twin, page with a client and a recorder on vcan0, disturbed for MINUTES.

Drawn from SEED: faults of the twin, the link down and up, floods of foreign frames, reloads. After each one the faulted
axes are cleared and enabled and must track again. An axis may fault only by a fault that acts on it, or by the link; any
other fault is unexplained. Prints the result so far each minute, in words and as JSON with the key "soak". Exit status 1 if a
fault is unexplained, an axis does not return, a program has more descriptors or threads than at the begin, the recorder
loses rows, or, from 30 minutes on, the memory of a program grows by more than the bound below.
"""
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import time

WARM_UP_S = 300.0         # until then the memory of a page fills with rows: it does not count
JUDGED_S = 1800.0         # a shorter run has no slope
GROWTH_KB_PER_H = 256.0   # a page of 4 kB each minute
SETTLED_S = 20.0          # before descriptors and threads are counted for the first time
SAMPLE_S = 10.0

# The kinds of docs/twin.md, but for babbling_node, which on vcan takes the machine's time and not the wire's, and
# parameter_drift, which stays.
SENSOR = ("no_reply", "late", "duplicate", "out_of_order", "frozen_value", "frozen_counter", "wrong_crc", "wrong_length",
          "wrong_id_type", "out_of_range", "sensor_bad_status", "no_heartbeat", "emergency", "error_passive",
          "node_reboot", "bus_off", "sensor_gain", "sensor_offset")
AMPLIFIER = ("no_reply", "late", "duplicate", "out_of_order", "frozen_value", "frozen_counter", "wrong_crc",
             "wrong_length", "wrong_id_type", "no_heartbeat", "emergency", "error_passive", "watchdog_trip",
             "amplifier_trip", "node_reboot", "bus_off", "limited_output")
STAGE = ("resonance_shift", "load_step")
# Whatever the axis does, these fault none.
HARMLESS = {("duplicate", "sensor"), ("duplicate", "amplifier"), ("late", "amplifier"), ("out_of_order", "amplifier"),
            ("resonance_shift", None), ("load_step", None)}


class Client:
    """A connection to a control socket; it may write until it closes."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(20)
        self.socket.connect(path)
        self.lines = self.socket.makefile("rw")

    def ask(self, do, **keys):
        print(json.dumps({"do": do, **keys}), file=self.lines, flush=True)
        return json.loads(self.lines.readline())


class Program:
    """A process of the bench, with its output in files."""

    def __init__(self, name, command, priority=None):
        self.name, self.log = name, f"{name}.err"
        command = ["chrt", "--fifo", str(priority)] + command if priority else command
        with open(f"{name}.out", "w") as out, open(self.log, "w") as err:
            self.process = subprocess.Popen(command, stdout=out, stderr=err, stdin=subprocess.DEVNULL)
        self.samples = []

    def says(self, pattern, file=None):
        for _ in range(3000):
            if found := re.search(pattern, read(file or self.log)):
                return found
            if self.process.poll() is not None:
                break
            time.sleep(0.02)
        sys.exit(f"soak: {self.name} does not say {pattern!r}:\n{read(self.log)}")

    def status(self, key):
        return int(re.search(rf"^{key}:\s+(\d+)", read(f"/proc/{self.process.pid}/status"), re.M)[1])

    def descriptors(self):
        """A file or a connection may be open for a moment: the least of some looks counts."""
        return min(self.look(i) for i in range(5))

    def look(self, i):
        time.sleep(0.2 if i else 0.0)
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def sample(self, at_s):
        self.samples.append((at_s, self.status("VmRSS")))

    def growth_kB_per_h(self, from_s):
        """The slope of the line of least squares."""
        points = [(at_s / 3600.0, kB) for at_s, kB in self.samples if at_s >= from_s]
        mean_h = sum(h for h, _ in points) / len(points)
        mean_kB = sum(kB for _, kB in points) / len(points)
        return sum((h - mean_h) * (kB - mean_kB) for h, kB in points) / sum((h - mean_h) ** 2 for h, _ in points)


def read(path):
    with open(path) as file:
        return file.read()


class Bench:
    def __init__(self, hystcan, config, here):
        text = read(config)
        folder = os.path.abspath("stage")
        subprocess.run(["cp", "-r", os.path.dirname(config), folder], check=True)
        self.config = f"{folder}/piezo.toml"
        # The disk is the guest's memory. The controller's own is locked, as on a bench: all that it has counts.
        self.text = text.replace("[controller]\n", f'[controller]\ncontrol_socket = "{folder}/ctl.sock"\n'
                                 f'black_box_dir = "{folder}"\nblack_box_files = 5\n') \
            + "\n[record]\npart_MB = 16\nlimit_GB = 0.1\n\n[controller.realtime]\nlock_memory = true\n"
        self.write(self.text)
        self.twin = Program("twin", [hystcan, "twin", self.config, "--socket", f"{folder}/twin.sock"], 40)
        self.twin.says(": amplifier node")
        self.controller = Program("controller", [hystcan, "controller", self.config, "--record", f"{folder}/runs"], 50)
        self.controller.says("x: tracking")
        self.controller.says("y: tracking")
        self.page = Program("page", [hystcan, "page", self.config, "--listen", "127.0.0.1:0"])
        port = self.page.says(r"page: http://127.0.0.1:(\d+)/", "page.out")[1]
        self.browser = Program("browser", [sys.executable, "-I", "-S", f"{here}/page_clients.py", port, "1"])
        self.browser.says("all connected")
        self.programs = (self.controller, self.twin, self.page)
        self.ctl = Client(f"{folder}/ctl.sock")
        self.faults = Client(f"{folder}/twin.sock")

    def write(self, text):
        """As editors do, the new file takes the place of the old one."""
        with open(self.config + ".new", "w") as file:
            file.write(text)
        os.rename(self.config + ".new", self.config)

    def axes(self):
        """The axes in a cycle that is new: without the interface there is none."""
        for _ in range(100):
            status = self.ctl.ask("status")
            if status["age_s"] < 0.1:
                break
            time.sleep(0.1)
        return {axis["name"]: axis for axis in status["axes"]}

    def faulted(self):
        return {name: axis["fault"] for name, axis in self.axes().items() if axis["state"] == "faulted"}


class Soak:
    def __init__(self, bench, seed):
        self.bench, self.seed, self.random, self.began_s = bench, seed, random.Random(seed), time.monotonic()
        self.count = {"faults": 0, "faulted_axes": 0, "flaps": 0, "floods": 0, "reloads": 0, "unexplained": 0,
                      "not_returned": 0}
        self.next_sample_s = 0.0
        self.gain = 0
        self.ticks = [0] * 7

    def now_s(self):
        return time.monotonic() - self.began_s

    def wait(self, seconds):
        until_s = self.now_s() + seconds
        while (left_s := until_s - self.now_s()) > 0:
            time.sleep(min(left_s, 0.5))
            if self.now_s() >= self.next_sample_s:
                for program in self.bench.programs:
                    program.sample(self.now_s())
                self.next_sample_s += SAMPLE_S

    # Each disturbance returns what it is called and the axes that may fault by it.
    def twin_fault(self):
        node = self.random.choice(("sensor", "amplifier", None))
        kind = self.random.choice({"sensor": SENSOR, "amplifier": AMPLIFIER, None: STAGE}[node])
        axis, duration_s = self.random.choice("xy"), round(self.random.uniform(0.02, 0.6), 3)
        keys = {"node": node} if node else {}
        answer = self.bench.faults.ask("inject", kind=kind, axis=axis, duration_s=duration_s, **keys)
        if not answer["ok"]:
            sys.exit(f"soak: {answer['error']}")
        self.count["faults"] += 1
        self.wait(duration_s)
        return answer["fault"], set() if (kind, node) in HARMLESS else {axis}

    def link_flap(self):
        duration_s = self.random.uniform(0.01, 1.5)
        subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
        self.wait(duration_s)
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
        self.count["flaps"] += 1
        return "link flap", {"x", "y"}

    def flood(self):
        """More foreign frames than a wire of 1 Mbit/s carries."""
        with subprocess.Popen(["cangen", "vcan0", "-I", "5A0", "-g", "0.1", "-i"]) as flood:
            self.wait(self.random.uniform(0.2, 1.0))
            flood.terminate()
        self.count["floods"] += 1
        return "flood", set()

    def reload(self):
        """By the watch of the file, and by SIGHUP or the socket as well."""
        self.gain = 1 - self.gain
        self.bench.write(self.bench.text.replace("= 409.0", ("= 409.0", "= 380.0")[self.gain]))
        how = self.random.choice(("SIGHUP", "socket", "watch"))
        if how == "SIGHUP":
            self.bench.controller.process.send_signal(signal.SIGHUP)
        elif how == "socket" and not (answer := self.bench.ctl.ask("reload"))["ok"]:
            sys.exit(f"soak: reload: {answer['error']}")
        self.count["reloads"] += 1
        return f"reload ({how})", set()

    def disturb(self):
        which, = self.random.choices((self.twin_fault, self.link_flap, self.flood, self.reload), (12, 2, 1, 1))
        name, may_fault = which()
        self.wait(0.5)  # the slowest judgement that these faults reach takes 0.3 s
        for axis, cause in self.bench.faulted().items():
            self.count["faulted_axes"] += 1
            if axis not in may_fault:
                self.find(axis, cause, f"after {name}")
        self.bring_back(name)

    def bring_back(self, name):
        """Clears and enables until all axes track."""
        for _ in range(3):
            for axis in self.bench.faulted():
                self.bench.ctl.ask("clear", axis=axis)
            for axis, status in self.bench.axes().items():
                if status["state"] == "offline":
                    self.bench.ctl.ask("enable", axis=axis)
            for _ in range(100):
                axes = self.bench.axes()
                if all(axis["state"] == "tracking" for axis in axes.values()):
                    return
                if self.bench.faulted() or any(axis["state"] == "offline" for axis in axes.values()):
                    break
                self.wait(0.1)
        self.count["not_returned"] += 1
        print(f"{self.now_s():8.1f} s: not back after {name}: {json.dumps(self.bench.axes())}", flush=True)

    def rest(self):
        self.wait(self.random.uniform(0.3, 2.0))
        for axis, cause in self.bench.faulted().items():
            self.find(axis, cause, "at rest")
            self.bring_back("a fault at rest")

    def find(self, axis, cause, when):
        """With what the controller has said: the guest's files go with the guest."""
        self.count["unexplained"] += 1
        print(f"{self.now_s():8.1f} s: unexplained: {axis}: {cause} {when}", flush=True)
        print("\n".join(read(self.bench.controller.log).split("\n")[-20:]), flush=True)

    def idle_percent(self):
        """Of the processor since the last call."""
        before, self.ticks = self.ticks, [int(word) for word in read("/proc/stat").split("\n")[0].split()[1:8]]
        spent = [now - then for now, then in zip(self.ticks, before)]
        return 100.0 * spent[3] / sum(spent)

    def say(self):
        """The result so far: a line to read, and its JSON for a run that is cut off."""
        result = self.result()
        parts = [f"{result['minutes']:5.1f} min", f"{result['cycles']} cycles, {result['missed_cycles']} missed"]
        parts += [f"{name} {figures['kB']} kB, {figures['descriptors_after']} descriptors"
                  for name, figures in result["programs"].items()]
        parts += [f"{value} {name}" for name, value in self.count.items()]
        print(", ".join([*parts, f"{result['rows_lost']} rows lost", f"{self.idle_percent():.0f} % idle"]), flush=True)
        print(json.dumps({"soak": result}), flush=True)
        return result

    def result(self):
        now_s, status = self.now_s(), self.bench.ctl.ask("status")
        return {"seed": self.seed, "minutes": round(now_s / 60.0, 1), **self.count, "cycles": status["cycles"],
                "missed_cycles": status["missed_cycles"], "rows_lost": status["recording"]["rows_lost"],
                "programs": {program.name: {
                    "kB_per_h": round(program.growth_kB_per_h(WARM_UP_S)) if now_s > JUDGED_S else None,
                    "kB": program.status("VmRSS"),
                    "descriptors_before": self.descriptors[program.name], "descriptors_after": program.descriptors(),
                    "threads_before": self.threads[program.name], "threads_after": program.status("Threads")}
                    for program in self.bench.programs}}

    def run(self, minutes):
        # What is opened once is open by now: the list of changes of the run, and the page has cut off who never reads.
        while self.now_s() < SETTLED_S or not self.count["reloads"]:
            self.disturb()
            self.rest()
        self.descriptors = {program.name: program.descriptors() for program in self.bench.programs}
        self.threads = {program.name: program.status("Threads") for program in self.bench.programs}
        next_line_s = 60.0
        while self.now_s() < 60.0 * minutes:
            self.disturb()
            self.rest()
            if next_line_s <= self.now_s() < 60.0 * minutes:
                self.say()
                next_line_s += 60.0
        return self.say()


def complaints(result):
    wrong = [f"{result[key]} {key}" for key in ("unexplained", "not_returned", "rows_lost") if result[key]]
    for name, program in result["programs"].items():
        for what in ("descriptors", "threads"):
            before, after = program[f"{what}_before"], program[f"{what}_after"]
            if after > before:
                wrong.append(f"{name}: {after} {what}, {before} at the begin")
        if program["kB_per_h"] is not None and program["kB_per_h"] > GROWTH_KB_PER_H:
            wrong.append(f"{name}: grows by {program['kB_per_h']} kB/h")
    return wrong


def main(hystcan, config, minutes, seed):
    bench = Bench(hystcan, config, os.path.dirname(os.path.abspath(__file__)))
    result = Soak(bench, int(seed)).run(float(minutes))
    wrong = complaints(result)
    bench.browser.process.send_signal(signal.SIGTERM)
    bench.page.process.send_signal(signal.SIGTERM)
    bench.ctl.ask("stop")  # the twin stays until the controller has ramped down
    for program in (bench.browser, bench.page, bench.controller, bench.twin):
        if program is bench.twin:
            bench.faults.ask("stop")
        if program.process.wait(30) != 0:
            wrong.append(f"{program.name}: exit status {program.process.returncode}\n{read(program.log)}")
    if not json.loads(read("browser.out"))[0]["rows"]:
        wrong.append("the page's client has received nothing")
    for complaint in wrong:
        print(f"soak: {complaint}", flush=True)
    return 1 if wrong else 0


sys.exit(main(*sys.argv[1:]))
