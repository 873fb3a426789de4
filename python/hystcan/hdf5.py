"""HDF5 files for the program, which runs this file in a process of its own; it needs h5py, not the package.

hdf5.py write FILE             makes FILE out of messages on standard input: a line of JSON, [kind, ...], then bytes
  ["table", GROUP, [[NAME, UNIT, WORDS], ...], DEFLATED]    datasets that grow; words make an enumeration
  ["rows", TABLE, COUNT]       then COUNT doubles for each column
  ["set", OBJECT, NAME, VALUE] an attribute
  ["text", PATH, SIZE]         then SIZE bytes: a text as a dataset
  ["end"]                      without it the file is incomplete
hdf5.py read FILE COLUMN ROWS  prints doubles: the number of values, 1 if there is time_s, the length of the unit; the
                               unit; then blocks of ROWS values, each followed by its times
"""
import json
import os
import re
import sys

try:
    import h5py  # type: ignore[import]
    import numpy
except ImportError:
    sys.exit("the Python module h5py is missing; install python3-h5py, or use CSV")

CHUNK_ROWS = 65536


class Writer:
    """Each message calls the method of its kind."""

    def __init__(self, path, stream):
        self.stream = stream
        # Without a cache each block is written at once, and the call that caused a failure gets it.
        self.file = h5py.File(path, "w", rdcc_nbytes=0)
        self.tables = []

    def table(self, group, columns, deflated):
        where = self.file.require_group(group)
        packing = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if deflated else {}
        datasets = []
        for name, unit, words in columns:
            kind = h5py.enum_dtype({word: i for i, word in enumerate(words)}, "u1") if words else "<f8"
            datasets.append(where.create_dataset(name, (0,), kind, maxshape=(None,), chunks=(CHUNK_ROWS,), **packing))
            if unit:
                datasets[-1].attrs["unit"] = unit
        self.tables.append(datasets)

    def rows(self, table, count):
        for dataset in self.tables[table]:
            values = numpy.frombuffer(self.stream.read(8 * count))
            if dataset.dtype.kind == "u":
                values = numpy.where((values >= 0) & (values <= 255), values, 255).astype(dataset.dtype)
            before = len(dataset)
            dataset.resize(before + count, axis=0)
            dataset[before:] = values

    def set(self, path, name, value):
        self.file[path].attrs[name] = numpy.nan if value is None else value

    def text(self, path, size):
        self.file.create_dataset(path, data=self.stream.read(size).partition(b"\0")[0], dtype=h5py.string_dtype())

    def end(self):
        self.file.flush()
        self.file.close()


def write(path):
    writer = Writer(path, sys.stdin.buffer)
    for line in writer.stream:
        kind, *values = json.loads(line)
        getattr(writer, kind)(*values)
        if kind == "end":
            return
    raise EOFError("the rows ended before the message \"end\"")


def numbers_of(file, name):
    if name not in file:
        raise KeyError(f"no dataset {name}")
    dataset = file[name]
    is_column = isinstance(dataset, h5py.Dataset) and dataset.ndim == 1
    if not is_column or dataset.dtype.kind not in "fiu" or h5py.check_enum_dtype(dataset.dtype):
        raise TypeError(f"{name} is not a column of numbers, expected a one-dimensional dataset of numbers")
    return dataset


def read(path, column, rows):
    file = h5py.File(path)
    datasets = [numbers_of(file, name) for name in (column, "time_s") if name == column or name in file]
    count = len(datasets[0])
    if len(datasets[-1]) != count:
        raise ValueError(f"time_s has {len(datasets[-1])} values and {column} has {count}, expected the same number")
    unit = str(datasets[0].attrs.get("unit", "")).encode()
    out = sys.stdout.buffer
    out.write(numpy.array([count, len(datasets) - 1, len(unit)], "f8").tobytes() + unit)
    slice_rows = max(1, CHUNK_ROWS // rows) * rows
    for begin in range(0, count, slice_rows):
        values = [dataset[begin:begin + slice_rows].astype("f8") for dataset in datasets]
        for row in range(0, len(values[0]), rows):
            for each in values:
                out.write(each[row:row + rows].tobytes())
    out.flush()


def reason_of(error):
    """Return the system's message if the error contains it: "No space left on device"."""
    system = re.search("error message = '([^']*)'", str(error))
    return system[1] if system else " ".join(str(error.args[0] if error.args else error).split())


def main(task, path, *rest):
    failure = ""
    try:
        if task == "write":
            write(path)
        else:
            read(path, rest[0], int(rest[1]))
    except (KeyError, TypeError, ValueError) as refused:
        failure = reason_of(refused)
    except Exception as error:  # pylint: disable=broad-except
        failure = "cannot be written: " if task == "write" else "cannot be read, expected an HDF5 file: "
        failure += reason_of(error)
    print(failure, file=sys.stderr, flush=True)
    os._exit(bool(failure))  # the library's own exit would write the data again that a full disk refused


if __name__ == "__main__":
    main(*sys.argv[1:])
