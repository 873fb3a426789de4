// One cycle of one axis: the input of log, CSV, black box and statistics.
#pragma once

#include <cstdint>
#include <optional>
#include <type_traits>

#include "can/scheduler.h"
#include "controller/control/axis.h"
#include "controller/remote_node.h"

namespace hystcan::controller {

struct CycleCounters {
  std::uint64_t cycles = 0;
  std::uint64_t missed_cycles = 0;    ///< SYNCs left out, because this computer was too slow
  std::uint64_t missing_samples = 0;  ///< cycles of an axis in use without a sample in time
  std::uint64_t late_samples = 0;     ///< samples that came after their cycle
};

/// Times within a cycle, measured from its SYNC.
struct CyclePhases {
  can::Duration period{};        ///< from the last SYNC to this one
  can::Duration lateness{};      ///< of the SYNC, after its deadline
  can::Duration sample_heard{};  ///< by the kernel's timestamp; zero where no sample came
  can::Duration command_sent{};
  can::Duration execution{};  ///< of the axis's step
};

struct CycleRecord {
  std::uint64_t cycle = 0;
  double time_s = 0.0;  ///< of the SYNC, since start
  std::size_t axis = 0;
  AxisReport report;
  double amplifier_output = 0.0;  ///< last received status, drive units
  can::Duration turnaround{};     ///< from the received sample to the sent command
  CyclePhases phases{};
  CycleCounters counters{};  ///< of the controller, at the time of the record
  std::optional<NodeEvent> event{};
};
static_assert(std::is_trivially_copyable_v<CycleRecord>, "records cross threads by plain copying");

}  // namespace hystcan::controller
