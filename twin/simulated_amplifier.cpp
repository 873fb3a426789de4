#include "twin/simulated_amplifier.h"

namespace hystcan::twin {

void SimulatedAmplifier::go_to(double drive, can::Time from, can::Duration within) {
  plant_.advance_to(from);
  plant_.move_target(drive, within);
}

void SimulatedAmplifier::leave(node::WatchdogAction action, can::Time from) {
  plant_.advance_to(from);
  switch (action) {
    case node::WatchdogAction::safe:
      return plant_.set_target(config_.safe_drive);
    case node::WatchdogAction::hold:
      return;
    case node::WatchdogAction::ramp:
      return plant_.set_target(config_.safe_drive, Amplifier::Course::ramp);
    case node::WatchdogAction::off:
      return plant_.set_target(0.0, Amplifier::Course::off);
  }
}

double SimulatedAmplifier::output(can::Time at) {
  plant_.advance_to(at);
  return plant_.drive();
}

}  // namespace hystcan::twin
