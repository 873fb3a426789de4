#!/usr/bin/python3
"""The controller and the oracle (oracle.py) agree about each frame of random runs.

oracle_test.py ORACLE_FRAMES [--seeds 1-4] [--seconds 60] [--csv FILE]   runs; exit status 1 if they disagree
oracle_test.py ORACLE_FRAMES --planted                                 wrong frames are planted in a log: all are found
"""
import argparse
import collections
import csv
import json
import multiprocessing
import pathlib
import subprocess
import sys
import tempfile

import numpy

import oracle


def run_of(program, seed, seconds):
    with tempfile.TemporaryDirectory(prefix="oracle-") as folder:
        file = pathlib.Path(folder) / "frames"
        subprocess.run([program, str(seed), str(seconds), file], check=True)
        return numpy.fromfile(file, oracle.FRAME), json.loads((pathlib.Path(folder) / "frames.json").read_text())


def agreement(task):
    program, seed, seconds = task
    frames, facts = run_of(program, seed, seconds)
    found, faults = oracle.judge(frames, facts)
    rejected = sum(map(sum, facts["rejected"].values()))
    return seed, facts["cycles"], len(frames), faults, rejected, found


def sealed(frame):
    one = frame.reshape(1)
    one["data"][0, 7] = oracle.crc(one)[0]


def planted(program):
    """Each of these frames has a single error."""
    frames, facts = run_of(program, 2, 20)
    commands = numpy.flatnonzero(frames["id"] == oracle.COMMAND)
    enabled = [at for at in commands if frames["data"][at, 4] & 1][1000:]
    place = enabled[0]
    drive = oracle.value_of(frames[place:place + 1])[0]

    def with_drive(log, at, value):
        log["data"][at, :4] = numpy.array([round(value / oracle.LSB)], "<i4").view("u1")
        sealed(log[at:at + 1])

    def with_byte(log, at, byte, value, seal=True):
        log["data"][at, byte] = value
        if seal:
            sealed(log[at:at + 1])

    first = next(at for at in commands if frames["data"][at, 4] & 1)
    sample = next(at for at in range(place, len(frames)) if frames["id"][at] == oracle.SAMPLE)
    sync = next(at for at in range(place, len(frames)) if frames["id"][at] == oracle.SYNC)
    slew = facts["slew_per_s"] / facts["rate_Hz"]
    wrong = {
        "drive out of range": lambda log: with_drive(log, place, facts["drive_max"] + 1e-3),
        "slew": lambda log: with_drive(log, place, drive + 2.5 * slew * (1 if drive < 50 else -1)),
        "command CRC": lambda log: with_byte(log, place, 7, frames["data"][place, 7] ^ 1, seal=False),
        "command counter": lambda log: with_byte(log, place, 6, (frames["data"][place, 6] - 1) % 16),
        "command reserved bits": lambda log: with_byte(log, place, 6, frames["data"][place, 6] | 0x10),
        "Enable and ClearFault": lambda log: with_byte(log, place, 4, 3),
        "command without SYNC": lambda log: with_byte(log, place, 5, frames["data"][place, 5] % 240 + 1),
        "not the safe drive": lambda log: with_byte(log, place, 4, 0),
        "enabled beside the output": lambda log: with_drive(log, first, 5.0),
        "enabled, amplifier not ready": lambda log: [with_byte(log, at, 4, 0) for at in range(first)
                                                     if log["id"][at] == oracle.STATUS],
        "enabled after a fault": lambda log: with_byte(log, sample, 5, 1),
        "SYNC counter": lambda log: with_byte(log, sync, 0, 77, seal=False),
    }
    missed = []
    for rule, plant in wrong.items():
        log = frames.copy()
        plant(log)
        rules = {found[0] for found in oracle.judge(log, facts)[0]}
        print(f"{rule}: {', '.join(sorted(rules)) or 'nothing found'}")
        if rule not in rules:
            missed.append(rule)
    log = numpy.delete(frames, place)
    log = numpy.insert(log, place, [frames[place], frames[place]])
    if "two commands of a SYNC" not in {found[0] for found in oracle.judge(log, facts)[0]}:
        missed.append("two commands of a SYNC")
    if oracle.judge(frames, facts)[0]:
        missed.append("the log without a planted frame is not clean")
    log, facts = run_of(program, 1, 5)
    samples = numpy.flatnonzero(oracle.accepted(log, oracle.SAMPLE)[0])
    log["data"][samples[1000], 0] ^= 1  # the controller has accepted it
    if not {"XSensorSample: rejected", "samples accepted"} <= {found[0] for found in oracle.judge(log, facts)[0]}:
        missed.append("a sample that the controller should have rejected")
    if missed:
        print(f"missed: {missed}", file=sys.stderr)
    return 1 if missed else 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seeds", default="1-4")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--csv")
    parser.add_argument("--planted", action="store_true")
    options = parser.parse_args()
    if options.planted:
        return planted(options.program)
    first, _, last = options.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    disagreements, kinds, sums = 0, collections.Counter(), numpy.zeros(4, int)
    with multiprocessing.Pool(2) as pool:
        for seed, *counts, found in pool.imap(agreement, [(options.program, seed, options.seconds) for seed in seeds]):
            sums += counts
            disagreements += len(found)
            kinds.update(rule for rule, _, _ in found)
            for rule, time_s, what in found[:5]:
                print(f"seed {seed}, {time_s:.6f} s: {rule} {what}", file=sys.stderr)
    cycles, frames, faults, rejected = map(int, sums)
    print(f"{len(seeds)} seeds, {cycles} cycles, {frames} frames, {faults} faults followed, {rejected} damaged frames rejected, "
          f"{disagreements} disagreements {dict(kinds) or ''}")
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["seeds", "cycles", "frames", "faults", "rejected frames", "disagreements"])
            writer.writerow([options.seeds, cycles, frames, faults, rejected, disagreements])
    return 1 if disagreements or not frames else 0


if __name__ == "__main__":
    sys.exit(main())
