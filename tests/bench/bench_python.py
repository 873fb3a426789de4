"""Python's simulate beside the model in C++, and a Rehearsal beside the rehearsals of `hystcan demo`.

    PYTHONPATH=build/release/python python3 tests/bench/bench_python.py build/release
"""
import pathlib
import subprocess
import sys
import tempfile
import time

import hystcan
import numpy

BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/release").resolve()
ROWS = 10_000_000


def best_s(work, repetitions=5):
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def report(what, ours_s, baseline, theirs_s, budget):
    ratio = ours_s / theirs_s
    print(f"{what} {ours_s:.3f} s, {baseline} {theirs_s:.3f} s, ratio {ratio:.2f}, budget {budget}"
          f" {'met' if ratio <= budget else 'missed'}")


def alone_s():
    """bench_simulate --model: the same inputs, into a new array."""
    done = subprocess.run([BUILD / "bench_simulate", "--model"], check=True, capture_output=True, text=True)
    return float(done.stdout.split()[2])


model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
t = 1e-4 * numpy.arange(ROWS)
u = 50 + 35 * numpy.sin(8.2 * t) * numpy.exp(-t / 2000) + 3 * numpy.sin(44.6 * t)
report("simulate in Python", best_s(lambda: model.simulate(u)), "in C++", alone_s(), 1.1)

with tempfile.TemporaryDirectory() as scratch:
    stage = hystcan.shipped("piezo.toml")
    demo_s = best_s(lambda: subprocess.run([BUILD / "hystcan", "demo", "--output", scratch], check=True,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                           env={"PATH": "/nonexistent"}))
    structures = len(list(pathlib.Path(scratch).glob("*.truth.csv")))
report("Rehearsal in Python", best_s(lambda: hystcan.Rehearsal(stage).run()), "one of the demo's",
       demo_s / structures, 1.2)
