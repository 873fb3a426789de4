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

std::string_view to_string(Refusal refusal) {
  switch (refusal) {
    case Refusal::none:
      return "none";
    case Refusal::listen_only:
      return "it is listen-only now";
    case Refusal::other_bit_rate:
      return "it has another bit rate now";
    case Refusal::no_fd:
      return "it takes no CAN FD frames now";
  }
  return "unknown";
}

}  // namespace hystcan::can
