#!/usr/bin/python3
"""No incomplete file remains if the disk is full, or the program is killed, at any call that writes it.

crash_test.py HYSTCAN WRITTEN_FILES CONFIG_FOLDER [--quick] [--only CASE] [--csv FILE]

Each command runs once under strace, which lists its calls on files of the working folder: open, write, fsync, rename,
close and so on. Then, for each call k, it runs again:

  failure   the call returns an error: EIO for a sync or a close, otherwise ENOSPC
  kill      SIGKILL arrives at the call, before the call is executed
  full      the size of a file is limited: the last write is cut, the next one fails (EFBIG)

Afterwards each file has its old or its new content, byte by byte; a growing file (a log) contains whole lines from its
start, or any part of them after a kill. A failure gives exit status 1 and a message with file and reason, and leaves no
further file; a running controller warns and drives as without it. After a kill the next command works.
"""
import argparse
import concurrent.futures
import csv
import fnmatch
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict

SKIPPED = 77
HANG_S = 300  # ends a single run of a program that hangs; a run under strace takes seconds
SCRATCH = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # syncs take no time there
SYNCS = {"fsync", "fdatasync", "close"}
BY_DESCRIPTOR = {"write", "writev", "pwrite64", "sendfile", "copy_file_range", "ftruncate", "fchmod"} | SYNCS
BY_PATH = {"openat", "rename", "renameat", "renameat2", "link", "linkat", "unlink", "unlinkat", "mkdir", "mkdirat", "rmdir",
           "chmod", "fchmodat"}
BETWEEN = ["part", "begun", "no run yet", "absent"]
WORDS = {"EIO": "Input/output error", "ENOSPC": "No space left on device|is the disk full",
         "EFBIG": "File too large|Input/output error|is the disk full"}  # if a copy is cut
WHOLE_SVG = rb"(?s)<\?xml.*</svg>\s*"
WHOLE_REPORT = WHOLE_SVG + rb"|(?s:<!.*</html>\n)"  # the page names the pictures that could not be drawn
TEMPORARY = re.compile(r"\.[A-Za-z0-9]{6}$")


class Case:
    """`grows`: patterns of growing files; `warns`: a live run, which continues; `again`: the command after a kill, by
    default the same; `left`: patterns of files that may be absent, or remain, after a failure; `form`: a regular expression for a
    whole file that differs between runs."""

    def __init__(self, name, command, *, before=(), grows=(), warns=False, again=None, left=(), form=b"", quick=True):
        self.name, self.command, self.before, self.grows = name, command, before, grows
        self.warns, self.again, self.left, self.form, self.quick = warns, again, left, form, quick

    def is_new(self, now, new):
        return now == new or bool(self.form and new is not None and now is not None and re.fullmatch(self.form, now))


def cases(hystcan, written_files):
    piezo = "piezo.toml"
    loops = [hystcan, "simulate", "piezo.plant.toml", "--input", "turns.csv", "--output", "loops.csv", "--quasi-static"]
    units = ["--input-unit", "V", "--output-unit", "um"]
    save = [written_files, "save", piezo, "axis[0].control.kp"]
    yield Case("page: save", [*save, "0.06"], again=[*save, "0.07"])
    yield Case("page: undo", [written_files, "undo", piezo], again=[*save, "0.07"],
               before=[[*save, "0.06"]])
    yield Case("page: token", [written_files, "token", "./page.token"], form=rb"[0-9a-f]{32}\n")
    yield Case("controller, a run", [written_files, "run", piezo], before=[[written_files, "run", piezo, "60"]], warns=True,
               grows=["runs/*/cycles_*.csv", "runs/*/changes.csv"], left=["?.state.toml"],
               again=[written_files, "run", piezo, "120"])
    yield Case("controller, a fault", [written_files, "fault", piezo], warns=True, grows=["boxes/*"],
               again=[written_files, "fault", piezo, "60"])
    rehearse = [hystcan, "controller", piezo, "--rehearse", "--duration", "1.5", "--csv"]
    yield Case("controller --rehearse --csv", [*rehearse, "c.csv"], grows=["c.csv"])
    yield Case("excite", [hystcan, "excite", piezo, "--rehearse", "--axis", "x", "--signal", "step", "--cycles", "2",
                          "--output", "step.csv", "--overwrite"])
    yield Case("simulate", [hystcan, "simulate", "piezo.model.toml", "--input", "drive.csv", "--output", "position.csv",
                            "--save-memory", "memory.toml", "--overwrite"],
               before=[[hystcan, "simulate", "piezo.model.toml", "--input", "former.csv", "--output", "position.csv",
                        "--save-memory", "memory.toml"]])
    yield Case("init --from", [hystcan, "init", "stage", "--from", "piezo"],
               again=[hystcan, "init", "stage", "--from", "piezo"])
    yield Case("init", [hystcan, "init", "stage", "--yes", "--stroke", "30", "--drive-min", "0", "--drive-max", "100",
                        "--resonance", "500"])
    yield Case("export", [hystcan, "export", "cycles.csv", "--axis", "x", "--output", "signals.csv"],
               before=[[*rehearse, "cycles.csv"]])
    yield Case("export --hdf5", [hystcan, "export", "cycles.csv", "--output", "signals.h5"],
               before=[[*rehearse, "cycles.csv"]], left=["signals.h5"], quick=False)
    yield Case("simulate, HDF5", [hystcan, "simulate", "piezo.model.toml", "--input", "drive.csv", "--output", "position.h5"],
               left=["position.h5"])
    identify = [hystcan, "identify", "loops.csv", "--output", "new.model.toml", "--initial-memory", "memory.toml",
                "--order", "3", "--overwrite", *units, "--for", piezo, "--axis", "x", "--write"]
    yield Case("identify", [*identify, "identified.toml"], again=[*identify, "again.toml"], before=[loops], quick=False)
    yield Case("identify --report", [hystcan, "identify", "loops.csv", "--output", "new.model.toml", "--order", "3",
                                     "--report", "report", "--overwrite", *units], left=["report/*"], form=WHOLE_REPORT,
               before=[loops], quick=False)
    yield Case("validate --output", [hystcan, "validate", "piezo.model.toml", "loops.csv", "--output", "predicted.csv"],
               before=[loops], quick=False)
    yield Case("tune", [hystcan, "tune", piezo, "--axis", "x", "--rehearse", "--output", "tuning.toml", "--write", "tuned.toml",
                        "--response", "response.csv"], quick=False)
    yield Case("plot", [hystcan, "plot", "cycles.csv", "--axis", "x", "--kind", "tracking", "--format", "svg",
                        "--output", "plots"],
               before=[[*rehearse, "cycles.csv"]],
               left=["plots/*.svg"], form=WHOLE_SVG, quick=False)
    yield Case("demo", [hystcan, "demo", "--config", "short.toml", "--output", "demo"], grows=["demo/*.csv"], left=["demo/*"],
               form=WHOLE_SVG, quick=False)


def prepare(folder, config):
    """A stage with a place for each file that a controller writes."""
    for file in ["piezo.toml", "piezo.model.toml", "piezo.plant.toml", "hystcan.dbc"]:
        shutil.copy(config / file, folder)
    text = (folder / "piezo.toml").read_text()
    rate = "rate_Hz = 1000.0\n"
    assert rate in text
    text = text.replace(rate, rate + 'state_dir = "."\nblack_box_dir = "boxes"\n') + '\n[record]\ndir = "runs"\npart_MB = 1\n'
    (folder / "piezo.toml").write_text(text)
    long_triangle = "frequency_Hz = 10.0\ncycles       = 10.0"
    assert long_triangle in text
    (folder / "short.toml").write_text(text.replace(long_triangle, "frequency_Hz = 20.0\ncycles = 1.0"))
    (folder / "boxes").mkdir()
    turns = [drive for low, high in [(0, 100), (0, 100), (20, 80), (30, 60), (0, 50)]
             for drive in [*range(low, high), *range(high, low, -1)]]
    for name, drives in [("former.csv", turns[:20]), ("turns.csv", turns[::4]), ("drive.csv", 4 * turns)]:
        (folder / name).write_text("time_s,input\n" + "".join(f"{i / 100},{drive}\n" for i, drive in enumerate(drives)))


def content_of(path):
    """Returns the content of an HDF5 file: its bytes contain the times of its objects."""
    if path.suffix != ".h5":
        return path.read_bytes()
    import h5py  # pylint: disable=import-outside-toplevel
    parts = []

    def add(name, item):
        value = item[()].tobytes() if isinstance(item, h5py.Dataset) and item.dtype.kind != "O" else b""
        parts.append(b"%s %r %s" % (name.encode(), sorted((key, str(text)) for key, text in item.attrs.items()), value))

    try:
        with h5py.File(path) as file:
            file.visititems(add)
    except Exception as error:  # exceptions of the library on a damaged file
        return b"damaged: " + str(error).encode()
    return b"\n".join(parts)


def contents(folder):
    return {str(path.relative_to(folder)): content_of(path) for path in sorted(folder.rglob("*"))
            if path.is_file() and not TEMPORARY.search(path.name)}


def temporaries(folder):
    return [str(path.relative_to(folder)) for path in sorted(folder.rglob("*")) if TEMPORARY.search(path.name)]


def is_json(content):
    try:
        return "hystcan_run" in json.loads(content)
    except ValueError:
        return False


class Call:
    def __init__(self, name, ordinal, path):
        self.name, self.ordinal, self.path = name, ordinal, path

    def error(self):
        return "EIO" if self.name in SYNCS else "ENOSPC"


def calls_in(log, folder):
    """Returns the calls on files of the folder, in order; each is the n-th of its name in its thread."""
    counts, written, calls = Counter(), set(), []
    for line in log.read_text(errors="replace").splitlines():
        match = re.match(r"(\d+) +(\w+)\((.*)", line)
        if not match or match[2] not in BY_DESCRIPTOR | BY_PATH:
            continue
        thread, name, rest = match.groups()
        counts[thread, name] += 1
        if name in BY_DESCRIPTOR:
            descriptor = re.match(r"\d+<([^>]*)>", rest)
            path = descriptor[1] if descriptor else ""
            counts_here = path in written or name in {"fsync", "fdatasync"}
        else:
            quoted = re.search(r'"([^"]*)"', rest)
            here = re.match(r"AT_FDCWD<([^>]*)>", rest)
            path = os.path.normpath(os.path.join(here[1] if here else folder, quoted[1])) if quoted else ""
            counts_here = name != "openat" or re.search(r"O_CREAT|O_WRONLY|O_RDWR|O_DIRECTORY", rest)
            if name == "openat" and re.search(r"O_CREAT|O_WRONLY|O_RDWR", rest):
                written.add(path)
        if counts_here and (path + "/").startswith(str(folder) + "/"):
            calls.append(Call(name, counts[thread, name], os.path.relpath(path, folder)))
    return calls


class Trial:
    """One run of a command in a separate folder, with one fault."""

    def __init__(self, test, inject=(), largest_file=None):
        self.scratch = tempfile.TemporaryDirectory(prefix="crash-", dir=SCRATCH)
        top = pathlib.Path(self.scratch.name).resolve()
        self.folder, self.log = top / "stage", top / "log"
        shutil.copytree(test.prepared, self.folder)
        words = [str(word) for word in test.case.command]
        if largest_file is None:
            traced = ",".join(sorted(BY_DESCRIPTOR | BY_PATH))
            words = ["strace", "-f", "-y", "-s", "200", "-o", self.log, "-e", f"trace={traced}", *inject] + words

        def limit():
            if largest_file is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

        # Python ignores SIGXFSZ, and so does the child: its write fails instead.
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, preexec_fn=limit, restore_signals=False,
                              errors="replace", stdin=subprocess.DEVNULL, timeout=HANG_S)
        self.status, self.out, self.err = done.returncode, done.stdout, done.stderr
        self.files, self.temporaries = contents(self.folder), temporaries(self.folder)

    def injected(self):
        if not self.log.exists():  # a file size limit is not injected
            return []
        return [line for line in self.log.read_text(errors="replace").splitlines() if "(INJECTED)" in line]


class Test:
    def __init__(self, case, config, top):
        self.case, self.prepared = case, top
        prepare(top, config)
        for words in case.before:
            subprocess.run([str(word) for word in words], cwd=top, check=True, capture_output=True)
        self.old = contents(top)
        whole, again = Trial(self), Trial(self)
        assert whole.status == 0, f"{case.name}: {whole.err}"
        self.new, self.out = whole.files, whole.out
        self.sizes = {name: (whole.folder / name).stat().st_size for name in self.new}
        for name in self.new:
            assert case.is_new(again.files.get(name), self.new[name]), f"{case.name}: {name} differs from run to run"
        self.calls = calls_in(whole.log, whole.folder)
        self.changed = sorted(name for name in self.old.keys() | self.new.keys() if self.old.get(name) != self.new.get(name))
        self.complaints = []
        self.seen = defaultdict(Counter)

    def complain(self, fault, what):
        self.complaints.append(f"{self.case.name}: {fault}: {what}")

    def has(self, name, patterns):
        return any(fnmatch.fnmatch(name, pattern) for pattern in patterns)

    def outcome(self, trial, name, killed):
        """Returns old, new, half, or one of BETWEEN, which a reader can distinguish from a whole file."""
        now, new = trial.files.get(name), self.new.get(name)
        if self.case.is_new(now, new):
            return "new"
        if now == self.old.get(name):
            return "old"
        if now is None and self.has(name, self.case.left):
            return "absent"
        if self.has(name, self.case.grows) and now is not None and new.startswith(now) and (killed or now[-1:] in (b"", b"\n")):
            return "part"
        run = name.startswith("runs/") and self.run_json_of(name)
        if run and killed and run not in trial.files:
            return "no run yet"
        if run == name and now is not None and is_json(now):
            return "begun"  # without an end time
        return "half"

    @staticmethod
    def run_json_of(name):
        return "/".join(name.split("/")[:2]) + "/run.json"

    def file_of(self, call, before):
        """Returns the file of a call: for a temporary file the final one, for a folder that of the previous call."""
        name = TEMPORARY.sub("", call.path)
        name = name if name in self.new else call.path
        return name if name in self.new or name in self.old else before

    def judge(self, trial, fault, file, killed):
        for name in sorted(self.old.keys() | self.new.keys()):
            outcome = self.outcome(trial, name, killed)
            if name == file:
                self.seen[file][outcome] += 1
            if outcome == "half":
                self.seen[file]["halves"] += 1
                self.complain(fault, f"{name} is half: {trial.files.get(name, b'')[-60:]!r}")
        return trial.temporaries + [name for name in trial.files if name not in self.old and name not in self.new]

    def judge_words(self, trial, fault, error, path):
        whole = all(self.case.is_new(trial.files.get(name), content) for name, content in self.new.items())
        if self.case.warns and trial.status == 0 and trial.out != self.out:
            self.complain(fault, f"the drive differs: {trial.out}")
        if trial.status == 0 and whole:
            return  # nothing depends on this call
        goes_on = self.case.warns or path.endswith((".svg", ".png"))  # a missing picture is not a failure
        if trial.status not in ([0, 1] if goes_on else [1]):
            self.complain(fault, f"exit status {trial.status}: {trial.err[-300:]}")
        name = TEMPORARY.sub("", os.path.basename(path))
        names = {os.path.basename(each) for each in self.changed} | {part for each in self.changed for part in each.split("/")}
        names |= {TEMPORARY.sub("", os.path.basename(each)) for line in trial.injected()  # in another thread
                  for each in re.findall(r'[<"]([^<>"]+)[>"]', line)}
        if not any(each in trial.err for each in names | {name}) or not re.search(WORDS[error], trial.err):
            self.complain(fault, f"no message with file and reason: {trial.err[-300:]!r}")

    @staticmethod
    def is_in(folder, line):
        name = re.match(r"\d+ +(?:<\.\.\. )?(\w+)", line)[1]  # "resumed" if another thread ran in between
        descriptor = re.search(r"\(\d+<([^>]*)>", line) if name in BY_DESCRIPTOR else None
        return str(folder) in (descriptor[1] if descriptor else line) or (name in BY_PATH and '("/' not in line)

    def failure(self, call, file):
        fault = f"{call.error()} at {call.name} #{call.ordinal} of {call.path}"
        trial = Trial(self, ["-e", f"inject={call.name}:error={call.error()}:when={call.ordinal}"])
        strays = self.judge(trial, fault, file, killed=False)
        elsewhere = [line for line in trial.injected() if not self.is_in(trial.folder, line)]
        if not elsewhere:  # each of several threads has an n-th call
            self.judge_words(trial, fault, call.error(), call.path)
        strays = [name for name in strays if not self.has(name, self.case.left) and not call.name.startswith("unlink")]
        if strays:
            self.complain(fault, f"left behind: {', '.join(strays)}")
        self.seen[file]["failures"] += 1

    def kill(self, call, file):
        fault = f"SIGKILL at {call.name} #{call.ordinal} of {call.path}"
        trial = Trial(self, ["-e", f"inject={call.name}:signal=KILL:when={call.ordinal}"])
        if trial.status != -signal.SIGKILL:
            if trial.status not in [0, 1] or not self.case.left:
                self.complain(fault, f"exit status {trial.status}: {trial.err[-300:]}")
            return  # the signal hit Python, which the command runs
        self.judge(trial, fault, file, killed=True)
        self.seen[file]["kills"] += 1
        again = subprocess.run([str(word) for word in self.case.again or self.case.command], cwd=trial.folder,
                               capture_output=True, text=True)
        after = contents(trial.folder)
        wrong = [name for name in self.changed
                 if not self.case.again and not self.case.is_new(after.get(name), self.new.get(name))]
        if again.returncode != 0 or wrong:
            self.complain(fault, f"the next one does not cope: status {again.returncode} {again.stderr[-300:]} {wrong}")

    def full(self, file, size):
        fault = f"no file above {size} bytes"
        trial = Trial(self, largest_file=size)
        strays = self.judge(trial, fault, file, killed=False)
        self.judge_words(trial, fault, "EFBIG", file)
        if [name for name in strays if not self.has(name, self.case.left)]:
            self.complain(fault, f"left behind: {', '.join(strays)}")
        self.seen[file]["failures"] += 1

    def tasks(self):
        file = self.changed[0]
        for call in self.calls:
            file = self.file_of(call, file)
            self.seen[file]["calls"] += 1
            self.seen[file][call.name] += 1
            yield self.failure, call, file
            yield self.kill, call, file
        for name in self.changed:
            size = self.sizes.get(name, 0)
            for limit in sorted({0, size // 2, size - 1}):
                if limit >= 0:
                    yield self.full, name, limit

    def print(self):
        kinds = BY_DESCRIPTOR | BY_PATH
        for file, seen in sorted(self.seen.items()):
            made = ", ".join(f"{count} {name}" for name, count in sorted(seen.items()) if name in kinds)
            ends = ", ".join(f"{seen[end]} {end}" for end in ["old", "new", *BETWEEN, "half"] if seen[end])
            print(f"{self.case.name}: {file}: {made}; {seen['kills']} kills, {seen['failures']} failures: {ends}")


def can_inject():
    """Returns None, or the reason why strace is unusable here."""
    if shutil.which("strace") is None:
        return "strace is not installed"
    words = ["strace", "-f", "-o", "/dev/null", "-e", "inject=chdir:error=EIO:when=1", "sh", "-c", "cd / || exit 9"]
    done = subprocess.run(words, capture_output=True, text=True)
    return None if done.returncode == 9 else f"strace cannot inject a failure here: {done.stderr.strip()}"


def main():
    parser = argparse.ArgumentParser()
    for name in ["hystcan", "written_files", "config"]:
        parser.add_argument(name, type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only")
    parser.add_argument("--csv")
    options = parser.parse_args()
    if reason := can_inject():
        print(f"skipped: {reason}")
        return SKIPPED
    rows, complaints = [], []
    for case in cases(options.hystcan, options.written_files):
        if (options.quick and not case.quick) or (options.only and options.only != case.name):
            continue
        with tempfile.TemporaryDirectory(prefix="crash-", dir=SCRATCH) as top, concurrent.futures.ThreadPoolExecutor(2) as pool:
            test = Test(case, options.config, pathlib.Path(top).resolve())
            for running in [pool.submit(task, *words) for task, *words in test.tasks()]:
                running.result()
            test.print()
        complaints += test.complaints
        rows += [[file, case.name, seen["calls"], seen["kills"], seen["failures"], seen["halves"]]
                 for file, seen in sorted(test.seen.items())]
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    print(f"{sum(row[2] for row in rows)} calls, {sum(row[3] for row in rows)} kills, {sum(row[4] for row in rows)} failures, "
          f"{sum(row[5] for row in rows)} halves, {len(complaints)} complaints")
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerows([["file", "written by", "calls", "kills", "failures", "halves"], *rows])
    return 1 if complaints or not rows else 0


sys.exit(main())
