// What an axis needs before it is driven: what it lacks of that, and one attempt to clear the amplifier's
// fault.
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

/// What an axis waits for, in the order in which it comes. Up to `sample` it is not driven yet.
enum class ArmingBlock : std::uint8_t {
  nothing,
  sensor_heartbeat,
  amplifier_heartbeat,
  sensor_operational,
  amplifier_operational,
  clear,             ///< of the amplifier's latched fault
  amplifier_ready,   ///< a status that says so
  amplifier_output,  ///< a status whose output is a number within drive_min..drive_max
  amplifier_rest,    ///< two statuses with the same output
  sample,
  enabled,     ///< a status that says so, and the delay of an amplifier that says nothing
  output,      ///< of the amplifier, which differs from the drive
  watchdog,    ///< the amplifier's reaction to withheld commands
  other_axes,  ///< which begin together with this one
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

/// What an axis waits for: a set, in the order of `ArmingBlock`. It never contains `nothing`.
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
static_assert(arming_block_count <= 16, "an ArmingBlocks has a bit for each ArmingBlock");

/// Those up to `sample` that are missing: of each node the first one, which its further ones depend on, and
/// of an amplifier that is ready both output and rest. An output may be beyond the gate's range by the error
/// of its reading, 1 % of the range; the gate limits what is commanded.
ArmingBlocks arming_blocks_of(const AxisInput& input, const Gate::Config& gate);

/// A clear attempts for half a second to clear the amplifier's fault, counted from when the amplifier is
/// operational. A fault whose cause lasts longer needs another clear: the axis would otherwise be driven
/// whenever the cause ends.
class ClearAttempt {
 public:
  static constexpr double duration_s = 0.5;

  void begin() { left_s_ = duration_s; }
  /// Once in each cycle of a waiting axis. Returns whether to command ClearFault.
  bool step(const NodeHealth& health, double dt_s);

 private:
  double left_s_ = 0.0;
};

}  // namespace hystcan::controller
