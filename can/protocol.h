// What the nodes say to each other: CANopen's own messages (CiA 301), and the axis messages whose layout the
// DBC gives.
//
//   Nmt 0x000 · Sync 0x080 · emergency 0x080+node · AmpStatus, SensorSample 0x180+node · AmpCommand
//   0x200+node · heartbeat 0x700+node
//
// docs/protocol.md has the table and one annotated frame.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "can/codec.h"
#include "can/dbc.h"
#include "can/frame.h"
#include "can/integrity.h"

namespace hystcan::can {

// ---- CiA 301
// ----------------------------------------------------------------------------------------------------

enum class NmtCommand : std::uint8_t { start = 1, stop = 2, enter_pre_operational = 128, reset_node = 129 };
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F
};

inline constexpr std::uint32_t nmt_id = 0x000;
inline constexpr std::uint32_t sync_id = 0x080;
inline constexpr std::uint32_t emergency_base = 0x080;
inline constexpr std::uint32_t transmit_pdo_base = 0x180;  ///< AmpStatus, SensorSample
inline constexpr std::uint32_t receive_pdo_base = 0x200;   ///< AmpCommand
inline constexpr std::uint32_t heartbeat_base = 0x700;
inline constexpr std::uint8_t sync_counter_max = 240;  ///< the SYNC counter runs 1..240

struct Nmt {
  NmtCommand command;
  std::uint8_t node;  ///< 0: all
};
struct Emergency {
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;
};

Frame nmt_frame(Nmt nmt);
Frame sync_frame(std::uint8_t counter);
Frame heartbeat_frame(std::uint8_t node, NmtState state);
Frame emergency_frame(std::uint8_t node, Emergency emergency);

/// Empty where the frame is not a well-formed one of its kind. The caller has matched the identifier.
std::optional<Nmt> parse_nmt(const Frame& frame);
std::optional<std::uint8_t> parse_sync(const Frame& frame);
std::optional<NmtState> parse_heartbeat(const Frame& frame);
std::optional<Emergency> parse_emergency(const Frame& frame);

/// SYNC counter after `counter`: 1..240, then 1 again.
constexpr std::uint8_t next_sync_counter(std::uint8_t counter) {
  return counter >= sync_counter_max ? std::uint8_t{1} : static_cast<std::uint8_t>(counter + 1);
}

// ---- axis messages
// ----------------------------------------------------------------------------------------------

enum class AmpState : std::uint8_t { off = 0, ready = 1, enabled = 2, fault = 3 };

/// Bits of AmpStatus.Fault.
namespace amp_fault {
inline constexpr std::uint8_t command_timeout = 0x01;
inline constexpr std::uint8_t setpoint_out_of_range = 0x02;
}  // namespace amp_fault

struct AmpCommand {
  static constexpr std::string_view name = "AmpCommand";
  double setpoint = 0.0;  ///< drive units
  bool enable = false;
  bool clear_fault = false;
  std::uint8_t sync_counter = 0;  ///< of the SYNC whose sample this answers

  static constexpr auto fields() {
    return std::tuple{std::pair{"Setpoint", &AmpCommand::setpoint}, std::pair{"Enable", &AmpCommand::enable},
                      std::pair{"ClearFault", &AmpCommand::clear_fault},
                      std::pair{"SyncCounter", &AmpCommand::sync_counter}};
  }
};

struct AmpStatus {
  static constexpr std::string_view name = "AmpStatus";
  double output = 0.0;  ///< drive units, measured
  AmpState state = AmpState::off;
  std::uint8_t fault = 0;  ///< amp_fault bits

  static constexpr auto fields() {
    return std::tuple{std::pair{"Output", &AmpStatus::output}, std::pair{"State", &AmpStatus::state},
                      std::pair{"Fault", &AmpStatus::fault}};
  }
};

struct SensorSample {
  static constexpr std::string_view name = "SensorSample";
  double position_um = 0.0;
  std::uint8_t sync_counter = 0;  ///< of the SYNC at which it was taken
  std::uint8_t status = 0;        ///< 0: good

  static constexpr auto fields() {
    return std::tuple{std::pair{"Position", &SensorSample::position_um},
                      std::pair{"SyncCounter", &SensorSample::sync_counter},
                      std::pair{"Status", &SensorSample::status}};
  }
};

/// The signals of one message, found by name in the DBC and compiled.
template <class Payload>
class Layout {
 public:
  /// Throws std::invalid_argument where the message lacks a signal.
  explicit Layout(const Message& message)
      : id_(message.id),
        extended_(message.extended),
        length_(static_cast<std::uint8_t>(message.length)),
        protection_{codec(message, "Counter"), codec(message, "Crc")} {
    for_each_field([&](const char* signal, auto) { codecs_.push_back(codec(message, signal)); });
  }

  std::uint32_t id() const { return id_; }
  bool extended() const { return extended_; }
  std::uint8_t length() const { return length_; }
  const Protection& protection() const { return protection_; }

  /// Empty where a value can't be represented: it never wraps.
  std::optional<Frame> encode(const Payload& payload) const {
    Frame frame{.id = id_, .extended = extended_, .length = length_};
    std::size_t i = 0;
    bool fits = true;
    for_each_field([&](const char*, auto member) {
      fits = codecs_[i++].pack(static_cast<double>(payload.*member), frame.payload()) && fits;
    });
    if (!fits) return std::nullopt;
    return frame;
  }

  Payload decode(const Frame& frame) const {
    Payload payload;
    std::size_t i = 0;
    for_each_field([&](const char*, auto member) {
      using Value = std::remove_reference_t<decltype(payload.*member)>;
      if constexpr (std::floating_point<Value>)
        payload.*member = codecs_[i++].unpack(frame.payload());
      else
        payload.*member = static_cast<Value>(codecs_[i++].unpack_raw(frame.payload()));
    });
    return payload;
  }

 private:
  template <class Visit>
  static void for_each_field(Visit visit) {
    std::apply([&](const auto&... field) { (visit(field.first, field.second), ...); }, Payload::fields());
  }
  static SignalCodec codec(const Message& message, const char* signal) {
    const Signal* const found = message.find(signal);
    if (found == nullptr) throw std::invalid_argument("message " + message.name + " has no signal " + signal);
    if (message.length > Frame{}.data.size() || bytes_needed(*found) > message.length)
      throw std::invalid_argument("signal " + found->name + " lies outside message " + message.name);
    return SignalCodec(*found);
  }

  std::uint32_t id_;
  bool extended_;
  std::uint8_t length_;
  Protection protection_;
  std::vector<SignalCodec> codecs_;
};

/// Sender of one message: encodes, counts, seals.
template <class Payload>
class Encoder {
 public:
  explicit Encoder(const Message& message) : layout_(message), sealer_(layout_.protection()) {}

  /// Empty where a value can't be represented.
  std::optional<Frame> operator()(const Payload& payload) {
    auto frame = layout_.encode(payload);
    if (frame) sealer_.seal(*frame);
    return frame;
  }
  std::uint32_t id() const { return layout_.id(); }

 private:
  Layout<Payload> layout_;
  Sealer sealer_;
};

/// Receiver of one message: checks, counts what it rejects, decodes.
template <class Payload>
class Decoder {
 public:
  explicit Decoder(const Message& message)
      : layout_(message), checker_(layout_.protection(), layout_.length(), layout_.extended()) {}

  /// Empty where the frame is rejected; checker() says how often and why.
  std::optional<Payload> operator()(const Frame& frame) {
    if (checker_.check(frame)) return std::nullopt;
    return layout_.decode(frame);
  }
  std::uint32_t id() const { return layout_.id(); }
  const Checker& checker() const { return checker_; }
  void restart() { checker_.restart(); }

 private:
  Layout<Payload> layout_;
  Checker checker_;
};

/// Names and nodes of one axis on the wire.
struct AxisWire {
  std::string name;            ///< "x"
  std::string message_prefix;  ///< "X": messages XAmpCommand, XAmpStatus, XSensorSample
  std::uint8_t amplifier_node = 0;
  std::uint8_t sensor_node = 0;
};

/// The message of role `Payload` for this axis. Throws std::invalid_argument where the database lacks it.
template <class Payload>
const Message& find_message(const Database& database, const AxisWire& axis) {
  const std::string name = axis.message_prefix + std::string(Payload::name);
  if (const Message* found = database.find(name)) return *found;
  throw std::invalid_argument("no message " + name);
}

}  // namespace hystcan::can
