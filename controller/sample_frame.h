// The frame with the samples of one axis, or of several axes that share it.
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

  /// Adds a SYNC counter by the name of its signal. Several axes may share one counter. Returns the index of
  /// the counter, as `place` for is_doubled(). The same name gives the same index.
  std::size_t add_sync_counter(const std::string& signal);
  /// True if this frame and an earlier, different frame were both accepted with the same SYNC counter. An
  /// identical repeated frame does not count. The answer is computed once for each frame.
  bool is_doubled(std::size_t place, std::uint8_t sync_counter, const can::Frame& frame, std::uint64_t cycle);

 private:
  struct NamedSync {
    std::uint64_t cycle = 0;  ///< cycle in which the frame arrived; 0: no frame has arrived
    can::Frame frame{};
  };
  struct SyncCounter {
    std::string signal;
    std::array<NamedSync, 256> named{};  ///< index: SYNC counter; value: the last frame with this counter
    /// Serial number of the accepted frame for which `is_doubled` was computed last.
    std::uint64_t decided_for = 0;
    bool is_doubled = false;
  };

  std::vector<SyncCounter> counters_;
};

}  // namespace hystcan::controller
