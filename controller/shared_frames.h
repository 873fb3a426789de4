// The frames of a controller's axes: commands, samples and statuses. Axes whose signals are in the same
// message share its frame.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "controller/command_frame.h"
#include "controller/received_frame.h"
#include "controller/sample_frame.h"

namespace hystcan::controller {

struct SharedFrames {
  std::vector<std::unique_ptr<CommandFrame>> commands;
  std::vector<std::unique_ptr<SampleFrame>> samples;
  std::vector<std::unique_ptr<ReceivedFrame>> statuses;
};

/// Returns the frame object of this message; null if no axis has a signal in the message yet.
template <class Frame, class Payload>
Frame* find_frame(const std::vector<std::unique_ptr<Frame>>& frames, const can::Layout<Payload>& layout) {
  const auto found = std::ranges::find_if(frames, [&](const auto& frame) {
    return frame->id() == layout.id() && frame->extended() == layout.extended();
  });
  return found == frames.end() ? nullptr : found->get();
}

/// Returns the frame object of this message. Creates it if there is none.
template <class Frame, class Payload>
Frame& make_frame(std::vector<std::unique_ptr<Frame>>& frames, const can::Layout<Payload>& layout,
                  const auto&... rest) {
  if (Frame* frame = find_frame(frames, layout)) return *frame;
  return *frames.emplace_back(std::make_unique<Frame>(layout, rest...));
}

}  // namespace hystcan::controller
