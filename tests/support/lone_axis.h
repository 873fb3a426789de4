// One axis of a controller without a bus. A test gives it the frames of its amplifier.
#pragma once

#include <chrono>
#include <optional>
#include <utility>

#include "controller/wired_axis.h"

namespace hystcan::support {

class LoneAxis {
 public:
  LoneAxis(const controller::WiredAxisConfig& config, const can::Database& database)
      : commands_(*can::find_layout<can::AmpCommand>(database, config.wire), 0, config.axis.gate.safe_drive),
        wired(config, std::chrono::milliseconds(300), database, commands_, 0),
        encode_(encoder(config.wire, database)) {}

  /// True: it repeats the state of the one before.
  bool hear_status(const can::AmpStatus& status) {
    return wired.amplifier.on_status(*(*encode_)(status), {});
  }
  controller::NodeHealth health(can::BusState bus = can::BusState::active, can::Time now = {}) {
    controller::AxisInput input;
    wired.amplifier.take_health(now, bus, input);
    return input.health;
  }

 private:
  controller::CommandFrame commands_;

 public:
  controller::WiredAxis wired;

 private:
  using Encoder = can::Encoder<can::AmpStatus>;
  static std::optional<Encoder> encoder(const can::AxisWire& wire, const can::Database& database) {
    auto layout = can::find_layout<can::AmpStatus>(database, wire);
    return layout ? std::optional<Encoder>(std::move(*layout)) : std::nullopt;
  }
  std::optional<Encoder> encode_;  ///< empty: the amplifier sends no status
};

}  // namespace hystcan::support
