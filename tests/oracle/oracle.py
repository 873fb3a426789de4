"""The allowed output of a controller, and the frames that it accepts: a second implementation.

It was written only from docs/safety.md, docs/protocol/*.md and docs/configuration/*.md; never change it after a look at
the sources of the controller. If the two disagree, the documents decide.

judge(frames, facts) receives the frames of one axis (amplifier node 1, sensor node 2) as an array of FRAME in the order of
the wire, and the settings; it returns the violations, each as (rule, time in s, what). accepted(frames, ...) predicts
the frames of a message that a receiver accepts, and its reasons to reject the others.
"""
import numpy

FRAME = numpy.dtype([("time_ns", "<i8"), ("id", "<u4"), ("kind", "u1"), ("length", "u1"), ("unused", "V2"), ("data", "u1", 8)])
DATA, REMOTE, FD, EXTENDED, REMARK = 0, 1, 2, 16, 128
CLEAR, FOREIGN_SYNC, BUS_IS_GONE = 1, 2, 3  # remarks of the program that wrote the log
NMT, SYNC, SENSOR_EMCY, AMP_EMCY = 0x000, 0x080, 0x082, 0x081
SAMPLE, STATUS, COMMAND, AXIS_STATUS = 0x182, 0x181, 0x201, 0x281
HEARTBEATS = {"amplifier": 0x701, "sensor": 0x702, "controller": 0x77F}
LSB = 1e-6  # of setpoint, position and output (frames.md)
FRAME_S = 0.135e-3  # eight bytes with all stuff bits at 1 Mbit/s: the longest wait of a SYNC for the wire
FAULTED, OPERATIONAL = 5, 0x05


def crc_table():
    table = numpy.arange(256, dtype=numpy.uint8)
    for _ in range(8):
        table = (table << 1) ^ numpy.where(table & 0x80, 0x1D, 0).astype(numpy.uint8)
    return table


TABLE = crc_table()


def crc(frames):
    """CRC-8/SAE-J1850 over the identifier, low byte first, and the first seven bytes."""
    value = TABLE[0xFF ^ (frames["id"] & 0xFF).astype(numpy.uint8)]
    value = TABLE[value ^ (frames["id"] >> 8).astype(numpy.uint8)]
    for byte in range(7):
        value = TABLE[value ^ frames["data"][:, byte]]
    return value ^ 0xFF


def value_of(frames):
    return frames["data"][:, :4].copy().view("<i4")[:, 0] * LSB


def counter_of(frames):
    return frames["data"][:, 6] & 0x0F


def accepted(frames, identifier, restarts=()):
    """(mask over frames, rejections by cause) of a message: the checks of frames.md in order."""
    index = numpy.flatnonzero((frames["id"] == identifier) & (frames["kind"] != REMARK))
    these, counts = frames[index], []
    left = numpy.ones(len(these), bool)
    for is_bad in [these["kind"] & 3 != DATA, these["kind"] & EXTENDED != 0, these["length"] != 8,
                   crc(these) != these["data"][:, 7]]:
        counts.append(int((left & is_bad).sum()))
        left &= ~is_bad
    index, these = index[left], these[left]
    # The previous frame with the same counter was accepted, or repeats an accepted one.
    repeats = numpy.zeros(len(these), bool)
    repeats[1:] = counter_of(these)[1:] == counter_of(these)[:-1]
    repeats[numpy.searchsorted(index, [at for at in restarts if len(index) and at < index[-1]])] = False
    mask = numpy.zeros(len(frames), bool)
    mask[index[~repeats]] = True
    return mask, counts + [int(repeats.sum())]


def boot_ups(frames, node):
    return numpy.flatnonzero((frames["id"] == HEARTBEATS[node]) & (frames["kind"] == DATA) & (frames["length"] == 1)
                             & (frames["data"][:, 0] == 0))


def before(index, places):
    """Returns for each place the number of the last element of `index` before it; -1: none."""
    return numpy.searchsorted(index, places) - 1


class Judge:
    def __init__(self, frames, facts):
        self.frames, self.facts, self.found = frames, facts, []
        self.time_s = frames["time_ns"] * 1e-9
        remark = frames["kind"] == REMARK
        self.remarks = {what: numpy.flatnonzero(remark & (frames["id"] == what)) for what in (CLEAR, FOREIGN_SYNC, BUS_IS_GONE)}
        self.range = facts["drive_max"] - facts["drive_min"]
        self.intact = {name: accepted(frames, name, boot_ups(frames, node))
                       for name, node in [(SAMPLE, "sensor"), (STATUS, "amplifier")]}
        self.statuses, self.samples = (numpy.flatnonzero(self.intact[name][0]) for name in (STATUS, SAMPLE))
        self.commands = self.data_frames(COMMAND)
        self.enable = self.byte(self.commands, 4) & 1 == 1
        self.drive = value_of(frames[self.commands])

    def data_frames(self, identifier, length=8):
        frames = self.frames
        return numpy.flatnonzero((frames["id"] == identifier) & (frames["kind"] == DATA) & (frames["length"] == length))

    def byte(self, index, which):
        return self.frames["data"][index, which]

    def note(self, rule, index, is_wrong, values=None):
        for k in numpy.flatnonzero(is_wrong):
            self.found.append((rule, float(self.time_s[index[k]]), "" if values is None else float(values[k])))

    def near(self, places, remark, within_s=5.0):
        """Returns whether the remark occurs in the seconds before each place."""
        marks = self.remarks[remark]
        last = before(marks, places)
        return (last >= 0) & (self.time_s[places] - self.time_s[marks[last.clip(0)]] < within_s) if len(marks) else last >= 0

    def syncs_count(self):
        """SYNCs count from 1 to 240 without a gap, at least half a cycle apart, less the frame on the wire."""
        syncs = self.data_frames(SYNC, 1)
        for mark in self.remarks[FOREIGN_SYNC]:  # for another node: the next one out of turn
            after = syncs[syncs > mark][:4]
            last = syncs[syncs < mark][-1]
            for sync in after:
                if self.byte(sync, 0) != self.byte(last, 0) % 240 + 1:
                    syncs = syncs[syncs != sync]
                    break
                last = sync
        counter = self.byte(syncs, 0).astype(int)
        gone = self.near(syncs, BUS_IS_GONE)[1:]
        self.note("SYNC counter", syncs[1:], (counter[1:] != counter[:-1] % 240 + 1) & ~gone)
        shortest_s = 0.5 / self.facts["rate_Hz"] - 2 * FRAME_S
        self.note("SYNC too early", syncs[1:], (numpy.diff(self.time_s[syncs]) < shortest_s) & ~gone)
        self.syncs = syncs
        return counter

    def commands_are_intact(self):
        these = self.frames[self.commands]
        gone = self.near(self.commands, BUS_IS_GONE)
        self.note("command CRC", self.commands, crc(these) != these["data"][:, 7])
        self.note("command reserved bits", self.commands, (these["data"][:, 4] & 0xFC) | (these["data"][:, 6] & 0xF0))
        counter = counter_of(these)
        self.note("command counter", self.commands[1:], (counter[1:] != (counter[:-1] + 1) % 16) & ~gone[1:])
        self.note("command counter does not begin at 0", self.commands[:1], counter[:1])
        self.note("Enable and ClearFault", self.commands, these["data"][:, 4] & 3 == 3)

    def commands_answer_a_sync(self):
        """Each command names the last SYNC, and no SYNC has two commands."""
        counter = self.syncs_count()
        named = before(self.syncs, self.commands)
        gone = self.near(self.commands, BUS_IS_GONE) | self.near(self.commands, FOREIGN_SYNC)
        self.note("command without SYNC", self.commands,
                  ((named < 0) | (counter[named.clip(0)] != self.byte(self.commands, 5))) & ~gone)
        self.note("two commands of a SYNC", self.commands[1:], (numpy.diff(named) == 0) & ~gone[1:])
        self.named = named

    def drives_are_in_limits(self):
        facts, drive, enable = self.facts, self.drive, self.enable
        outside = (drive < facts["drive_min"] - LSB) | (drive > facts["drive_max"] + LSB)
        self.note("drive out of range", self.commands, enable & outside, drive)
        self.note("not the safe drive", self.commands, ~enable & (abs(drive - facts["safe_drive"]) > LSB), drive)
        time_s = self.time_s[self.syncs[self.named.clip(0)]]
        most = facts["slew_per_s"] * (numpy.diff(time_s) + 2 * FRAME_S) + 2 * LSB
        self.note("slew", self.commands[1:], enable[1:] & enable[:-1] & (abs(numpy.diff(drive)) > most), numpy.diff(drive))

    def enable_is_allowed(self):
        """Both nodes are operational, the amplifier is ready or enabled, two outputs agree; the drive begins there."""
        rising = self.commands[1:][self.enable[1:] & ~self.enable[:-1]]
        drive = self.drive[1:][self.enable[1:] & ~self.enable[:-1]]
        self.note("enabled from the first command on", self.commands[:1], self.enable[:1])
        for node in ("amplifier", "sensor"):
            beats = self.data_frames(HEARTBEATS[node], 1)
            last = before(beats, rising)
            self.note(f"enabled, {node} not operational", rising,
                      (last < 0) | (self.byte(beats[last.clip(0)], 0) != OPERATIONAL)
                      | (self.time_s[rising] - self.time_s[beats[last.clip(0)]] > 0.301))
        last = before(self.statuses, rising)
        output = value_of(self.frames[self.statuses])
        self.note("enabled, amplifier not ready", rising,
                  (last < 1) | ~numpy.isin(self.byte(self.statuses[last.clip(0)], 4), (1, 2)))
        margin = 0.01 * self.range + LSB
        self.note("enabled, output not at rest", rising, abs(output[last] - output[last - 1]) > margin)
        self.note("enabled beside the output", rising, abs(drive - output[last]) > margin, drive)

    def faults(self):
        """Returns the places of the documented faults of an enabled axis."""
        frames, facts = self.frames, self.facts
        position = value_of(frames[self.samples])
        counter = self.byte(self.syncs, 0)
        last = before(self.syncs, self.samples)
        in_time = (last >= 0) & (counter[last.clip(0)] == self.byte(self.samples, 5 - 1))
        status = self.byte(self.samples, 5)
        outside = (position < facts["position_min_um"]) | (position > facts["position_max_um"])
        places = [self.samples[in_time & ((status != 0) | outside)], self.statuses[self.byte(self.statuses, 4) == 3]]
        for emergency in (SENSOR_EMCY, AMP_EMCY):
            these = self.data_frames(emergency)
            places.append(these[self.byte(these, 1) != 0])  # the code's high byte
        places += [boot_ups(frames, "amplifier"), boot_ups(frames, "sensor")]
        reports = self.data_frames(AXIS_STATUS)
        places.append(reports[self.byte(reports, 4) == FAULTED])
        # The SYNC that ends the (n + 1)th consecutive cycle without a sample.
        n = facts["missing_samples"]
        has = numpy.zeros(len(self.syncs) + 1, bool)
        has[last[in_time]] = True
        run, missing = 0, []
        for k in range(len(self.syncs) - 1):
            run = 0 if has[k] else run + 1
            if run == n + 1:
                missing.append(self.syncs[k + 1])
        return numpy.sort(numpy.concatenate(places + [numpy.array(missing, int)]))

    def safe_after_a_fault(self):
        """At most two cycles after the fault, no command is enabled until a clear; a ramp moves to the safe drive."""
        if not len(self.commands):
            return 0
        faults = self.faults()
        last_command = before(self.commands, faults)
        counts = (last_command >= 0) & self.enable[last_command.clip(0)]
        faults = faults[counts]
        clears = self.remarks[CLEAR]
        safe_from = 0
        for fault in faults:
            if fault < safe_from:
                continue
            after = clears[clears > fault]
            end = after[0] if len(after) else len(self.frames)
            first = before(self.syncs, [fault])[0] + 3  # SYNCs after the fault that may still have an enabled command: two
            if first < len(self.syncs):
                which = numpy.flatnonzero((self.commands > self.syncs[first]) & (self.commands < end))
                wrong = self.enable[which]
                ramp = self.facts["fault_ramp_per_s"]
                if ramp and len(which) > 1:  # towards the safe drive, no faster than the ramp, and disabled at its end
                    drive = abs(self.drive[which] - self.facts["safe_drive"])
                    steps = numpy.diff(drive)
                    most = ramp * (numpy.diff(self.time_s[self.syncs[self.named[which]]]) + 2 * FRAME_S) + 2 * LSB
                    wrong = numpy.zeros(len(which), bool)
                    wrong[1:] = self.enable[which][1:] & ((steps > 2 * LSB) | (-steps > most) | ~self.enable[which][:-1])
                self.note("enabled after a fault", self.commands[which], wrong, self.drive[which])
            safe_from = end
        return len(faults)

    def axis_status_is_sound(self):
        reports = self.data_frames(AXIS_STATUS)
        these = self.frames[reports]
        counter = counter_of(these)
        gone = self.near(reports, BUS_IS_GONE)
        self.note("axis status CRC", reports, crc(these) != these["data"][:, 7])
        self.note("axis status counter", reports[1:], (counter[1:] != (counter[:-1] + 1) % 16) & ~gone[1:])
        state, cause = these["data"][:, 4], these["data"][:, 5]
        self.note("axis status", reports, (state > FAULTED) | ((state == FAULTED) != (cause != 0)))
        orders = self.data_frames(NMT, 2)
        self.note("NMT of another kind", orders, ~numpy.isin(self.byte(orders, 0), (1, 2, 128)))  # 2: of the tester


def judge(frames, facts):
    """Returns (violations, number of followed faults)."""
    it = Judge(frames, facts)
    it.commands_are_intact()
    it.commands_answer_a_sync()
    it.drives_are_in_limits()
    it.enable_is_allowed()
    it.axis_status_is_sound()
    faults = it.safe_after_a_fault()
    if facts["is_damaging"]:
        for message, name in [("XSensorSample", SAMPLE), ("XAmpStatus", STATUS)]:
            predicted, counted = it.intact[name][1], facts["rejected"][message]
            if predicted != counted:
                it.found.append((f"{message}: rejected", 0.0, f"predicted {predicted}, counted {counted}"))
        if len(it.samples) != facts["accepted_samples"]:
            it.found.append(("samples accepted", 0.0, f"predicted {len(it.samples)}, counted {facts['accepted_samples']}"))
    return it.found, faults
