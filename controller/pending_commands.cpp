#include "controller/pending_commands.h"

#include <algorithm>

namespace hystcan::controller {

void PendingCommands::add(const can::Frame& command, bool is_safe) {
  if (!counts_) return;
  if (count_ == capacity) {
    std::shift_left(commands_.begin(), commands_.end(), 1);
    --count_;
  }
  commands_[count_++] = command;
  last_is_safe_ = is_safe;
  answers_ = 0;
}

void PendingCommands::confirm(const can::Frame& command) {
  const auto end = commands_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto found = std::find(commands_.begin(), end, command);
  if (found == end) return;
  const auto left = std::distance(commands_.begin(), found) + 1;
  std::shift_left(commands_.begin(), end, left);
  count_ -= static_cast<std::size_t>(left);
}

void PendingCommands::forget() { count_ = 0; }

bool PendingCommands::is_safe_one_on_its_way() {
  if (count_ == 0 || !last_is_safe_) return false;
  if (++answers_ <= most_answers) return true;
  forget();
  return false;
}

}  // namespace hystcan::controller
