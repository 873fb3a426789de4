// One cycle of one axis, as it goes to log, CSV and statistics.
#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>

#include "can/scheduler.h"
#include "controller/axis.h"
#include "controller/peer.h"

namespace hystcan::controller {

struct CycleRecord {
  std::uint64_t cycle = 0;
  double time_s = 0.0;  ///< of the SYNC, since start
  std::size_t axis = 0;
  AxisReport report;
  double amplifier_output = 0.0;  ///< last status heard, drive units
  can::Duration turnaround{};     ///< sample heard to command sent
  std::optional<NodeEvent> event{};
};
static_assert(std::is_trivially_copyable_v<CycleRecord>, "records cross threads by plain copying");

}  // namespace hystcan::controller
