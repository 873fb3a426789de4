// The layout of one message: which signal of the DBC has which role. A role is the purpose of a value, such
// as `setpoint`. The constructor finds the signal of each role with the names in the configuration.
//
// A `Payload` is a struct with the values of one message. It lists its roles in fields():
//
//   Field{role, name of the signal in the standard frames, member of the struct, quantity}
//
// Layout converts between a Payload and a frame. "Our unit" is the unit of the member:
//
//   encode   our unit -> unit of the DBC -> raw bits;   a role without a signal is left out
//   decode   raw bits -> unit of the DBC -> our unit;   a role without a signal has the value in `absent`
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/signal_codec.h"
#include "can/frame.h"
#include "can/protocol/e2e.h"

namespace hystcan::can {

/// State of an amplifier; the numbers are the values of the signal State in the standard frames.
enum class AmpState : std::uint8_t { off = 0, ready = 1, enabled = 2, fault = 3 };

enum class Integrity : std::uint8_t { none, counter, counter_crc };
constexpr auto words(Integrity) {
  return std::to_array<std::string_view>({"none", "counter", "counter+crc"});
}

/// For each state of an amplifier, the raw values of the state signal that mean this state.
struct StateValues {
  std::vector<std::int64_t> off{0};
  std::vector<std::int64_t> ready{1};
  std::vector<std::int64_t> enabled{2};
  std::vector<std::int64_t> fault{3};

  /// Returns the state that a raw value means: `off` for a value in no list; for a value in several lists,
  /// the last of them in the order off, ready, enabled, fault.
  AmpState state(std::int64_t raw) const;
  /// Returns a raw value that means this state: the first value in the list of the state. If this list is
  /// empty, returns the first value of `off`; if `off` is empty too, 0.
  std::int64_t raw(AmpState state) const;
};

/// The configured names of one message: its name in the DBC, and the signal of each role. A role is the
/// purpose of a value, such as `setpoint`.
struct MessageMap {
  std::string message;
  /// Signal name of each role, such as `setpoint`. The value of a role that is not in this map is not sent.
  std::map<std::string, std::string, std::less<>> signals{};
  Integrity integrity = Integrity::counter_crc;
  std::string counter = "Counter";
  std::string crc = "Crc";
  Crc polynomial = Crc::sae_j1850;
  DataId data_id{};
  StateValues states{};

  bool carries(std::string_view role) const { return signals.contains(role); }
};

/// The frames of one axis that the user defines instead of the standard frames. If there is no status
/// message, the controller does not read the status of the amplifier.
struct AxisFrames {
  MessageMap command;
  std::optional<MessageMap> status{};
  MessageMap sample;
};

/// Converts values between the unit of a signal in the DBC ("theirs") and the unit in this program ("ours").
/// The two units differ only by a decimal prefix, such as mV and V, nm and um, mA and A:
///
///   ours = theirs * 10^n,   n = exponent of the DBC unit's prefix - exponent of our unit's prefix
///
/// The conversion rounds only once, because a double represents the whole number 10^|n| exactly. A value that
/// is converted to the other unit and back differs by at most one or two last bits, far below the resolution
/// of any signal.
class DecimalStep {
 public:
  double to_ours(double theirs) const { return theirs * multiplier_ / divisor_; }
  double to_theirs(double ours) const { return ours * divisor_ / multiplier_; }

 private:
  friend std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);
  double multiplier_ = 1.0;  ///< 10^n if n > 0, else 1; ours = theirs * 10^n
  double divisor_ = 1.0;
};

/// Returns the conversion between the units `theirs` and `ours`; nullopt if the units differ by more than a
/// prefix. Known prefixes: p, n, u (also written with a micro sign), m, none, k, M.
std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);

enum class Quantity : std::uint8_t { number, drive, position };

template <class Payload, class Value>
struct Field {
  const char* role;
  const char* signal;  ///< signal name in the standard frames
  Value Payload::*member;
  Quantity quantity = Quantity::number;
};
template <class Payload, class Value>
Field(const char*, const char*, Value Payload::*) -> Field<Payload, Value>;
template <class Payload, class Value>
Field(const char*, const char*, Value Payload::*, Quantity) -> Field<Payload, Value>;

/// Returns the names of a standard frame: the message name `prefix` + Payload::name, and the signal names in
/// Payload::fields(). The message has counter and CRC.
template <class Payload>
MessageMap standard_map(const std::string& prefix) {
  MessageMap map{.message = prefix + std::string(Payload::name)};
  std::apply([&](const auto&... field) { (map.signals.emplace(field.role, field.signal), ...); },
             Payload::fields());
  return map;
}

/// Finds the signal of this name. Throws std::invalid_argument if the message has no such signal, or if the
/// signal is not within the bytes of the message.
const Signal& find_signal(const Message& message, const std::string& name);

/// Returns the counter and CRC of a message. Throws std::invalid_argument if a signal is missing, or if the
/// CRC signal does not fill bytes_of(map.polynomial) whole bytes.
Protection protection_of(const Message& message, const MessageMap& map);

/// Encodes and decodes the signals of one message.
template <class Payload>
class Layout {
 public:
  static constexpr std::size_t field_count = std::tuple_size_v<decltype(Payload::fields())>;

  /// `absent`: if the message has no signal for a member of Payload, decoding sets this member to its value
  /// in `absent`. Throws std::invalid_argument if a signal of the message is missing or its unit can't be
  /// converted. If `drive_unit` is empty, no unit is converted.
  Layout(const Message& message, const MessageMap& map, const std::string& drive_unit,
         const Payload& absent = {})
      : id_(message.id),
        extended_(message.extended),
        kind_(wire_kind(message.length, message.fd)),
        fd_flags_(message.bit_rate_switch ? fd_bit_rate_switch : std::uint8_t{0}),
        length_(static_cast<std::uint8_t>(message.length)),
        protection_(protection_of(message, map)),
        states_(map.states),
        absent_(absent) {
    for_each_field([&](const auto& field, auto& slot) {
      const auto named = map.signals.find(field.role);
      if (named == map.signals.end()) return;
      const Signal& signal = find_signal(message, named->second);
      slot.emplace(Slot{SignalCodec(signal), step_for(message, signal, field.quantity, drive_unit)});
    });
  }
  /// Uses the layout of the standard frames.
  explicit Layout(const Message& message) : Layout(message, standard_map<Payload>(""), "") {}

  std::uint32_t id() const { return id_; }
  bool extended() const { return extended_; }
  const Protection& protection() const { return protection_; }
  /// Returns a checker for frames of this message.
  E2eChecker checker() const { return {protection_, length_, extended_, kind_ == FrameKind::fd}; }

  /// Returns a frame of this message in which every signal is zero.
  Frame frame() const {
    return {.id = id_,
            .extended = extended_,
            .kind = kind_,
            .length = wire_length(length_),
            .fd_flags = fd_flags_};
  }
  /// Writes the signals of this layout into a frame of the message. All other signals of the frame stay
  /// unchanged, so that several axes can share one message. Returns false if a signal can't represent its
  /// value; a value never wraps.
  bool put(const Payload& payload, Frame& frame) const {
    bool fits = true;
    for_each_field([&](const auto& field, const std::optional<Slot>& slot) {
      if (slot) fits = put(*slot, payload.*(field.member), frame.payload()) && fits;
    });
    return fits;
  }
  /// Returns a frame with these values; nullopt if a signal can't represent its value.
  std::optional<Frame> encode(const Payload& payload) const {
    Frame encoded = frame();
    if (!put(payload, encoded)) return std::nullopt;
    return encoded;
  }

  Payload decode(const Frame& frame) const {
    Payload payload = absent_;
    for_each_field([&](const auto& field, const std::optional<Slot>& slot) {
      if (slot) get(*slot, payload.*(field.member), frame.payload());
    });
    return payload;
  }

 private:
  struct Slot {
    SignalCodec codec;
    DecimalStep step;
  };

  static DecimalStep step_for(const Message& message, const Signal& signal, Quantity quantity,
                              const std::string& drive_unit) {
    if (quantity == Quantity::number || drive_unit.empty()) return {};
    const std::string ours = quantity == Quantity::drive ? drive_unit : "um";
    if (const auto step = decimal_step(signal.unit, ours)) return *step;
    throw std::invalid_argument("signal " + signal.name + " of message " + message.name + " is in \"" +
                                signal.unit + "\", which can't be converted to \"" + ours + "\"");
  }

  template <class Value>
  bool put(const Slot& slot, Value value, std::span<std::uint8_t> payload) const {
    if constexpr (std::is_same_v<Value, AmpState>) {
      slot.codec.pack_raw(states_.raw(value), payload);
      return true;
    } else {
      return slot.codec.pack(slot.step.to_theirs(static_cast<double>(value)), payload);
    }
  }
  template <class Value>
  void get(const Slot& slot, Value& value, std::span<const std::uint8_t> payload) const {
    if constexpr (std::floating_point<Value>)
      value = slot.step.to_ours(slot.codec.unpack(payload));
    else if constexpr (std::is_same_v<Value, AmpState>)
      value = states_.state(slot.codec.unpack_raw(payload));
    else if constexpr (std::is_same_v<Value, bool>)
      value = slot.codec.unpack_raw(payload) != 0;
    else  // a number that is too large becomes the maximum, so that set flags stay set
      value = static_cast<Value>(std::min<std::uint64_t>(
          static_cast<std::uint64_t>(slot.codec.unpack_raw(payload)), std::numeric_limits<Value>::max()));
  }

  template <class Visit>
  static void visit_fields(auto& slots, Visit visit) {
    std::apply(
        [&](const auto&... field) {
          std::size_t i = 0;
          (visit(field, slots[i++]), ...);
        },
        Payload::fields());
  }
  template <class Visit>
  void for_each_field(Visit visit) {
    visit_fields(slots_, visit);
  }
  template <class Visit>
  void for_each_field(Visit visit) const {
    visit_fields(slots_, visit);
  }

  std::uint32_t id_;
  bool extended_;
  FrameKind kind_;
  std::uint8_t fd_flags_;
  std::uint8_t length_;
  Protection protection_;
  StateValues states_;
  Payload absent_;
  std::array<std::optional<Slot>, field_count> slots_{};
};

/// Encodes the frames of one message for its sender, with counter and CRC.
template <class Payload>
class Encoder {
 public:
  explicit Encoder(Layout<Payload> layout) : layout_(std::move(layout)), protector_(layout_.protection()) {}
  explicit Encoder(const Message& message) : Encoder(Layout<Payload>(message)) {}

  /// Returns the next frame; nullopt if a signal can't represent its value.
  std::optional<Frame> operator()(const Payload& payload) {
    auto frame = layout_.encode(payload);
    if (frame) protector_.seal(*frame);
    return frame;
  }
  std::uint32_t id() const { return layout_.id(); }
  bool extended() const { return layout_.extended(); }

 private:
  Layout<Payload> layout_;
  E2eProtector protector_;
};

/// Checks and decodes the frames of one message for a receiver, and counts the rejected frames.
template <class Payload>
class Decoder {
 public:
  explicit Decoder(Layout<Payload> layout) : layout_(std::move(layout)), checker_(layout_.checker()) {}
  explicit Decoder(const Message& message) : Decoder(Layout<Payload>(message)) {}

  /// Returns the values in a frame; nullopt if the frame is rejected. checker() counts the rejected frames by
  /// reason.
  std::optional<Payload> operator()(const Frame& frame) {
    if (checker_.check(frame)) return std::nullopt;
    return layout_.decode(frame);
  }
  std::uint32_t id() const { return layout_.id(); }
  bool extended() const { return layout_.extended(); }
  const E2eChecker& checker() const { return checker_; }
  void restart() { checker_.restart(); }

 private:
  Layout<Payload> layout_;
  E2eChecker checker_;
};

}  // namespace hystcan::can
