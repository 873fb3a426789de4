// The conditions that must hold before an axis is driven, and the attempt to clear the amplifier's fault.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

#include "base/words.h"
#include "controller/control/gate.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

/// The conditions for which an axis waits, in the order in which they are met. While one of the conditions up
/// to `sample` is not met, the axis is not driven.
enum class ArmingBlock : std::uint8_t {
  nothing,
  sensor_heartbeat,
  amplifier_heartbeat,
  sensor_operational,
  amplifier_operational,
  clear,             ///< the amplifier's latched fault must be cleared
  amplifier_ready,   ///< the amplifier must report the state ready
  amplifier_output,  ///< the amplifier must report an output within drive_min..drive_max
  amplifier_rest,    ///< the output must be nearly the same in two statuses in a row
  sample,
  enabled,     ///< the amplifier must report the state enabled, or its enable delay must pass
  output,      ///< during the ramp of the start-up: the amplifier's output must reach the drive again
  watchdog,    ///< the amplifier must trip when commands are withheld
  other_axes,  ///< the axes that begin together with this one must be ready
};
constexpr auto words(ArmingBlock) {
  return std::to_array<std::string_view>(
      {"nothing", "a heartbeat of the sensor", "a heartbeat of the amplifier", "the sensor to be operational",
       "the amplifier to be operational", "the amplifier's fault to be cleared",
       "an amplifier status that says ready", "an amplifier output within drive_min..drive_max",
       "an amplifier output at rest", "a sample", "the amplifier to be enabled",
       "the amplifier's output to follow the drive", "the amplifier's watchdog", "the other axes"});
}
constexpr std::string_view to_string(ArmingBlock block) { return word_of(block); }
inline constexpr std::size_t arming_block_count = every<ArmingBlock>().size();

/// A set of conditions for which an axis waits, in the order of `ArmingBlock`. It never contains `nothing`.
class ArmingBlocks {
 public:
  constexpr ArmingBlocks() = default;
  constexpr ArmingBlocks(ArmingBlock one) { add(one); }
  constexpr void add(ArmingBlock one) {
    if (one != ArmingBlock::nothing)
      bits_ = static_cast<std::uint16_t>(bits_ | 1U << static_cast<unsigned>(one));
  }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr ArmingBlock first() const {
    return empty() ? ArmingBlock::nothing : static_cast<ArmingBlock>(std::countr_zero(bits_));
  }
  std::vector<ArmingBlock> members() const;
  friend constexpr bool operator==(ArmingBlocks, ArmingBlocks) = default;

 private:
  std::uint16_t bits_ = 0;
};
static_assert(arming_block_count <= 16,
              "the bits of ArmingBlocks must suffice for all values of ArmingBlock");

/// Returns the conditions of sensor and amplifier that are not met; these are the enumerators of ArmingBlock
/// from `sensor_heartbeat` to `sample`. For each of the two nodes, returns only the first condition that is
/// not met, because the later conditions depend on it. If the amplifier is ready, returns both
/// amplifier_output and amplifier_rest if both are not met. The output may be outside the gate's range by 1 %
/// of this range, because its measurement has an error.
ArmingBlocks arming_blocks_of(const AxisInput& input, const Gate::Config& gate);

/// Tries to clear the amplifier's fault for half a second, starting when the amplifier is operational. If the
/// cause of the fault lasts longer, the user must clear the fault again. Otherwise the axis would be driven
/// without warning when the cause ends.
class ClearAttempt {
 public:
  static constexpr double duration_s = 0.5;

  void begin() { left_s_ = duration_s; }
  /// Called once in each cycle of a waiting axis. Returns true if the command must contain ClearFault.
  bool step(const NodeHealth& health, double dt_s);

 private:
  double left_s_ = 0.0;
};

}  // namespace hystcan::controller
