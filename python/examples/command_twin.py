"""Commands a running controller, on the bench or with a twin on vcan: moves to positions, and records the run.

    hystcan twin config/piezo.toml --interface vcan0 &
    hystcan controller config/piezo.toml --interface vcan0 &
    python3 command_twin.py --interface vcan0

If the script fails or is interrupted, every axis ramps to its safe drive and the controller ends.
"""
import argparse
import time

import hystcan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--interface", default="vcan0")
    parser.add_argument("--socket", help="path of the control socket, if it is not the default one")
    parser.add_argument("--axis", default="x")
    parser.add_argument("--positions", type=float, nargs="+", default=[8.0, 12.0, 10.0], help="um")
    options = parser.parse_args()
    with hystcan.Client(options.socket, interface=options.interface) as stage:
        while stage.axis(options.axis)["state"] != "tracking":
            time.sleep(0.1)
        run = stage.record()
        for position_um in options.positions:
            stage.go_to(options.axis, position_um)
            time.sleep(1.0)
            now = stage.axis(options.axis)
            print(f"{now['position_um']:.4f} um at {now['drive']:.3f}, error {now['error_um']:+.4f} um")
        stage.record(False)
        stage.resume(options.axis)
    print(f"recorded in {run}: hystcan plot {run}")


if __name__ == "__main__":
    main()
