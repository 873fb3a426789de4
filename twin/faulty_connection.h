// A node's connection to the bus, at which faults can begin and end. The node itself does not notice them.
//
//   node  ->  wrong value, status, counter, CRC  ->  late, out of order
//         ->  lost, doubled, wrong length, wrong kind of identifier  ->  bus
//
// After a change of value or status the CRC is computed again, with the frame's own counter, so that only
// the value is wrong. A wrong CRC or a frozen counter is then applied to the protected frame. Frames that
// are held back when a fault ends are dropped: no stale frame follows.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>

#include "can/bus.h"
#include "can/protocol/protocol.h"
#include "twin/fault.h"

namespace hystcan::twin {

/// The message that a node sends for its axis: where its value and its protection are, as faults need it.
class SentMessage {
 public:
  SentMessage(const can::Message& message, const can::MessageMap& map, std::string_view value_role,
              std::string_view value_unit);

  can::Filter filter() const { return filter_; }
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
  /// Puts the nearest value that the signal can carry.
  void put_physical(can::Frame& frame, double value) const;
  void put_bad_status(can::Frame& frame) const;
  void put_counter(can::Frame& frame, std::int64_t raw) const;
  /// Computes the CRC of the frame as it is now.
  void seal(can::Frame& frame) const;
  void corrupt_crc(can::Frame& frame) const;

 private:
  can::Filter filter_;
  std::optional<can::SignalCodec> value_;
  can::DecimalStep step_{};
  std::optional<can::SignalCodec> status_;
  can::Protection protection_;
};

/// The sensor's sample or the amplifier's status; empty where the node sends none.
std::optional<SentMessage> sent_by(Node node, const can::Database& database, const can::AxisWire& wire);

class FaultyConnection final : public can::Bus {
 public:
  struct Config {
    std::uint8_t node = 0;
    std::optional<SentMessage> sends{};
    std::optional<can::Filter> obeys{};  ///< the command, where the node is an amplifier
    std::uint64_t seed = 1;
  };

  FaultyConnection(std::unique_ptr<can::Bus> within, can::Scheduler& scheduler, const Config& config);

  /// Kinds that act on the plant or the node itself change nothing here. An active fault continues with the
  /// new value.
  void begin(Fault kind, double value);
  void end(Fault kind);

  bool send(const can::Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  bool on_sent(FrameHandler handler) override { return within_->on_sent(std::move(handler)); }
  void on_state(StateHandler handler) override { within_->on_state(std::move(handler)); }
  can::BusState state() const override { return within_->state(); }
  std::optional<can::ErrorCounters> error_counters() const override { return within_->error_counters(); }
  const can::BusCounters& counters() const override { return within_->counters(); }

 private:
  static constexpr std::size_t held_frames = 17;  ///< traits(Fault::late).highest and the present one

  bool is_on(Fault kind) const { return on_[static_cast<std::size_t>(kind)].has_value(); }
  double value_of(Fault kind) const { return *on_[static_cast<std::size_t>(kind)]; }
  bool is_message(const can::Frame& frame) const { return config_.sends && config_.sends->is(frame); }
  void find_changes();
  bool misses(const can::Frame& frame);
  bool loses(const can::Frame& frame) const;
  bool put(can::Frame frame);
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  void corrupt(can::Frame& frame);
  bool pass_in_order(const can::Frame& frame);
  bool pass_late(const can::Frame& frame);
  void babble();

  std::unique_ptr<can::Bus> within_;
  can::Scheduler& scheduler_;
  Config config_;
  std::mt19937_64 random_;
  std::array<std::optional<double>, fault_count> on_{};  ///< values of the active faults
  bool corrupts_ = false;                                ///< an active fault changes the sent frames
  std::optional<std::int64_t> frozen_value_;
  std::optional<std::int64_t> frozen_counter_;
  std::optional<double> gain_from_;  ///< value in the first frame of sensor_gain
  std::optional<can::Frame> overtaken_;
  std::array<can::Frame, held_frames> late_{};
  std::size_t oldest_late_ = 0;
  std::size_t late_count_ = 0;
  std::unique_ptr<can::Timer> babbles_;
};

}  // namespace hystcan::twin
