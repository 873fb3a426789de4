"""The safety code and the test programs that exercise it, for scripts/mutants, scripts/coverage and scripts/evidence."""
import hashlib
import pathlib

CONTROL = ("hystcan_control_tests", "hystcan_safety_tests")
PROTOCOL = ("hystcan_can_tests", "hystcan_safety_tests")
TWIN = ("hystcan_twin_tests", "hystcan_safety_tests", "hystcan_twin_fault_tests")
# Source -> the test programs that exercise it, the quickest first.
PROGRAMS = {
    "controller/control/gate.cpp": CONTROL,
    "controller/control/supervisor.cpp": CONTROL,
    "controller/control/arming.cpp": CONTROL,
    "controller/control/axis.cpp": CONTROL,
    "controller/control/following_error.cpp": CONTROL,
    "controller/control/law.cpp": CONTROL,
    "controller/control/plausibility.cpp": CONTROL,
    "controller/command_frame.cpp": ("hystcan_controller_tests", "hystcan_safety_tests"),
    "can/frame.cpp": PROTOCOL,
    "can/protocol/e2e.cpp": PROTOCOL,
    "twin/amplifier_node.cpp": TWIN,
}


def digest_of(source):
    """Tells whether a source is still the one that was measured."""
    return hashlib.sha256((pathlib.Path(__file__).resolve().parent.parent / source).read_bytes()).hexdigest()[:12]
