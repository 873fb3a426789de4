#include "controller/control/fault.h"

#include <array>

namespace hystcan::controller {
namespace {

struct CauseTraits {
  std::string_view name;
  std::string_view remedy;
  bool leaves_the_drive_in_hand = false;
};

constexpr std::array<CauseTraits, cause_count> cause_traits{{
    {"none", ""},
    {"interface down",
     "bring the CAN interface up with the settings that it had at the start, then clear and enable the axis"},
    {"bus-off", "check wiring, termination and bit rate, then clear and enable the axis"},
    {"cycle overrun",
     "the program did not run in time: give the controller a real-time class in [controller.realtime]"},
    {"sample missing", "check the sensor node and the bus load", true},
    {"sensor status", "the sensor reports a bad sample: check the sensor", true},
    {"position implausible",
     "the position is outside position_min_um..position_max_um: check sensor and stage", true},
    {"sensor silent",
     "no heartbeat of the sensor in heartbeat_timeout_ms: check its supply, its cable, its heartbeat period",
     true},
    {"amplifier silent",
     "no heartbeat of the amplifier in heartbeat_timeout_ms: check its supply, its cable, its heartbeat "
     "period"},
    {"node restarted", "a node booted up while in use: check its supply"},
    {"node not set up",
     "a node refused a setup object or did not keep its value: see the log, and check the index and value of "
     "the object"},
    {"amplifier fault",
     "the amplifier tripped or is still faulted: find the cause, then clear and enable the axis"},
    {"amplifier not enabled",
     "the amplifier does not report that it is enabled: check its interlocks, and set "
     "enable_delay_ms to at least the start-up time in its data sheet"},
    {"following error",
     "the stage does not follow the reference: check that the amplifier drives the stage, and check load, "
     "model and gains",
     true},
    {"command not sendable",
     "the drive does not fit the Setpoint signal: check the DBC against drive_min and drive_max"},
    {"another controller is on this bus",
     "another node sends a frame that only this controller may send (SYNC, its heartbeat, a command or an "
     "axis status): the log shows the frame; stop one of the two controllers"},
    {"sample late",
     "samples arrive after the next SYNC or after command_deadline_us: check the bus load and the "
     "sensor's rate",
     true},
    {"position frozen",
     "the drive moves, but the measured position does not change at all: check sensor and stage", true},
    {"position jumped",
     "the position moved by more than position_jump_um in a cycle: check the sensor and its cable; if the "
     "position oscillated before, lower the gains or set a notch",
     true},
    {"node emergency", "a node sent an emergency: the log shows its code and meaning"},
    {"node not operational", "a node left the state operational by itself: check its log and its supply"},
    {"bus passive", "the CAN controller counts errors: check wiring, termination and bit rate"},
    {"saturated", "the drive is at a limit: check reference, load and drive_min..drive_max", true},
    {"model left its range",
     "the model cannot be inverted at this drive: identify the actuator again over its whole range", true},
    {"watchdog failed",
     "the amplifier did not react to missing commands: configure its watchdog before you drive the actuator"},
    {"commands late",
     "the commands are not transmitted: check the bus load and the wiring, and that a node is on the bus"},
    {"sample doubled",
     "two different samples have the same SYNC: two nodes send this message, or the sensor does not "
     "sample at the SYNC",
     true},
    {"status missing",
     "no status of the amplifier in status_timeout_ms: check the amplifier node and the bus load"},
    {"foreign NMT or SDO",
     "another node sends an NMT command or an SDO to a node of this axis: see the log, and stop the sender"},
    {"loop unstable",
     "the loop oscillates: lower kp and ki_per_s, set a notch at the resonance; `hystcan tune` finds the "
     "values",
     true},
    {"output differs",
     "the amplifier's output differs from the command: check its interlock, its supply, its limits and "
     "slew, and amplifier_bandwidth_Hz"},
    {"position contradicts drive",
     "the start-up ramp does not move the position as the model predicts: check the sensor's sign and "
     "scale, and the amplifier's range and supply; identify the stage again if it has changed"},
}};

}  // namespace

std::string_view to_string(Cause cause) { return cause_traits[static_cast<std::size_t>(cause)].name; }
std::string_view remedy(Cause cause) { return cause_traits[static_cast<std::size_t>(cause)].remedy; }

bool leaves_the_drive_in_hand(Cause cause) {
  return cause_traits[static_cast<std::size_t>(cause)].leaves_the_drive_in_hand;
}

}  // namespace hystcan::controller
