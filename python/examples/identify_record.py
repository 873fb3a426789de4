"""Identifies a model from a measured record, and draws what it explains.

    python3 identify_record.py RECORD.csv [--output NAME]      CSV with time_s,input,output, as of `hystcan excite`
    python3 identify_record.py --synthetic [--output NAME]     a record of the shipped stage with noise

Writes NAME.model.toml, which `hystcan controller` takes, and NAME.png.
"""
import argparse

import hystcan
import matplotlib.pyplot as plt
import numpy

BLUE, ORANGE = "#0072b2", "#d55e00"


def synthetic() -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Return a record of shrinking loops with 0.05 % noise."""
    t = numpy.arange(8000) * 1e-3
    u = 50 - 50 * (1 - t / 10) * numpy.cos(7 * t)
    y = hystcan.Model.load(hystcan.shipped("piezo.model.toml")).simulate(u)
    return t, u, y + 0.015 * numpy.random.default_rng(1).standard_normal(t.size)


def measured(file: str) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    with open(file) as lines:  # genfromtxt would use the first comment as the header
        rows = [line for line in lines if not line.startswith("#")]
    record = numpy.genfromtxt(rows, delimiter=",", names=True)
    return record["time_s"], record["input"], record["output"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("record", nargs="?")
    parser.add_argument("--synthetic", action="store_true")
    parser.add_argument("--output", default="identified")
    options = parser.parse_args()
    if not options.synthetic and options.record is None:
        parser.error("RECORD.csv is missing, expected a record or --synthetic")
    t, u, y = synthetic() if options.synthetic else measured(options.record)

    found = hystcan.identify(t, u, y)
    for finding in found.report["findings"]:
        print("-", finding)
    found.save(options.output + ".model.toml")

    predicted = hystcan.validate(found.model, t, u, y)["predicted"]
    figure, (loops, residual) = plt.subplots(2, 1, figsize=(6.3, 7.0), height_ratios=[2, 1], layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.95))  # space for the legend above
    loops.plot(u, y, ".", ms=2, color=BLUE, label="measured")
    loops.plot(u, predicted, lw=1.0, color=ORANGE, label="model")
    loops.set(xlabel="input (V)", ylabel="output (um)")
    residual.plot(t, y - predicted, lw=0.5, color=BLUE)
    residual.set(xlabel="time (s)", ylabel="measured - model (um)")
    figure.legend(*loops.get_legend_handles_labels(), loc="upper center", ncols=2, frameon=False)
    figure.savefig(options.output + ".png", dpi=150)


if __name__ == "__main__":
    main()
