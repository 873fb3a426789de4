#include "controller/control/arming.h"

#include <algorithm>

namespace hystcan::controller {
namespace {

constexpr double output_error = 0.01;  // measurement error of an output, as a share of the drive's range

bool is_plausible(double output, const Gate::Config& gate) {
  const double error = output_error * (gate.drive_max - gate.drive_min);
  // If the output is NaN, the comparison is false: the output is not plausible.
  return output >= gate.drive_min - error && output <= gate.drive_max + error;
}

ArmingBlock block_of_sensor(const AxisInput& input) {
  if (!input.health.sensor_alive) return ArmingBlock::sensor_heartbeat;
  if (!input.health.sensor_operational) return ArmingBlock::sensor_operational;
  return input.position_um ? ArmingBlock::nothing : ArmingBlock::sample;
}

ArmingBlocks blocks_of_amplifier(const NodeHealth& health, const Gate::Config& gate) {
  if (!health.amplifier_alive) return ArmingBlock::amplifier_heartbeat;
  if (!health.amplifier_operational) return ArmingBlock::amplifier_operational;
  if (health.amplifier_fault) return ArmingBlock::clear;
  if (!health.amplifier_ready) return ArmingBlock::amplifier_ready;
  ArmingBlocks blocks;
  if (!is_plausible(health.amplifier_output, gate)) blocks.add(ArmingBlock::amplifier_output);
  if (health.amplifier_moves) blocks.add(ArmingBlock::amplifier_rest);
  return blocks;
}

}  // namespace

std::vector<ArmingBlock> ArmingBlocks::members() const {
  std::vector<ArmingBlock> members;
  for (std::size_t i = 1; i < arming_block_count; ++i)
    if ((bits_ >> i & 1U) != 0) members.push_back(static_cast<ArmingBlock>(i));
  return members;
}

ArmingBlocks arming_blocks_of(const AxisInput& input, const Gate::Config& gate) {
  ArmingBlocks blocks = blocks_of_amplifier(input.health, gate);
  blocks.add(block_of_sensor(input));
  return blocks;
}

bool ClearAttempt::step(const NodeHealth& health, double dt_s) {
  const bool goes_on = left_s_ > 0.0;
  if (health.amplifier_operational) left_s_ = std::max(0.0, left_s_ - dt_s);
  return goes_on && health.amplifier_fault;
}

}  // namespace hystcan::controller
