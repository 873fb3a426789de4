// The layout of one message, compiled from the DBC and a map of names. The constructor finds the signal of
// each role (the purpose of a value, such as `setpoint`).
//
// A `Payload` lists its roles in fields():
//
//   Field{role, name of the standard signal, member, quantity}
//
//   encode   our unit -> unit of the DBC -> raw bits;   a role without a signal is left out
//   decode   raw bits -> unit of the DBC -> our unit;   a role without a signal gets its value from `absent`
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

/// State of an amplifier.
enum class AmpState : std::uint8_t { off = 0, ready = 1, enabled = 2, fault = 3 };

enum class Integrity : std::uint8_t { none, counter, counter_crc };
constexpr auto words(Integrity) {
  return std::to_array<std::string_view>({"none", "counter", "counter+crc"});
}

/// Raw values of a state signal.
struct StateValues {
  std::vector<std::int64_t> off{0};
  std::vector<std::int64_t> ready{1};
  std::vector<std::int64_t> enabled{2};
  std::vector<std::int64_t> fault{3};

  /// Converts a raw value. An unlisted value means off; a value in two lists means the more severe state.
  AmpState state(std::int64_t raw) const;
  /// Returns the first raw value of the state's list; if the list is empty, the first value of `off`, else 0.
  std::int64_t raw(AmpState state) const;
};

/// The names from the configuration: the message of the DBC and the signal of each role.
struct MessageMap {
  std::string message;
  /// Signal name by role; a role that is missing is not sent.
  std::map<std::string, std::string, std::less<>> signals{};
  Integrity integrity = Integrity::counter_crc;
  std::string counter = "Counter";
  std::string crc = "Crc";
  Crc polynomial = Crc::sae_j1850;
  DataId data_id{};
  StateValues states{};

  bool carries(std::string_view role) const { return signals.contains(role); }
};

/// The frames of one axis that a lab defines instead of the standard frames. Without a status message, the
/// controller does not read the amplifier's status.
struct AxisFrames {
  MessageMap command;
  std::optional<MessageMap> status{};
  MessageMap sample;
};

/// Converts a DBC unit to our unit if the two differ only by a decimal prefix: mV to V, nm to um, mA to A.
///
///   ours = theirs * 10^n,   n = exponent(their prefix) - exponent(our prefix)
///
/// The step is exact: a double represents the whole number 10^|n| exactly, and one multiplication or division
/// by it rounds once. A value that is converted there and back differs by at most one or two last bits, far
/// below the resolution of any signal.
class DecimalStep {
 public:
  double to_ours(double theirs) const { return theirs * multiplier_ / divisor_; }
  double to_theirs(double ours) const { return ours * divisor_ / multiplier_; }

 private:
  friend std::optional<DecimalStep> decimal_step(std::string_view theirs, std::string_view ours);
  double multiplier_ = 1.0;  ///< multiplier_ or divisor_ is 1
  double divisor_ = 1.0;
};

/// Returns nullopt if the units differ by more than a prefix. Known prefixes: p, n, u (also written with a
/// micro sign), m, none, k, M.
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

/// Returns the map of the standard frames: message `prefix` + Payload::name, every role, counter and CRC.
template <class Payload>
MessageMap standard_map(const std::string& prefix) {
  MessageMap map{.message = prefix + std::string(Payload::name)};
  std::apply([&](const auto&... field) { (map.signals.emplace(field.role, field.signal), ...); },
             Payload::fields());
  return map;
}

/// Finds the signal of this name. Throws std::invalid_argument if the message has no such signal.
const Signal& find_signal(const Message& message, const std::string& name);

/// Throws std::invalid_argument if a signal is missing, or if the CRC signal does not fill the bytes of the
/// polynomial.
Protection protection_of(const Message& message, const MessageMap& map);

/// The signals of one message.
template <class Payload>
class Layout {
 public:
  static constexpr std::size_t field_count = std::tuple_size_v<decltype(Payload::fields())>;

  /// Throws std::invalid_argument if a signal of the message is missing or a unit does not convert. If
  /// `drive_unit` is empty, the numbers are not converted.
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
  /// Writes the signals of this layout into a frame of the message and leaves all others unchanged, so that
  /// several axes can share one message. Returns false if a signal can't represent a value; a value never
  /// wraps.
  bool put(const Payload& payload, Frame& frame) const {
    bool fits = true;
    for_each_field([&](const auto& field, const std::optional<Slot>& slot) {
      if (slot) fits = put(*slot, payload.*(field.member), frame.payload()) && fits;
    });
    return fits;
  }
  /// Returns nullopt if a signal can't represent a value.
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
                                signal.unit + "\", which does not convert to \"" + ours + "\"");
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

/// The sender of one message: encodes it and adds counter and CRC.
template <class Payload>
class Encoder {
 public:
  explicit Encoder(Layout<Payload> layout) : layout_(std::move(layout)), protector_(layout_.protection()) {}
  explicit Encoder(const Message& message) : Encoder(Layout<Payload>(message)) {}

  /// Returns nullopt if the signal can't represent a value.
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

/// The receiver of one message: checks a frame, counts rejections and decodes.
template <class Payload>
class Decoder {
 public:
  explicit Decoder(Layout<Payload> layout) : layout_(std::move(layout)), checker_(layout_.checker()) {}
  explicit Decoder(const Message& message) : Decoder(Layout<Payload>(message)) {}

  /// Returns nullopt if the frame is rejected; checker() counts the rejections by reason.
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
