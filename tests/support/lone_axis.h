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

  void hear_status(const can::AmpStatus& status) { wired.handle_status(*encode_(status), {}); }
  controller::NodeHealth health() { return wired.take_health({}, can::BusState::active); }

  controller::WiredAxis wired;

 private:
  can::Encoder<can::AmpStatus> encode_;
};

}  // namespace hystcan::support
