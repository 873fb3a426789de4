"""Draws figure 6 of the paper: larger k, wider inner loops, up to branches that do not increase.

    python3 fig6.py [--output figure6.png]

Bashash and Jalili (2009) give neither curves nor input; these are ours, as in docs/figures/figure6.png.
"""
import argparse
import pathlib
import tempfile
import warnings

import hystcan
import matplotlib.pyplot as plt
import numpy

MODEL = """
[hysteresis]
kind         = "recursive-memory"
input_unit   = "V"
output_unit  = "um"
input_min    = 0.0
input_max    = 10.0
basis        = "power"
ascending    = [0, 0.525, 0.09, -0.004]
descending   = [0.5, 1.075, 0.03, -0.004]
k_ascending  = {}
k_descending = {}
symmetry     = "none"
"""
PANELS = {"(a) k = 0.05 1/V": (0.05, 0.05), "(b) k = 0.5 1/V": (0.5, 0.5),
          "(c) k = 1.5 1/V: beyond the limit": (1.5, 1.5),
          "(d) k_A = 1.5 1/V, k_D = 0.05 1/V: beyond the limit": (1.5, 0.05)}
TURNING_V = [1.0, 9.0, 2.2, 7.6, 3.6]
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#999999"


def model_of(k_ascending: float, k_descending: float) -> hystcan.Model:
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "figure6.toml"
        file.write_text(MODEL.format(k_ascending, k_descending))
        return hystcan.Model.load(file, beyond_limit=True)


def path_through(corners: list[float]) -> numpy.ndarray:
    """Return the path from corner to corner in steps of 0.02 V."""
    legs = [numpy.linspace(a, b, int(abs(b - a) / 0.02) + 2)[1:] for a, b in zip(corners, corners[1:])]
    return numpy.concatenate([[corners[0]], *legs])


def draw_panel(axes: plt.Axes, title: str, ks: tuple[float, float]) -> None:
    model = model_of(*ks)
    memory = model.memory()
    u = path_through([0.0, 10.0, *TURNING_V, 10.0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # some branches do not increase; the figure shows them
        model.simulate(path_through([0.0, 10.0, *TURNING_V, 4.0]), memory)
        y = model.simulate(u)
        rising = numpy.linspace(0.0, 10.0, 200)
        ascending = model.simulate(rising)
        descending = model.simulate(numpy.append(10.0, rising[::-1]))[1:]
    assert numpy.array_equal(memory.turning_inputs, TURNING_V), "all five turning points are remembered"
    wrong = numpy.append(False, numpy.diff(u) * numpy.diff(y) < 0)
    axes.plot(rising, ascending, color=GREY, lw=2.5, label="reference curves")
    axes.plot(rising[::-1], descending, color=GREY, lw=2.5)
    axes.plot(u, y, color=BLUE, lw=1.0, label="path")
    axes.plot(u, numpy.where(wrong, y, numpy.nan), color=ORANGE, lw=2.0, label="path going the wrong way")
    axes.set_title(title, fontsize=9)
    axes.set_xlabel("input (V)")
    axes.set_ylabel("output (um)")
    assert wrong.any() == ("beyond" in title), title


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", default="figure6.png")
    output = parser.parse_args().output
    figure, axes = plt.subplots(2, 2, figsize=(8.0, 7.0), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.95))  # space for the legend above
    for panel, (title, ks) in zip(axes.flat, PANELS.items()):
        draw_panel(panel, title, ks)
    figure.legend(*axes.flat[-1].get_legend_handles_labels(), loc="upper center", ncols=3, frameon=False)
    figure.savefig(output, dpi=150)
    print(output)


if __name__ == "__main__":
    main()
