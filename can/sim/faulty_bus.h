// A bus with injected faults. It wraps any Bus and loses, delays, duplicates, reorders or corrupts frames.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "can/bus.h"

namespace hystcan::can {

enum class BusFault : std::uint8_t {
  lose,
  delay,              ///< the frame comes late by a random time up to the rule's `delay`
  duplicate,          ///< the frame comes twice
  reorder,            ///< the frame comes after the next one of its direction, at most `delay` late
  corrupt_payload,    ///< one bit of the payload is flipped; an empty payload stays
  corrupt_id,         ///< one bit of the identifier is flipped
  corrupt_length,     ///< the frame gets another length, 0..8
  corrupt_kind,       ///< a data frame becomes a remote or FD frame
  corrupt_extension,  ///< an 11-bit identifier becomes a 29-bit one of the same value, or the reverse
};
inline constexpr std::size_t bus_fault_count = 9;

std::string_view to_string(BusFault fault);

/// One fault, its probability, and the frames that it applies to.
struct FaultRule {
  BusFault fault = BusFault::lose;
  double probability = 0.0;    ///< per frame, 0..1
  bool on_receive = true;      ///< frames on their way to the owner
  bool on_transmit = false;    ///< frames that the owner sends
  std::optional<Filter> only;  ///< only frames with this identifier and type; empty: every frame
  Duration delay{std::chrono::milliseconds(1)};
};

struct FaultyBusConfig {
  std::uint64_t seed = 1;
  std::vector<FaultRule> rules;
};

/// The bus tries the rules in their order on each frame. Several rules may change one frame, until one rule
/// loses or holds it. A frame to which no rule applies passes unchanged and at once. The bus holds at most
/// `held_frames` frames; after that a frame passes at once. Held frames are lost when the bus is destroyed.
/// State and counters are those of the wrapped bus.
class FaultyBus final : public Bus {
 public:
  static constexpr std::size_t held_frames = 32;

  /// Throws std::invalid_argument if a probability is not within 0..1 or a delay is not above 0.
  FaultyBus(std::unique_ptr<Bus> within, Scheduler& scheduler, FaultyBusConfig config);

  /// Replaces the rules from the next frame on; held frames stay held. Throws like the constructor.
  void set_rules(std::vector<FaultRule> rules);

  /// Returns true also for a frame that is lost or held: it counts as sent.
  bool send(const Frame& frame) override;
  void on_frame(FrameHandler handler) override { handler_ = std::move(handler); }
  bool on_sent(FrameHandler handler) override { return within_->on_sent(std::move(handler)); }
  void on_state(StateHandler handler) override { within_->on_state(std::move(handler)); }
  BusState state() const override { return within_->state(); }
  std::optional<ErrorCounters> error_counters() const override { return within_->error_counters(); }
  const BusCounters& counters() const override { return within_->counters(); }

  /// Number of faults injected so far.
  std::uint64_t injected(BusFault fault) const { return injected_[static_cast<std::size_t>(fault)]; }

 private:
  enum class Direction : std::uint8_t { receive, transmit };
  struct Held {
    Frame frame;
    Direction direction = Direction::receive;
    bool taken = false;
    bool until_next = false;
    std::unique_ptr<Timer> timer;
  };

  bool pass(const Frame& frame, Direction direction, Time received);
  bool apply_rules(Frame frame, Direction direction, Time received);
  bool deliver(const Frame& frame, Direction direction, Time received);
  bool applies(const FaultRule& rule, const Frame& frame, Direction direction);
  bool hold(const Frame& frame, Direction direction, const FaultRule& rule);
  void release(Held& held);
  void release_reordered(Direction direction);
  bool corrupt(Frame& frame, BusFault fault);
  bool flip_payload_bit(Frame& frame);
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  unsigned below(unsigned bound) { return static_cast<unsigned>(uniform() * bound); }
  void count(BusFault fault) { ++injected_[static_cast<std::size_t>(fault)]; }

  std::unique_ptr<Bus> within_;
  Scheduler& scheduler_;
  FaultyBusConfig config_;
  std::mt19937_64 random_;
  FrameHandler handler_;
  std::array<Held, held_frames> held_;
  std::size_t held_count_ = 0;
  std::array<std::uint64_t, bus_fault_count> injected_{};
};

}  // namespace hystcan::can
