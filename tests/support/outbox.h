// A connection without a bus: it stores the sent frames and receives nothing.
#pragma once

#include <vector>

#include "can/bus.h"

namespace hystcan::support {

class Outbox final : public can::Bus {
 public:
  bool send(const can::Frame& frame) override {
    if (!takes) return false;
    frames.push_back(frame);
    return true;
  }
  void on_frame(FrameHandler) override {}
  bool on_sent(FrameHandler) override { return true; }
  void on_state(StateHandler) override {}
  can::BusState state() const override { return can::BusState::active; }
  const can::BusCounters& counters() const override { return counters_; }

  std::vector<can::Frame> frames;
  bool takes = true;  ///< false: the connection refuses frames

 private:
  can::BusCounters counters_;
};

}  // namespace hystcan::support
