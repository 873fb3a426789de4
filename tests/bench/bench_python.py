"""Python's simulate beside the model in C++, and a Rehearsal beside the rehearsals of `hystcan demo`.

    build/release/bench_python
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import hystcan
import numpy

BUILD = pathlib.Path(sys.argv[1]).resolve()
SHORT = "HYSTCAN_BENCH_SHORT" in os.environ  # as in tests/bench/short_run.h
ALLOWANCE = 2.0  # of a ratio of two times, as in tests/bench/budgets.h
ROWS = 1_000_000 if SHORT else 10_000_000  # as in bench_simulate


def best_s(work, repetitions=3 if SHORT else 5):
    """Return the processor time, also of programs that the work runs: other programs disturb it little."""
    times = []
    for _ in range(repetitions):
        begin = sum(os.times()[:4])
        work()
        times.append(sum(os.times()[:4]) - begin)
    return min(times)


def report(what, ours_s, baseline, theirs_s, budget):
    """Print the ratio beside its budget; return whether it is within the allowance."""
    ratio = ours_s / theirs_s
    verdict = "met" if ratio <= budget else "missed" if ratio <= ALLOWANCE * budget else "FAILED"
    print(f"{what} {ours_s:.3f} s, {baseline} {theirs_s:.3f} s, ratio {ratio:.2f}, budget {budget} {verdict}")
    if "HYSTCAN_BENCH_FIGURES" in os.environ:
        with open(os.environ["HYSTCAN_BENCH_FIGURES"], "a", encoding="utf-8") as rows:
            rows.write(f'bench_python,"{what} / {baseline}",{ratio:.3g},{budget:g},{verdict}\n')
    return verdict != "FAILED"


def run(program, *arguments, **options):
    """Return what the program prints. Exit with its messages if it fails."""
    done = subprocess.run([BUILD / program, *arguments], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{program} {' '.join(arguments)}: failed with {done.returncode}\n{done.stderr}")
    return done.stdout


def alone_s():
    """bench_simulate --model: the same inputs, into a new array."""
    return float(re.search(r"model alone +([\d.]+) s", run("bench_simulate", "--model"))[1])


model = hystcan.Model.load(hystcan.shipped("piezo.model.toml"))
t = 1e-4 * numpy.arange(ROWS)
u = 50 + 35 * numpy.sin(8.2 * t) * numpy.exp(-t / 2000) + 3 * numpy.sin(44.6 * t)
good = report("simulate in Python", best_s(lambda: model.simulate(u)), "in C++", alone_s(), 1.1)

with tempfile.TemporaryDirectory() as scratch:
    stage = hystcan.shipped("piezo.toml")
    demo_s = best_s(lambda: run("hystcan", "demo", "--output", scratch, env={"PATH": "/nonexistent"}))
    structures = len(list(pathlib.Path(scratch).glob("*.truth.csv")))
good &= report("Rehearsal in Python", best_s(lambda: hystcan.Rehearsal(stage).run()), "one of the demo's",
               demo_s / structures, 1.2)
sys.exit(0 if good else 1)
