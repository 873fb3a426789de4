"""The safety code and the test programs that exercise it, for scripts/mutants, scripts/coverage and scripts/evidence."""
import hashlib
import pathlib
import re

CONTROL = ("hystcan_control_tests", "hystcan_safety_tests")
PROTOCOL = ("hystcan_can_tests", "hystcan_safety_tests")
TWIN = ("hystcan_twin_tests", "hystcan_safety_tests", "hystcan_twin_fault_tests")
# Source -> the test programs that exercise it, the quickest first.
PROGRAMS = {
    "controller/control/gate.cpp": CONTROL,
    "controller/control/supervisor.cpp": CONTROL,
    "controller/control/arming.cpp": CONTROL,
    "controller/control/axis.cpp": CONTROL,
    "controller/control/start_up.cpp": CONTROL,
    "controller/control/fall.cpp": CONTROL,
    "controller/control/following_error.cpp": CONTROL,
    "controller/control/law.cpp": CONTROL,
    "controller/control/output_check.cpp": CONTROL,
    "controller/control/course.cpp": CONTROL,
    "controller/control/ramp_check.cpp": CONTROL,
    "controller/command_frame.cpp": ("hystcan_controller_tests", "hystcan_safety_tests"),
    "can/frame.cpp": PROTOCOL,
    "can/protocol/e2e.cpp": PROTOCOL,
    "node/amplifier_node.cpp": TWIN,
    "node/amplifier_channel.cpp": TWIN,
}
# Additional sources for mutants: the code that carries inputs and commands, and other code that acts by itself or on
# request.
NODE = ("hystcan_node_tests", "hystcan_controller_tests", "hystcan_safety_tests")
REFERENCE = ("hystcan_control_tests",)
MUTATED = PROGRAMS | {
    "controller/control/supervisor.h": CONTROL,
    "controller/control/learning.cpp": CONTROL,
    "controller/reference/trajectory.cpp": REFERENCE,
    "controller/reference/transition.cpp": REFERENCE,
    "controller/wired_axis.cpp": NODE,
    "controller/sensor_link.cpp": NODE,
    "controller/amplifier_link.cpp": NODE,
    "controller/sample_frame.cpp": NODE,
    "controller/remote_node.cpp": NODE,
    "controller/background_frames.cpp": NODE,
    "controller/requests.cpp": ("hystcan_telemetry_tests", "hystcan_node_tests", "hystcan_closed_loop_tests"),
    "app/live/live_run.cpp": ("hystcan_live_run_tests",),
    "app/page/page_requests.cpp": ("hystcan_page_tests",),
}


# A comment, or a literal in which "//" does not begin a comment.
TOKEN = re.compile(r"""//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])+'""", re.DOTALL)


def digest_of(source):
    """Returns a digest that changes with the code of a source, but not with its comments and its layout."""
    text = (pathlib.Path(__file__).resolve().parent.parent / source).read_text("utf-8")
    return digest_of_text(text)


def digest_of_text(text):
    code = TOKEN.sub(lambda token: " " if token.group().startswith("/") else token.group(), text)
    return hashlib.sha256("".join(code.split()).encode()).hexdigest()[:12]
