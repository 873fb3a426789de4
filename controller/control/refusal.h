#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hystcan::controller {

/// Reason why a running controller refuses a request. A refused request changes nothing.
enum class Refusal : std::uint8_t {
  no_such_axis,
  faulted,  ///< an enable needs a clear before it
  enabled_already,
  not_enabled,
  still_ramping,  ///< a clear before the drive has reached its safe value
  no_fault_to_clear,
  not_tracking,  ///< a live setpoint needs an axis that tracks
  position_out_of_range,
  open_loop,           ///< a new tuning needs a closed loop
  drive_out_of_range,  ///< the present drive is outside the new limits
  too_many_requests,
};
inline constexpr std::size_t refusal_count = static_cast<std::size_t>(Refusal::too_many_requests) + 1;

/// The enumerator's name, for programs.
std::string_view name_of(Refusal refusal);
/// The sentence for the user.
std::string_view to_string(Refusal refusal);

/// The axis already is in the state that was requested.
inline bool is_needless(Refusal refusal) {
  return refusal == Refusal::enabled_already || refusal == Refusal::no_fault_to_clear;
}

}  // namespace hystcan::controller
