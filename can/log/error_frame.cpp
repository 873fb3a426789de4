#include "can/log/error_frame.h"

#include <linux/can/error.h>

namespace hystcan::can {
namespace {

std::optional<BusState> state_in(const Frame& frame) {
  if ((frame.id & CAN_ERR_BUSOFF) != 0) return BusState::bus_off;
  if ((frame.id & CAN_ERR_RESTARTED) != 0) return BusState::active;
  if ((frame.id & CAN_ERR_CRTL) == 0) return std::nullopt;
  const std::uint8_t controller = frame.data[1];
  if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) return BusState::passive;
  if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) return BusState::warning;
  if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) return BusState::active;
  return std::nullopt;
}

std::optional<ErrorCounters> counters_in(const Frame& frame) {
  const ErrorCounters counters{.transmit = frame.data[6], .receive = frame.data[7]};
  if ((frame.id & CAN_ERR_CNT) != 0) return counters;
  const bool are_given = counters.transmit != 0 || counters.receive != 0;
  if ((frame.id & CAN_ERR_CRTL) != 0 && are_given) return counters;
  return std::nullopt;
}

}  // namespace

ErrorReport interpret(const Frame& frame) {
  const bool protocol = (frame.id & CAN_ERR_PROT) != 0;
  const bool in_ack_slot = protocol && frame.data[3] == CAN_ERR_PROT_LOC_ACK;
  return {.state = state_in(frame),
          .error_counters = counters_in(frame),
          .restarted = (frame.id & CAN_ERR_RESTARTED) != 0,
          .not_acknowledged = (frame.id & CAN_ERR_ACK) != 0 || in_ack_slot,
          .arbitration_lost = (frame.id & CAN_ERR_LOSTARB) != 0,
          .protocol_error = protocol && !in_ack_slot,
          .controller_overflow = (frame.id & CAN_ERR_CRTL) != 0 &&
                                 (frame.data[1] & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0,
          .transceiver_error = (frame.id & CAN_ERR_TRX) != 0};
}

void count(const ErrorReport& report, BusCounters& counters) {
  ++counters.error_frames;
  if (report.restarted) ++counters.restarts;
  if (report.not_acknowledged) ++counters.not_acknowledged;
  if (report.arbitration_lost) ++counters.arbitration_lost;
  if (report.protocol_error) ++counters.protocol_errors;
  if (report.controller_overflow) ++counters.controller_overflows;
  if (report.transceiver_error) ++counters.transceiver_errors;
}

void count_entry(BusState state, BusCounters& counters) {
  if (state == BusState::warning) ++counters.warnings;
  if (state == BusState::passive) ++counters.passives;
  if (state == BusState::bus_off) ++counters.bus_offs;
}

}  // namespace hystcan::can
