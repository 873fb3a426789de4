#include "can/bus.h"

namespace hystcan::can {

std::string_view to_string(BusState state) {
  switch (state) {
    case BusState::active:
      return "active";
    case BusState::warning:
      return "warning";
    case BusState::passive:
      return "passive";
    case BusState::bus_off:
      return "bus-off";
    case BusState::down:
      return "down";
  }
  return "unknown";
}

}  // namespace hystcan::can
