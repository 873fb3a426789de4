// One axis of a controller without a bus. A test passes the frames of the amplifier to it.
#pragma once

#include <chrono>
#include <optional>
#include <utility>

#include "controller/wired_axis.h"

namespace hystcan::support {

class LoneAxis {
 public:
  LoneAxis(const controller::WiredAxisConfig& config, const can::Database& database)
      : wired(config, 0, std::chrono::milliseconds(300), database, frames_),
        encode_(encoder(config.wire, database)) {}

  /// Returns true if the status reports the same state as the previous status, and this state is not `off`.
  bool hear_status(const can::AmpStatus& status) { return hear_status_frame(*(*encode_)(status)); }
  bool hear_status_frame(const can::Frame& frame) {
    return wired.amplifier.statuses()->accepts(frame) && wired.amplifier.on_status(frame, {});
  }
  std::optional<can::SensorSample> hear_sample(const can::Frame& frame, std::uint64_t cycle) {
    if (!wired.sensor.samples().accepts(frame)) return std::nullopt;
    return wired.sensor.on_sample(frame, cycle);
  }
  controller::NodeHealth health(can::BusState bus = can::BusState::active, can::Time now = {}) {
    controller::AxisInput input;
    wired.amplifier.take_health(now, bus, input);
    return input.health;
  }

 private:
  controller::SharedFrames frames_;

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
