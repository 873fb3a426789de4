// The frame with the command of one axis, or of several axes that share it.
//
//   put() by each axis  ->  send()  ->  queue of the interface  ->  wire  ->  echo
//
// At most one of these frames is in the queue of the interface. If several frames waited there for a busy
// bus, they would all reach the amplifier together and much too late. The next frame therefore waits in this
// class. It is queued when the frame before it has left the interface; until then, a newer frame replaces it.
// A safe frame, which enables no amplifier, never waits.
//
// An echo of a frame shows that the frame has left the interface. If the receive queue loses this echo, the
// echo of a later SYNC shows the same, because the queue keeps the order.
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

  /// Adds an axis whose signals are in this message. If the frame is sent without a command of this axis, it
  /// contains `safe_drive` as the drive. Returns the place of the axis in the frame.
  std::size_t add(const can::Layout<can::AmpCommand>& layout, std::size_t axis, double safe_drive);
  /// Adds an axis that never has commands, but whose signals are in this message: each frame contains
  /// `safe_drive` for it.
  void rest(const can::Layout<can::AmpCommand>& layout, double safe_drive) {
    layout.put({.setpoint = safe_drive}, next_.frame);
  }
  const std::vector<std::size_t>& axes() const { return axes_; }
  std::uint32_t id() const { return next_.frame.id; }
  bool extended() const { return next_.frame.extended; }
  /// True if `frame` is a valid command; on the bus, such a frame is from another controller. The counter of
  /// the frame is not checked: the amplifier may receive the foreign command before our own command with the
  /// same counter, and then reject ours.
  bool is_sound(const can::Frame& frame) {
    return foreign_.check(frame).value_or(can::Rejection::repeated_counter) ==
           can::Rejection::repeated_counter;
  }

  /// Begins a cycle: no axis has put its command yet, and the frame of this cycle is not sent yet.
  void begin_cycle();
  /// True if the axis at `place` has put its command of this cycle.
  bool has(std::size_t place) const { return slots_[place].is_put; }
  /// True if the commands of this cycle have been sent, or would have been sent if the controller were not
  /// silent.
  bool is_answered() const { return is_answered_; }
  void end_cycle() { is_answered_ = true; }

  /// Makes frames wait for the echo of the frame before. Called if the bus reports echoes; without echoes, no
  /// frame ever waits.
  void begin_to_count_echoes() { echoes_ = true; }
  /// Puts the command of the axis at `place` into the frame. `nullopt`: the amplifier is not operational, and
  /// the frame contains the safe drive. Returns false if the drive is outside the range of its signal; the
  /// frame then contains the safe drive too.
  bool put(std::size_t place, const std::optional<AxisCommand>& command, std::uint8_t sync_counter);
  /// Called after every axis has put its command. Sends the frame, unless no axis has put a command that may
  /// be sent. A safe frame enables no amplifier and clears no fault. It is not sent while another safe frame
  /// is still in the queue of the interface; after a hundred safe frames that were not sent, the one in the
  /// queue counts as lost. Returns true if this frame replaces a waiting frame, which is then never sent.
  bool send(can::Bus& bus);
  /// Queues the waiting frame if the echo shows that the frame before it has left the interface. Called for
  /// the echo of each of our frames. `last_sync`: counter of the last SYNC that was queued.
  void on_echo(const can::Frame& frame, std::uint8_t last_sync, can::Bus& bus);
  /// Discards the queued frame and the waiting frame. Called when the bus has lost its frames, or may have
  /// lost them.
  void forget();

  /// True if the previous frame had not left the interface when the last frame was sent. The commands are
  /// then late.
  bool is_late() const { return is_late_; }

 private:
  struct Slot {
    can::Layout<can::AmpCommand> layout;
    double safe_drive;
    bool is_put = true;
  };
  struct Composed {
    can::Frame frame;
    std::uint8_t sync_ahead = 0;  ///< counter of the last SYNC that was queued before this frame
    bool is_safe = true;          ///< true: the frame enables no amplifier and clears no fault
  };

  bool is_safe_one_on_its_way();
  void hand_over(Composed composed, can::Bus& bus);

  std::vector<Slot> slots_;
  std::vector<std::size_t> axes_;
  can::E2eProtector protector_;
  can::E2eChecker foreign_;
  Composed next_;
  bool is_answered_ = true;
  bool says_something_ = false;  ///< true: at least one axis has put a command in this cycle
  bool echoes_ = false;
  std::optional<Composed> queued_;  ///< frame on its way to the wire, if echoes are reported
  std::optional<Composed> waiting_;
  bool is_late_ = false;
  /// Number of safe frames (`is_safe`) since the last sent frame that were not sent, because another safe
  /// frame was still in the queue of the interface.
  unsigned held_back_ = 0;
};

}  // namespace hystcan::controller
