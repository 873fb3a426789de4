// The frame with the commands of the axes that share it; mostly of one.
//
//   put() by each axis  ->  send()  ->  queue of the interface  ->  wire  ->  echo
//
// One of these frames at most is in the queue: behind a bus that is full, several would all reach the
// amplifier at once, much later. The next one waits here; it goes out when the one before has left, and until
// then a newer one takes its place. A safe one, which enables no amplifier, does not wait.
//
// The echo shows that a frame has left. Where it is lost in the receive queue, the echo of a later SYNC shows
// the same, because the queue keeps their order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "controller/control/supervisor.h"

namespace hystcan::controller {

class CommandFrame {
 public:
  explicit CommandFrame(const can::Layout<can::AmpCommand>& layout);

  /// An axis whose signals are in this message, and whose drive is `safe_drive` while it has no command.
  /// Returns its place among the axes.
  std::size_t add(const can::Layout<can::AmpCommand>& layout, std::size_t axis, double safe_drive);
  /// An axis in the same message that has no commands: `safe_drive` stands in each frame.
  void rest(const can::Layout<can::AmpCommand>& layout, double safe_drive) {
    layout.put({.setpoint = safe_drive}, next_.frame);
  }
  const std::vector<std::size_t>& axes() const { return axes_; }
  std::uint32_t id() const { return next_.frame.id; }
  bool extended() const { return next_.frame.extended; }
  /// True for a sound command on the bus: it comes from another controller. Its counter does not matter: the
  /// amplifier may receive it before our own command with the same counter, and then rejects ours.
  bool is_sound(const can::Frame& frame) {
    return foreign_.check(frame).value_or(can::Rejection::repeated_counter) ==
           can::Rejection::repeated_counter;
  }

  /// A cycle begins: no axis has put its command, and none is answered.
  void begin_cycle();
  /// The axis at `place` has put its command of this cycle.
  bool has(std::size_t place) const { return slots_[place].is_put; }
  /// The commands of this cycle are sent, or would be if the controller were not silent.
  bool is_answered() const { return is_answered_; }
  void end_cycle() { is_answered_ = true; }

  /// Of a bus that reports no echo, no frame ever waits.
  void begin_to_count_echoes() { echoes_ = true; }
  /// The command of the axis at `place`. Empty: its amplifier sleeps, and the safe drive takes the place.
  /// False: the drive does not fit its signal; the safe one takes the place.
  bool put(std::size_t place, const std::optional<AxisCommand>& command, std::uint8_t sync_counter);
  /// Where every axis has put its command in. Nothing is sent if none of the axes has one, or if a safe frame
  /// is on its way and this one would say nothing new. After a hundred such it counts as lost. True: one that
  /// waited never goes out, because this one takes its place.
  bool send(can::Bus& bus);
  /// The bus has carried a frame of ours. `last_sync`: of the SYNC that was queued last.
  void on_echo(const can::Frame& frame, std::uint8_t last_sync, can::Bus& bus);
  /// The bus has lost what was on its way, or may have.
  void forget();

  /// There was a newer one before this one had left: with one in each cycle, it is two cycles old.
  bool is_late() const { return is_late_; }

 private:
  struct Slot {
    can::Layout<can::AmpCommand> layout;
    double safe_drive;
    bool is_put = true;
  };
  struct Composed {
    can::Frame frame;
    std::uint8_t sync_ahead = 0;  ///< counter of the SYNC that was queued last before it
    bool is_safe = true;          ///< enables no amplifier and clears no fault
  };

  bool is_safe_one_on_its_way();
  void hand_over(Composed composed, can::Bus& bus);

  std::vector<Slot> slots_;
  std::vector<std::size_t> axes_;
  can::E2eProtector protector_;
  can::E2eChecker foreign_;
  Composed next_;
  bool is_answered_ = true;
  bool says_something_ = false;  ///< some axis has a command
  bool echoes_ = false;
  std::optional<Composed> queued_;  ///< on its way to the wire
  std::optional<Composed> waiting_;
  bool is_late_ = false;
  unsigned held_back_ = 0;  ///< safe frames, since the last one that was not
};

}  // namespace hystcan::controller
