#include "controller/command_frame.h"

#include <utility>

namespace hystcan::controller {

CommandFrame::CommandFrame(const can::Layout<can::AmpCommand>& layout)
    : protector_(layout.protection()), foreign_(layout.checker()), next_{.frame = layout.frame()} {}

std::size_t CommandFrame::add(const can::Layout<can::AmpCommand>& layout, std::size_t axis,
                              double safe_drive) {
  slots_.push_back({.layout = layout, .safe_drive = safe_drive});
  axes_.push_back(axis);
  return slots_.size() - 1;
}

void CommandFrame::begin_cycle() {
  is_answered_ = false;
  for (Slot& slot : slots_) slot.is_put = false;
}

bool CommandFrame::put(std::size_t place, const std::optional<AxisCommand>& command,
                       std::uint8_t sync_counter) {
  Slot& slot = slots_[place];
  slot.is_put = true;
  const can::AmpCommand safe{.setpoint = slot.safe_drive, .sync_counter = sync_counter};
  can::AmpCommand said = safe;
  next_.sync_ahead = sync_counter;
  if (command) {
    said.setpoint = command->drive;
    said.enable = command->enable;
    said.clear_fault = command->clear_fault;
  }
  const bool fits = slot.layout.put(said, next_.frame);
  if (!fits) slot.layout.put(safe, next_.frame);
  says_something_ |= command && fits && !command->withheld;
  next_.is_safe &= !fits || (!said.enable && !said.clear_fault);
  return fits;
}

bool CommandFrame::send(can::Bus& bus) {
  const bool says_something = std::exchange(says_something_, false);
  const bool is_safe = std::exchange(next_.is_safe, true);
  if (!says_something || (is_safe && is_safe_one_on_its_way())) return false;
  held_back_ = 0;
  const Composed composed{.frame = next_.frame, .sync_ahead = next_.sync_ahead, .is_safe = is_safe};
  is_late_ = queued_.has_value();
  const bool replaces = std::exchange(waiting_, std::nullopt).has_value();
  if (is_late_ && !is_safe)
    waiting_ = composed;
  else
    hand_over(composed, bus);
  return replaces;
}

void CommandFrame::on_echo(const can::Frame& frame, std::uint8_t last_sync, can::Bus& bus) {
  if (!queued_) return;
  const auto counter = can::parse_sync(frame);
  const int ahead = counter ? can::syncs_after(queued_->sync_ahead, *counter) : 0;
  const bool is_later_sync = ahead != 0 && ahead < can::sync_counter_max / 2;
  can::Frame heard = frame;
  heard.fd_flags = queued_->frame.fd_flags;  // ESI does not count: an error-passive interface sets it
  if (!is_later_sync && heard != queued_->frame) return;
  auto next = std::exchange(waiting_, std::nullopt);
  forget();
  if (!next) return;
  next->sync_ahead = last_sync;
  hand_over(*next, bus);
}

void CommandFrame::forget() {
  queued_.reset();
  waiting_.reset();
  is_late_ = false;
}

bool CommandFrame::is_safe_one_on_its_way() {
  constexpr unsigned most = 100;
  if (!queued_ || !queued_->is_safe) return false;
  if (++held_back_ <= most) return true;
  forget();
  return false;
}

/// Queues the frame. The message counter in the frames counts only the frames that are queued.
void CommandFrame::hand_over(Composed composed, can::Bus& bus) {
  protector_.seal(composed.frame);
  if (bus.send(composed.frame) && echoes_) queued_ = composed;
}

}  // namespace hystcan::controller
