// The commands of one axis that the bus has taken and not yet carried. Behind a bus that is full they would
// all reach the amplifier at once, much later.
//
// The echo of a command shows that it has left, and so have all before it: commands of one identifier keep
// their order. An echo that is lost in the receive queue is therefore made up for by the next one.
#pragma once

#include <array>
#include <cstddef>

#include "can/frame.h"

namespace hystcan::controller {

class PendingCommands {
 public:
  /// So many are late: with one command a cycle, the oldest is two cycles old.
  static constexpr std::size_t late = 2;

  /// Of a bus that reports no echo, nothing is ever pending.
  void begin_to_count() { counts_ = true; }
  void add(const can::Frame& command, bool is_safe);
  void confirm(const can::Frame& command);
  /// The bus has lost them, or may have.
  void forget();

  bool are_late() const { return count_ >= late; }
  /// A safe command is on its way, so that another one would say nothing new. After a hundred such answers it
  /// counts as lost.
  bool is_safe_one_on_its_way();

 private:
  static constexpr std::size_t capacity = 8;
  static constexpr unsigned most_answers = 100;

  bool counts_ = false;
  std::array<can::Frame, capacity> commands_{};  ///< the oldest first
  std::size_t count_ = 0;
  bool last_is_safe_ = false;
  unsigned answers_ = 0;
};

}  // namespace hystcan::controller
