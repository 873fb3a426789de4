#!/usr/bin/python3
"""Reads a candump log by protocol.md and its pages alone, without hystcan's code, and prints what it finds as JSON."""
import json
import re
import struct
import sys
from collections import Counter

AXES = {"X": (1, 2), "Y": (3, 4)}
STATES = ["offline", "waiting", "initialising", "ready", "tracking", "faulted"]


def shifted_by_eight(crc):
    for _ in range(8):
        crc = (crc << 1 ^ 0x1D if crc & 0x80 else crc << 1) & 0xFF
    return crc


AFTER_A_BYTE = [shifted_by_eight(crc) for crc in range(256)]


def crc8_j1850(data):
    crc = 0xFF
    for byte in data:
        crc = AFTER_A_BYTE[crc ^ byte]
    return crc ^ 0xFF


def frames(log):
    """Yields (time in s, identifier, whether it is a classical data frame with a standard identifier, payload)."""
    for line in open(log):
        time, identifier, rest = re.fullmatch(r"\((\S+)\) \S+ ([0-9A-F]+)#(\S*)\n", line).groups()
        classical = len(identifier) == 3 and not rest.startswith(("#", "R"))
        yield float(time), int(identifier, 16), classical, bytes.fromhex(rest) if classical else b""


def main(log):
    names = {0x000: "Nmt", 0x080: "Sync", 0x77F: "ControllerHeartbeat"}
    for axis, (amplifier, sensor) in AXES.items():
        names |= {0x080 + amplifier: axis + "AmpEmcy", 0x080 + sensor: axis + "SensorEmcy",
                  0x180 + amplifier: axis + "AmpStatus", 0x180 + sensor: axis + "SensorSample",
                  0x200 + amplifier: axis + "AmpCommand", 0x280 + amplifier: axis + "ControllerStatus",
                  0x300 + amplifier: axis + "Setpoint",
                  0x700 + amplifier: axis + "AmpHeartbeat", 0x700 + sensor: axis + "SensorHeartbeat"}
    lengths = {"Nmt": 2, "Sync": 1}
    seen, wrong, last_counter, statuses, commands = Counter(), Counter(), {}, [], []
    reported = {axis: [] for axis in AXES}
    for time_s, identifier, classical, data in frames(log):
        name = names.get(identifier)
        if name is None or not classical:
            wrong["unknown frame"] += 1
            continue
        seen[name] += 1
        length = lengths.get(name, 1 if name.endswith("Heartbeat") else 8)
        if len(data) != length:
            wrong["length"] += 1
            continue
        if not name.endswith(("AmpStatus", "SensorSample", "AmpCommand", "ControllerStatus", "Setpoint")):
            continue
        value, byte4, byte5, byte6, crc = struct.unpack("<iBBBB", data)
        counter = byte6 & 0x0F if name.endswith("ControllerStatus") else byte6
        if crc != crc8_j1850(struct.pack("<H", identifier) + data[:7]):
            wrong["crc"] += 1
        if name in last_counter and counter != (last_counter[name] + 1) % 16:
            wrong["counter"] += 1
        last_counter[name] = counter
        if name.endswith("ControllerStatus"):
            if byte4 >= len(STATES) or byte6 & 0x80:
                wrong["axis status"] += 1
                continue
            reported[name[0]].append({"state": STATES[byte4], "cause": byte5, "following_error": value * 1e-6,
                                  "limited": byte6 >> 5 & 1})
        if name == "XAmpStatus":
            statuses.append({"time_s": time_s, "output": value * 1e-6, "state": byte4, "fault": byte5})
        if name == "XAmpCommand":
            commands.append({"time_s": time_s, "setpoint": value * 1e-6, "enable": byte4 & 1})
    print(json.dumps({"seen": seen, "wrong": wrong, "last_command": commands[-1] if commands else None,
                      "drive_range": [f(c["setpoint"] for c in commands) for f in (min, max)] if commands else None,
                      "last_enabled_command": next((c for c in reversed(commands) if c["enable"]), None),
                      "axis_states": {axis: [now["state"] for last, now in zip([{"state": None}] + each, each)
                                             if now["state"] != last["state"]] for axis, each in reported.items()},
                      "last_axis_status": {axis: each[-1] if each else None for axis, each in reported.items()},
                      "last_status": statuses[-1] if statuses else None,
                      "first_fault": next((s for s in statuses if s["state"] == 3), None)}))


main(sys.argv[1])
