#include "can/bus_state.h"

#include <linux/can/error.h>

namespace hystcan::can {

std::optional<BusState> state_told_by(const Frame& error_frame) {
  if ((error_frame.id & CAN_ERR_BUSOFF) != 0) return BusState::bus_off;
  if ((error_frame.id & CAN_ERR_RESTARTED) != 0) return BusState::active;
  if ((error_frame.id & CAN_ERR_CRTL) == 0) return std::nullopt;
  const std::uint8_t controller = error_frame.data[1];
  if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) return BusState::passive;
  if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) return BusState::warning;
  if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) return BusState::active;
  return std::nullopt;
}

}  // namespace hystcan::can
