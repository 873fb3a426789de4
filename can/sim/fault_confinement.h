// Fault confinement of one CAN node (ISO 11898-1, 10.11): its error counters and the state that they give.
//
//   transmit error               TEC + 8     not if the node is error-passive and no node acknowledges
//   receive error                REC + 1
//   dominant bit after the flag  REC + 8     only for the receiver that saw the error before all others
//   frame transmitted            TEC - 1     not below 0
//   frame received               REC - 1     not below 0; from above 127 to 119
//
//   warning                      TEC >= 96 or REC >= 96
//   passive                      TEC >= 128 or REC >= 128
//   bus-off                      TEC >= 256
#pragma once

#include <algorithm>

#include "can/bus.h"

namespace hystcan::can {

class FaultConfinement {
 public:
  static constexpr std::uint16_t warning_limit = 96;
  static constexpr std::uint16_t passive_limit = 128;
  static constexpr std::uint16_t bus_off_limit = 256;

  void transmitted() {
    if (counters_.transmit != 0) --counters_.transmit;
  }
  void received() {
    if (counters_.receive >= passive_limit) {
      counters_.receive = receive_after_passive;
    } else if (counters_.receive != 0) {
      --counters_.receive;
    }
  }
  void transmit_error() { counters_.transmit = static_cast<std::uint16_t>(counters_.transmit + 8); }
  void not_acknowledged() {
    if (counters_.transmit < passive_limit) transmit_error();
  }
  void receive_error() { add_to_receive(1); }
  void dominant_after_error_flag() { add_to_receive(8); }
  void restart() { counters_ = {}; }

  bool passive() const { return std::max(counters_.transmit, counters_.receive) >= passive_limit; }
  bool bus_off() const { return counters_.transmit >= bus_off_limit; }
  BusState state() const {
    const std::uint16_t worse = std::max(counters_.transmit, counters_.receive);
    if (bus_off()) return BusState::bus_off;
    if (worse >= passive_limit) return BusState::passive;
    return worse >= warning_limit ? BusState::warning : BusState::active;
  }
  const ErrorCounters& counters() const { return counters_; }

 private:
  static constexpr std::uint16_t receive_after_passive = 119;  ///< the standard allows 119 to 127
  static constexpr std::uint16_t receive_max = 255;            ///< the register has eight bits

  void add_to_receive(std::uint16_t errors) {
    counters_.receive = std::min(receive_max, static_cast<std::uint16_t>(counters_.receive + errors));
  }

  ErrorCounters counters_;
};

}  // namespace hystcan::can
