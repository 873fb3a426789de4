#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hystcan::controller {

/// The reasons for which a running controller refuses a request. A refused request changes nothing.
enum class Refusal : std::uint8_t {
  no_such_axis,
  faulted,  ///< refuses enable: the fault must be cleared first
  enabled_already,
  not_enabled,
  still_ramping,  ///< refuses clear: the drive has not reached its safe value yet
  no_fault_to_clear,
  not_tracking,  ///< refuses a live setpoint: the axis does not track
  position_out_of_range,
  open_loop,           ///< refuses a new tuning: the axis has no closed loop
  drive_out_of_range,  ///< refuses a new tuning: the present drive is outside the new limits
  too_many_requests,
};
inline constexpr std::size_t refusal_count = static_cast<std::size_t>(Refusal::too_many_requests) + 1;

/// Returns the name of the enumerator, for programs that read an answer.
std::string_view name_of(Refusal refusal);
/// Returns a sentence that tells the user why the request is refused.
std::string_view to_string(Refusal refusal);

/// True if the request is refused only because the axis is already in the requested state.
inline bool is_needless(Refusal refusal) {
  return refusal == Refusal::enabled_already || refusal == Refusal::no_fault_to_clear;
}

}  // namespace hystcan::controller
