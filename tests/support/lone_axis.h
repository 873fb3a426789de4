// One axis of a controller without a bus. A test gives it the frames of its amplifier.
#pragma once

#include <chrono>

#include "controller/wired_axis.h"

namespace hystcan::support {

class LoneAxis {
 public:
  LoneAxis(const controller::WiredAxisConfig& config, const can::Database& database)
      : wired(config, std::chrono::milliseconds(300), database),
        encode_(*can::find_layout<can::AmpStatus>(database, config.wire)) {}

  void hear_status(const can::AmpStatus& status) { wired.amplifier.on_status(*encode_(status), {}); }
  controller::NodeHealth health() {
    controller::AxisInput input;
    wired.amplifier.take_health({}, can::BusState::active, input);
    return input.health;
  }

  controller::WiredAxis wired;

 private:
  can::Encoder<can::AmpStatus> encode_;
};

}  // namespace hystcan::support
