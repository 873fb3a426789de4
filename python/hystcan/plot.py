"""Draws hystcan's pictures with matplotlib from the CSV files that the program writes.

    python3 -m hystcan.plot FOLDER/pictures.json

draws again what `hystcan plot`, `demo`, `identify --report` or `tune --plot` has drawn. pictures.json lists the pictures:
`kind` is a function of this file, `data` its CSV files, `to` the files to draw, and the rest its facts: labels, limits.
Only this file decides how a picture looks. To change that, edit this file, or call a copy of it in the same way.
"""
import csv
import json
import os
import pathlib
import sys
import textwrap

try:
    import matplotlib.figure  # type: ignore[import]
    import numpy
except ImportError:
    sys.exit("the Python module matplotlib is missing; install python3-matplotlib")

LOOK = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 9, "legend.fontsize": 8,
    "axes.labelsize": 9, "axes.titlesize": 9, "figure.titlesize": 10,
    "axes.linewidth": 0.5, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#dddddd", "grid.linewidth": 0.4, "axes.axisbelow": True,
    "xtick.major.size": 3, "ytick.major.size": 3, "xtick.major.width": 0.5, "ytick.major.width": 0.5,
    "legend.frameon": False, "lines.linewidth": 1.0, "savefig.dpi": 200,
    "svg.fonttype": "none", "svg.hashsalt": "hystcan", "agg.path.chunksize": 10000,
}
# Colours that colour-blind people can distinguish; without colour, the dashes differ.
SOLID: list[dict] = [{"color": color} for color in ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#999999", "#000000")]
BLUE, GREY, BLACK = SOLID[0], SOLID[4], {**SOLID[5], "linewidth": 0.8}
VERMILION, GREEN = {**SOLID[1], "dashes": (7, 2)}, {**SOLID[2], "dashes": (2, 2)}
ORANGE = {"color": "#e69f00"}
POINTS = {"marker": "o", "linestyle": "none", "markeredgewidth": 0}


class Table:
    """A CSV file: `table["position_um"]` is an array of numbers, NaN for a missing one."""

    def __init__(self, path):
        with open(path, encoding="utf-8", errors="replace", newline="") as file:
            self.names, *rows = csv.reader(line for line in file if line.strip() and not line.startswith("#"))
        self.columns = list(zip(*rows)) or [()] * len(self.names)

    def text(self, name):
        return numpy.array(self.columns[self.names.index(name)], dtype=object)

    def __getitem__(self, name):
        return numpy.array([float(value or "nan") for value in self.columns[self.names.index(name)]])


def plain(text):
    """Return the text in one line, with dollars escaped so that they do not begin a formula."""
    return "".join(c if c.isprintable() else " " for c in text).replace("$", r"\$")


def key_above(ax, rows=1):
    """Put the key above the plot, outside the data; one entry per row if they do not fit side by side."""
    handles, labels = ax.get_legend_handles_labels()
    width_pt = ax.figure.get_figwidth() * 72 * ax.get_position().width
    columns = -(-len(labels) // rows) if 4 * sum(len(label) + 7 for label in labels) < width_pt * rows else 1
    labels = [textwrap.fill(label, max(12, int((width_pt - 30) / 4.6))) for label in labels]
    ax.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 1), ncol=max(1, columns), handlelength=2.5,
              borderaxespad=0.2)


# ---- a recorded run

def loops(figure, data, drive_unit, legend):
    ax = figure.subplots()
    ax.plot(data["drive"], data["position_um"], **BLUE, label=plain(legend))
    ax.set(xlabel=plain(f"drive ({drive_unit})"), ylabel="position (um)")
    key_above(ax)


def tracking(figure, data):
    above, below = figure.subplots(2, sharex=True, height_ratios=(55, 45))
    above.plot(data["time_s"], data["reference_um"], **BLACK, label="reference")
    above.plot(data["time_s"], data["position_um"], **BLUE, label="measured")
    above.set(ylabel="position (um)")
    key_above(above)
    below.plot(data["time_s"], data["error_um"], **VERMILION)
    below.set(xlabel="time (s)", ylabel="error (um)")


def error(figure, data, legend):
    ax = figure.subplots()
    ax.plot(data["time_s"], data["error_um"], **BLUE, label=plain(legend))
    ax.set(xlabel="time (s)", ylabel="error (um)")
    key_above(ax)


def spectrum(figure, data, legend):
    ax = figure.subplots()
    ax.loglog(data["frequency_Hz"], data["error_um_per_sqrtHz"], **BLUE, label=plain(legend))
    ax.set(xlabel="frequency (Hz)", ylabel="error (um/√Hz)")
    ax.xaxis.set_major_formatter("{x:g}")
    key_above(ax)


def step(figure, data, legend):
    ax = figure.subplots()
    time_ms = 1e3 * data["time_s"]
    ax.plot(time_ms, data["reference_um"], **BLACK, drawstyle="steps-post", label="reference")
    ax.plot(time_ms, data["position_um"], **BLUE, label=plain(legend))
    ax.set(xlabel="time after the step (ms)", ylabel="position (um)")
    key_above(ax)


def timing(figure, data):
    ax = figure.subplots()
    least = 1e-4  # percent
    what = data.text("what")
    for line, name in zip(SOLID, dict.fromkeys(what)):
        of = what == name
        ax.vlines(data["upper_us"][of], least, data["share_percent"][of], **line, linewidth=2, label=plain(name))
    ax.set(yscale="log", ylim=(least, 150), xlabel="time (us)", ylabel="cycles (%)")
    ax.set_xlim(left=0)
    ax.yaxis.set_major_formatter("{x:g}")
    key_above(ax)


def comparison(figure, data, legends):
    ax = figure.subplots()
    for i, legend in enumerate(legends):
        of = data["which"] == i
        ax.plot(data["time_s"][of], data["error_um"][of], **SOLID[i % len(SOLID)], label=plain(legend))
    ax.set(xlabel="time since the first cycle (s)", ylabel="error (um)")
    key_above(ax, rows=4)


# ---- the demo

def demo(figure, open_loop, *runs, names, title, axis, drive_unit, stroke_um, delay_cycles, from_s, to_s):
    """Draw the tracking cycles of one axis in open loop and with each further structure; the last one is the loop."""
    loop = runs[-1]

    def of(data, values):
        is_shown = data.text("state")[data.text("axis") == axis] == "tracking"
        return numpy.where(is_shown, values, numpy.nan)

    def column(data, name):
        return of(data, data[name][data.text("axis") == axis])

    def acting_drive(data):
        """Return the drive `delay_cycles` earlier, whose effect the sample shows."""
        drive = data["drive"][data.text("axis") == axis]
        cycle = numpy.arange(len(drive))
        return of(data, numpy.interp(cycle - delay_cycles, cycle, drive, left=numpy.nan))

    def plot(ax, data, x, y, line, legend, **more):
        ax.plot(column(data, x), column(data, y), **{**line, **more}, label=legend)

    figure.suptitle(plain(title))
    (actuator, before_after), (course, errors) = figure.subplots(2, 2)
    actuator.plot(acting_drive(loop), column(loop, "position_um"), **SOLID[1], label="measured")
    actuator.set(xlabel=plain(f"drive ({drive_unit})"), ylabel="position (um)")
    plot(before_after, open_loop, "reference_um", "position_um", GREY, f"{names[0]} (open loop)")
    plot(before_after, loop, "reference_um", "position_um", BLUE, names[-1])
    before_after.set(xlabel="reference (um)", ylabel="position (um)")
    plot(course, loop, "time_s", "reference_um", BLACK, "reference", linewidth=1.6)
    # Beside several closed loops, the error of open loop would hide theirs.
    shown = [(loop, BLUE, names[-1])]
    shown = [*zip(runs, (VERMILION, GREEN), names[1:-1]), *shown] if len(runs) > 1 else [(open_loop, GREY, names[0]), *shown]
    for data, line, name in shown:
        plot(course, data, "time_s", "position_um", line, name)
        errors.plot(column(data, "time_s"), 100 * column(data, "error_um") / stroke_um, color=line["color"], label=name)
    course.set(xlabel="time (s)", ylabel="position (um)", xlim=(from_s, to_s))
    errors.set(xlabel="time (s)", ylabel="error (% of stroke)")
    for ax, name in ((actuator, "The actuator: hysteresis"), (before_after, "Wanted against measured: before and after"),
                     (course, "Tracking"), (errors, "Error")):
        key_above(ax)
        ax.set_title(name, pad=18)


# ---- tune

def response(figure, data, title):
    """Draw a frequency response. Rows with a coherence are measured, the others are from the model and the loops."""
    frequency_Hz = data["frequency_Hz"]
    measured = numpy.isfinite(data["coherence"])
    curve = ~measured & (frequency_Hz >= 0.5)
    figure.suptitle(plain(title))
    panels = figure.subplots(3, sharex=True)

    def decibel(name):
        return 20 * numpy.log10(data[name])

    for ax, found, model in ((panels[0], decibel("measured_gain"), decibel("model_gain")),
                             (panels[1], data["measured_phase_deg"], data["model_phase_deg"])):
        points = ax.scatter(frequency_Hz[measured], found[measured], s=4, c=data["coherence"][measured], vmin=0, vmax=1,
                            cmap=matplotlib.colors.LinearSegmentedColormap.from_list("coherence", ("#d0d0d0", "#0072b2")),
                            label="measured")
        ax.plot(frequency_Hz[curve], model[curve], color=VERMILION["color"], label="model")
        figure.colorbar(points, ax=ax, label="coherence")
    for name, legend in (("gain", "L"), ("sensitivity", "1/(1+L)")):
        for which, line in (("before", GREY), ("after", BLUE)):
            panels[2].plot(frequency_Hz[curve], decibel(f"{which}_{name}")[curve], color=line["color"],
                           linestyle="-" if name == "gain" else "--", label=f"{legend} {which}")
    for ax, label in zip(panels, ("plant, gain [dB]", "plant, phase [deg]", "loop, gain [dB]")):
        ax.set(xscale="log", ylabel=label)
        key_above(ax)
    panels[2].set(xlim=(0.5, None), xlabel="frequency [Hz]")
    panels[2].xaxis.set_major_formatter("{x:g}")


# ---- identify --report: record.csv, curves.csv, landscape.csv

def datasets(record):
    return [record["record"] == k for k in dict.fromkeys(record["record"])]


def label_of(what, unit):
    return plain(f"{what} [{unit}]" if unit else what)


def fit(figure, record, input_unit, output_unit):
    ax = figure.subplots()
    for name, line, width, legend in (("output", ORANGE, 3, "measured"), ("predicted", BLUE, 1.1, "model")):
        for k, of in enumerate(datasets(record)):
            ax.plot(record["input"][of], record[name][of], **line, linewidth=width, label=legend if k == 0 else None)
    ax.set(xlabel=label_of("input", input_unit), ylabel=label_of("output", output_unit))
    key_above(ax)


def residual_time(figure, record, span):
    each = datasets(record)
    for k, (ax, of) in enumerate(zip(figure.subplots(len(each), squeeze=False)[:, 0], each)):
        ax.axhline(0, color="#404040", linewidth=1)
        ax.plot(record["time_s"][of], 100 * record["residual"][of] / span, **BLUE)
        ax.margins(x=0)
        ax.set(xlabel="time [s]", ylabel="measured - model [% of span]",
               title=f"dataset {k + 1}" if len(each) > 1 else "")


def residual_input(figure, record, input_unit, span):
    ax = figure.subplots()
    drive = record["input"]
    way = numpy.sign(numpy.diff(drive, prepend=drive[:1]))
    way = way[numpy.maximum.accumulate(numpy.where(way != 0, numpy.arange(len(way)), 0))]  # at rest: the last one
    size = 1.6 if len(drive) > 2000 else 2.5
    ax.axhline(0, color="#404040", linewidth=1)
    for of, line, legend in ((way > 0, VERMILION, "rising"), (way < 0, BLUE, "falling")):
        ax.plot(drive[of], 100 * record["residual"][of] / span, **POINTS, color=line["color"], markersize=size)
        ax.plot([], [], **POINTS, color=line["color"], markersize=4, label=legend)
    ax.set(xlabel=label_of("input", input_unit), ylabel="measured - model [% of span]")
    key_above(ax)


def curves(figure, record, table, input_unit, output_unit, span, observed):
    above, below = figure.subplots(2, sharex=True)
    drive = table["input"]
    for k, of in enumerate(datasets(record)):
        above.plot(record["input"][of], record["output"][of], color="#d0d0d0", label="measured" if k == 0 else None)
    for name, line in (("ascending", VERMILION), ("descending", BLUE)):
        above.plot(drive, table[name], color=line["color"], linewidth=1.5, label=name)
    # Extrapolated curves may extend far beyond the measured range: clip them half a span beyond it.
    low, high = above.get_ylim()
    above.set_ylim(max(low, record["output"].min() - 0.5 * span), min(high, record["output"].max() + 0.5 * span))
    below.plot(drive, 100 * (table["descending"] - table["ascending"]) / span, color="#404040", linewidth=1.5,
               label="descending - ascending")
    below.set_ylim(bottom=0)
    for ax in (above, below):
        for i, end in enumerate(observed):
            ax.axvline(end, color="#404040", linestyle=":", linewidth=1.2,
                       label="ends of the inputs observed" if i == 0 and ax is above else None)
        key_above(ax)
    above.set(ylabel=label_of("output", output_unit))
    below.set(xlim=(drive.min(), drive.max()), xlabel=label_of("input", input_unit), ylabel="distance [% of span]")


def landscape(figure, table, span, drive_span, best):
    """Draw the error over asinh(k times the drive span), which shows both signs and all orders of magnitude."""
    ax = figure.subplots()
    across, up = (numpy.unique(table[name]) for name in ("k_ascending", "k_descending"))
    percent = 100 * table["rms"].reshape(len(up), len(across)) / span
    least, most = percent.min(), percent.max()
    # Otherwise the position of the minimum would not be visible.
    top = max(min(most, 4 * least), least + 1e-4)
    x, y = numpy.arcsinh(across * drive_span), numpy.arcsinh(up * drive_span)
    colours = ax.pcolormesh(x, y, percent, shading="gouraud", vmin=least, vmax=top, cmap="viridis", rasterized=True)
    ax.contour(x, y, percent, levels=sorted({1.05 * least, 1.5 * least}), colors="white", linewidths=1.5)
    ax.plot(*numpy.arcsinh(numpy.array(best) * drive_span), marker="x", color="white", markersize=10, markeredgewidth=2)
    ticks = (-300, -100, -30, -10, -3, -1, -0.3, 0, 0.3, 1, 3, 10, 30, 100, 300)
    ax.set_xticks(numpy.arcsinh(ticks), [f"{k:g}" for k in ticks])
    ax.set_yticks(numpy.arcsinh(ticks), [f"{k:g}" for k in ticks])
    ax.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), title="lines: 1.05 and 1.5 times the least; cross: the model",
           xlabel="k ascending, times the span of the thresholds",
           ylabel="k descending, times the span of the thresholds")
    figure.colorbar(colours, label="RMS [% of output span]" + (", cut off at the last colour" if most > top else ""))


KINDS = (loops, tracking, error, spectrum, step, timing, comparison, demo, response, fit, residual_time, residual_input,
         curves, landscape)


def save(figure, path):
    """Save the figure; the file is complete or missing."""
    unfinished = path.with_name(f"{path.name}.undone")
    dates = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    try:
        figure.savefig(unfinished, format=path.suffix[1:], metadata=dates.get(path.suffix))
        os.replace(unfinished, path)
    except OSError as refused:
        unfinished.unlink(missing_ok=True)
        sys.exit(f"{path.name} cannot be written: {refused.strerror}")


def draw(folder, kind, data, to, size_mm, **facts):
    """Draw one picture in each of its formats."""
    with matplotlib.rc_context(LOOK):
        figure = matplotlib.figure.Figure(figsize=[mm / 25.4 for mm in size_mm], layout="constrained")
        make = next(function for function in KINDS if function.__name__ == kind)
        make(figure, *(Table(folder / name) for name in data), **facts)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # once for all formats
        for name in to:
            save(figure, folder / name)


def main(path):
    for picture in json.loads(path.read_text(encoding="utf-8")):
        draw(path.parent, **picture)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
