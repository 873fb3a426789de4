#include "controller/setpoint_receiver.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <utility>

namespace hystcan::controller {

std::string describe(const SetpointCounters& counters) {
  if (counters.taken + counters.refused() == 0) return {};
  std::string text = fmt::format("{} live setpoints accepted", counters.taken);
  const std::array<std::pair<std::uint64_t, const char*>, 3> reasons{
      {{counters.not_tracking, "not tracking"},
       {counters.out_of_range, "out of range"},
       {counters.unknown_mode, "unknown mode"}}};
  const char* before = ", refused: ";
  for (const auto& [count, reason] : reasons)
    if (count > 0) text += fmt::format("{}{} {}", std::exchange(before, ", "), count, reason);
  return text;
}

void SetpointReceiver::on_frame(const can::Frame& frame, Axis& axis) {
  const auto setpoint = decode_(frame);
  if (!setpoint) return;
  if (setpoint->mode > can::setpoint_mode::go_to) {
    ++counters_.unknown_mode;
    return;
  }
  const std::optional<Refusal> refusal =
      setpoint->mode == can::setpoint_mode::go_to ? axis.go_to(setpoint->position_um) : axis.resume();
  if (!refusal) ++counters_.taken;
  if (refusal == Refusal::not_tracking) ++counters_.not_tracking;
  if (refusal == Refusal::position_out_of_range) ++counters_.out_of_range;
}

}  // namespace hystcan::controller
