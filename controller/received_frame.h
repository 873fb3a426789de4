// A message that the controller receives. Its signals belong to one axis, or to several axes. Each frame is
// checked once for all of these axes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "can/protocol/protocol.h"

namespace hystcan::controller {

class ReceivedFrame {
 public:
  template <class Payload>
  ReceivedFrame(const can::Layout<Payload>& layout, std::string message)
      : message_(std::move(message)),
        id_(layout.id()),
        extended_(layout.extended()),
        checker_(layout.checker()) {}

  void add(std::size_t axis) { axes_.push_back(axis); }
  const std::vector<std::size_t>& axes() const { return axes_; }
  std::uint32_t id() const { return id_; }
  bool extended() const { return extended_; }

  /// Returns false if the frame is rejected; rejected frames are counted.
  bool accepts(const can::Frame& frame) { return !checker_.check(frame); }
  /// Accepts any message counter in the next frame. Called after the node has restarted.
  void restart() { checker_.restart(); }
  const can::E2eChecker& checker() const { return checker_; }
  can::RejectedFrames rejected() const { return can::rejected_frames(message_, checker_); }

 private:
  std::string message_;
  std::uint32_t id_;
  bool extended_;
  can::E2eChecker checker_;
  std::vector<std::size_t> axes_;
};

}  // namespace hystcan::controller
