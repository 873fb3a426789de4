// A simulated node's connection to the bus, with faults that begin and end. The node does not detect the
// faults. A frame passes through them in this order:
//
//   node  ->  wrong value, status, counter, CRC  ->  late, out of order
//         ->  lost, doubled, wrong length, wrong identifier type  ->  bus
//
// After a change of value, status or counter the CRC is computed again, so that the receiver accepts the
// frame and gets the wrong content. Only the fault wrong_crc changes the CRC itself, as the last step. Frames
// that are still held back when a fault ends are dropped, so that no outdated frame follows.
//
// Each axis of a node is one channel of the connection. Either all channels share one message, or each
// channel has its own message.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "twin/fault.h"

namespace hystcan::twin {

/// The message that a node sends for an axis. The faults use this class to change the signals, the counter
/// and the CRC of the message.
class SentMessage {
 public:
  SentMessage(const can::Message& message, const can::MessageMap& map, std::string_view value_role,
              std::string_view value_unit);

  bool is(const can::Frame& frame) const {
    return frame.id == filter_.id && frame.extended == filter_.extended;
  }
  std::int64_t value(const can::Frame& frame) const {
    return value_ ? value_->unpack_raw(frame.payload()) : 0;
  }
  std::int64_t counter(const can::Frame& frame) const;

  double physical(const can::Frame& frame) const {
    return value_ ? step_.to_ours(value_->unpack(frame.payload())) : 0.0;
  }

  void put_value(can::Frame& frame, std::int64_t raw) const;
  /// Writes `value`, or the nearest value that the signal can represent, into the frame: as the position of a
  /// sample, or as the output in a status.
  void put_physical(can::Frame& frame, double value) const;
  void put_bad_status(can::Frame& frame) const;
  void put_counter(can::Frame& frame, std::int64_t raw) const;
  /// Computes the CRC of the frame again and writes it into the frame.
  void seal(can::Frame& frame) const;
  void corrupt_crc(can::Frame& frame) const;

 private:
  can::Filter filter_;
  std::optional<can::SignalCodec> value_;
  can::DecimalStep step_{};
  std::optional<can::SignalCodec> status_;
  can::Protection protection_;
};

/// Returns the message that the node sends for this axis: the sensor's sample or the amplifier's status.
/// Returns nullopt if the node sends no such message.
std::optional<SentMessage> sent_by(Node node, const can::Database& database, const can::AxisWire& wire);

class FaultyConnection final : public can::Bus {
 public:
  struct Config {
    std::uint8_t node = 0;
    std::optional<can::Filter> obeys{};  ///< identifier of the command message; only for an amplifier's node
    std::uint64_t seed = 1;
  };

  FaultyConnection(std::unique_ptr<can::Bus> within, can::Scheduler& scheduler, const Config& config);

  /// Adds a channel. `sends` is the message of the channel; nullopt if the channel sends none.
  void add_channel(std::optional<SentMessage> sends) { channels_.push_back({.sends = sends}); }

  /// Begins a fault; a fault that is already active continues with the new value. A kind that acts on the
  /// plant or inside the node has no effect here. `channel` is only used if acts_on_one_axis(kind).
  void begin(Fault kind, double value, std::size_t channel = 0);
  void end(Fault kind, std::size_t channel = 0);

  bool send(const can::Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  bool on_sent(FrameHandler handler) override { return within_->on_sent(std::move(handler)); }
  void on_state(StateHandler handler) override { within_->on_state(std::move(handler)); }
  can::BusState state() const override { return within_->state(); }
  std::optional<can::ErrorCounters> error_counters() const override { return within_->error_counters(); }
  const can::BusCounters& counters() const override { return within_->counters(); }

 private:
  /// Capacity for frames that the fault `late` holds back: its maximum delay (16 cycles) plus the present
  /// frame.
  static constexpr std::size_t held_frames = 17;

  /// For each kind of fault its value; nullopt if the fault is not active.
  using ActiveFaults = std::array<std::optional<double>, fault_count>;
  struct Channel {
    std::optional<SentMessage> sends{};
    ActiveFaults on{};  ///< active faults that act only on this axis
    std::optional<std::int64_t> frozen_value{};
    std::optional<double> gain_from{};  ///< position in the first frame after sensor_gain began; the fault
                                        ///< multiplies the motion from this position
    // The members below belong to the message `sends`, not to one axis. If several channels send the same
    // message, only the first of these channels uses the members.
    std::optional<std::int64_t> frozen_counter{};
    std::optional<can::Frame> overtaken{};
    std::array<can::Frame, held_frames> late{};
    std::size_t oldest_late = 0;
    std::size_t late_count = 0;
  };

  std::optional<double>& value(Fault kind, std::size_t channel) {
    return (acts_on_one_axis(kind) ? channels_[channel].on : on_)[static_cast<std::size_t>(kind)];
  }
  bool is_on(Fault kind) const { return on_[static_cast<std::size_t>(kind)].has_value(); }
  double value_of(Fault kind) const { return *on_[static_cast<std::size_t>(kind)]; }
  /// Returns the first channel that sends this frame's message; null if no channel sends it.
  Channel* channel_of(const can::Frame& frame);
  void note_faults();
  bool misses(const can::Frame& frame);
  bool loses(const can::Frame& frame);
  bool put(can::Frame frame);
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  void corrupt(can::Frame& frame, Channel& first);
  static void change_value(can::Frame& frame, Channel& channel);
  bool pass_in_order(const can::Frame& frame, Channel& first);
  bool pass_late(const can::Frame& frame, Channel& first);
  void babble();

  std::unique_ptr<can::Bus> within_;
  bool is_faulty_ = false;  ///< true while at least one fault is active
  can::Scheduler& scheduler_;
  Config config_;
  std::mt19937_64 random_;
  std::vector<Channel> channels_;
  ActiveFaults on_{};  ///< active faults that act on the whole node, not on one channel
  std::unique_ptr<can::Timer> babbles_;
};

}  // namespace hystcan::twin
