"""Python's simulate beside the model in C++, and a Rehearsal beside the rehearsals of `hystcan demo`.

    build/release/bench_python
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import hystcan
import numpy

BUILD = pathlib.Path(sys.argv[1]).resolve()
SHORT = "HYSTCAN_BENCH_SHORT" in os.environ  # as in tests/bench/short_run.h
ROWS = 100_000 if SHORT else 10_000_000


def best_s(work, repetitions=1 if SHORT else 5):
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def report(what, ours_s, baseline, theirs_s, budget):
    ratio = ours_s / theirs_s
    verdict = "not judged" if SHORT else "met" if ratio <= budget else "missed"
    print(f"{what} {ours_s:.3f} s, {baseline} {theirs_s:.3f} s, ratio {ratio:.2f}, budget {budget}"
          f" {verdict}")


def run(program, *arguments, **options):
    """Return what the program prints. Exit with its messages if it fails."""
    done = subprocess.run([BUILD / program, *arguments], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{program} {' '.join(arguments)}: failed with {done.returncode}\n{done.stderr}")
    return done.stdout


def alone_s():
    """bench_simulate --model: the same inputs, into a new array."""
    return float(re.search(r"model alone +([\d.]+) s", run("bench_simulate", "--model"))[1])


if SHORT:
    print("short run: the figures are not judged")
model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
t = 1e-4 * numpy.arange(ROWS)
u = 50 + 35 * numpy.sin(8.2 * t) * numpy.exp(-t / 2000) + 3 * numpy.sin(44.6 * t)
report("simulate in Python", best_s(lambda: model.simulate(u)), "in C++", alone_s(), 1.1)

with tempfile.TemporaryDirectory() as scratch:
    stage = hystcan.shipped("piezo.toml")
    demo_s = best_s(lambda: run("hystcan", "demo", "--output", scratch, env={"PATH": "/nonexistent"}))
    structures = len(list(pathlib.Path(scratch).glob("*.truth.csv")))
report("Rehearsal in Python", best_s(lambda: hystcan.Rehearsal(stage).run()), "one of the demo's",
       demo_s / structures, 1.2)
