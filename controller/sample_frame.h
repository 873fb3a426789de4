// The frame with the samples of the axes that share it; mostly of one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "controller/received_frame.h"

namespace hystcan::controller {

class SampleFrame : public ReceivedFrame {
 public:
  using ReceivedFrame::ReceivedFrame;

  /// The axes have one counter of the SYNC, or each its own. Returns the place of the one with this name.
  std::size_t add_sync_counter(const std::string& signal);
  /// This frame and another one, both accepted, name the same SYNC. A frame that is sent twice is no other
  /// one. Decided once for each frame.
  bool is_doubled(std::size_t place, std::uint8_t sync_counter, const can::Frame& frame, std::uint64_t cycle);

 private:
  struct NamedSync {
    std::uint64_t cycle = 0;  ///< 0: none yet
    can::Frame frame{};
  };
  struct SyncCounter {
    std::string signal;
    std::array<NamedSync, 256> named{};  ///< by counter: the last frame that named it
    std::uint64_t decided_for = 0;       ///< the number of the accepted frame
    bool is_doubled = false;
  };

  std::vector<SyncCounter> counters_;
};

}  // namespace hystcan::controller
