#include "node/analogue/card_output.h"

#include <string_view>
#include <utility>

#include "node/analogue/axis_check.h"

namespace hystcan::node {
namespace {

/// Inverts a line, so that low means active.
class Inverted final : public LineOutput {
 public:
  explicit Inverted(std::unique_ptr<LineOutput> line) : line_(std::move(line)) {}
  bool write(bool on) override { return line_->write(!on); }

 private:
  std::unique_ptr<LineOutput> line_;
};

std::unique_ptr<LineOutput> line_output(Card& card, const std::optional<LineConfig>& config,
                                        std::string_view key) {
  if (!config) return nullptr;
  auto line = opened(key, [&] { return card.line_output(config->place); });
  if (config->active == ActiveLevel::high) return line;
  return std::make_unique<Inverted>(std::move(line));
}

}  // namespace

CardOutput::CardOutput(const AnalogueConfig& config, const DriveRange& drives, Card& card)
    : config_(config),
      drives_(drives),
      output_(opened("drive_output", [&] { return card.output(config.drive_output); })),
      enable_(line_output(card, config.enable_line, "enable_line")),
      charge_pump_(line_output(card, config.charge_pump_line, "charge_pump_line")),
      written_(drives.safe) {
  if (config.output_input)
    monitor_ = opened("output_input", [&] { return card.input(*config.output_input); });
  if (config.interlock_line)
    interlock_ = opened("interlock_line", [&] { return card.line_input(config.interlock_line->place); });
  check_drives(config, drives, output_->range());
}

bool CardOutput::reaches(double drive) const { return drive >= drives_.min && drive <= drives_.max; }

void CardOutput::switch_on() {
  is_driven_ = true;
  if (enable_ && !enable_->write(true)) has_failed_ = true;
}

/// Writes the drive. If the guard has made the output safe since the last call of works(), makes the output
/// safe again, and the next works() returns false.
void CardOutput::go_to(double drive, can::Time, can::Duration) {
  is_driven_ = true;
  write(drive);
  if (!is_overruled()) return;
  has_failed_ = true;
  make_safe();
}

void CardOutput::leave(WatchdogAction, can::Time) { make_safe(); }

bool CardOutput::make_safe() {
  is_driven_ = false;
  const bool is_written = write(drives_.safe);
  const bool is_off = !enable_ || enable_->write(false);
  has_failed_ |= !is_off;
  return is_written && is_off;
}

double CardOutput::output(can::Time) {
  if (!monitor_) return written_;
  const std::optional<double> volts = monitor_->read();
  has_failed_ |= !volts;
  return volts.value_or(config_.volts_per_drive * written_) / config_.volts_per_drive;
}

bool CardOutput::is_overruled() {
  if (takeovers_ == nullptr) return false;
  const unsigned known = std::exchange(known_takeovers_, *takeovers_);
  return known != known_takeovers_;
}

bool CardOutput::works() {
  if (is_overruled()) has_failed_ |= is_driven_;
  if (charge_pump_) has_failed_ |= !charge_pump_->write(pump_is_high_ = !pump_is_high_);
  if (!std::exchange(has_failed_, false)) return !interlock_is_active();
  write(drives_.safe);
  return false;
}

bool CardOutput::interlock_is_active() {
  if (!interlock_) return false;
  const std::optional<bool> is_high = interlock_->read();
  return !is_high || *is_high == (config_.interlock_line->active == ActiveLevel::high);
}

bool CardOutput::write(double drive) {
  written_ = drive;
  const bool is_written = output_->write(config_.volts_per_drive * drive);
  has_failed_ |= !is_written;
  return is_written;
}

}  // namespace hystcan::node
