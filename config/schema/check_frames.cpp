#include "config/schema/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "can/protocol/protocol.h"
#include "config/document/closest.h"
#include "config/schema/frames.h"

namespace hystcan::config {
namespace {

/// Checks one message of one axis against the DBC.
template <class Payload>
class FrameCheck : Checked {
 public:
  /// `part` is the message's part in [axis.frames]: "command", "status" or "sample". It is unused for
  /// ControllerStatus, Setpoint and ScanMarker, because [axis.frames] cannot rename these messages.
  FrameCheck(const Checked& checked, std::size_t index, const char* part)
      : Checked(checked),
        axis_(config.axes[index]),
        has_standard_id_(first_sharing<can::AmpCommand>(config, index) == index),
        path_(fmt::format("axis[{}]", index)),
        part_(part) {}

  /// Runs all checks. `standard_id` is the identifier that the protocol defines for this message. A message
  /// that the lab defines in [axis.frames] may have a different identifier.
  void run(std::uint32_t standard_id) {
    const auto map = can::message_map_in<Payload>(config.database, axis_.wire);
    if (!map) return;
    map_ = *map;
    find_message();
    find_signals();
    check_no_overlap();
    check_crc();
    if (!is_own() && has_standard_id_) check_standard_id(standard_id);
    std::apply([&](const auto&... field) { (check_field(field), ...); }, Payload::fields());
    check_states();
  }

 private:
  bool is_own() const { return axis_.wire.frames.has_value() && !can::is_optional<Payload>; }

  /// Throws Error. If [axis.frames] defines the message, the error has the place of `key` in [axis.frames].
  /// Otherwise it has the place of the key `dbc` in [bus].
  [[noreturn]] void fail(const std::string& key, const std::string& what, const std::string& expected) const {
    const std::string place = is_own() ? fmt::format("{}.frames.{}.{}", path_, part_, key) : "bus.dbc";
    document.fail_at(place, fmt::format("{} in {}, expected {}", what, config.bus.dbc.string(), expected));
  }

  void find_message() {
    message_ = config.database.find(map_.message);
    if (message_ != nullptr) return;
    std::vector<std::string> names;
    names.reserve(config.database.messages.size());
    for (const can::Message& message : config.database.messages) names.push_back(message.name);
    fail("message", "no message " + map_.message,
         fmt::format("a message for axis {}; the most similar names: {}", axis_.wire.name,
                     closest(map_.message, names)));
  }

  void find_signals() {
    for (const auto& [role, signal] : map_.signals) find_signal(role, signal);
    if (map_.integrity != can::Integrity::none) find_signal("counter", map_.counter);
    if (map_.integrity == can::Integrity::counter_crc) find_signal("crc", map_.crc);
  }

  void find_signal(const std::string& key, const std::string& name) {
    const can::Signal* signal = message_->find(name);
    if (signal == nullptr) {
      std::vector<std::string> names;
      names.reserve(message_->signals.size());
      for (const can::Signal& other : message_->signals) names.push_back(other.name);
      fail(key, fmt::format("message {} has no signal {}", message_->name, name),
           fmt::format("a signal for axis {}; the most similar names: {}", axis_.wire.name,
                       closest(name, names)));
    }
    if (can::bytes_needed(*signal) > message_->length)
      fail(key,
           fmt::format("signal {} lies outside message {}, which has {} bytes", name, message_->name,
                       message_->length),
           "a signal within the message: move the signal, or make the message longer");
    if (signal->multiplexing.present_at)
      fail(key, fmt::format("signal {} of message {} is multiplexed", name, message_->name),
           "a signal that is in every frame");
    if (!can::is_decodable(*signal))
      fail(key, fmt::format("signal {} of message {} has {} bits", name, message_->name, signal->length),
           "1 to 64 bits, or 32 or 64 bits for an IEEE 754 number");
    used_.emplace_back(key, signal);
  }

  /// Checks that no bit of the message belongs to two signals. Otherwise one signal would change the other.
  void check_no_overlap() const {
    std::vector<std::uint8_t> taken(message_->length);
    for (const auto& [key, signal] : used_) {
      const std::vector<std::uint8_t> bits = bits_of(*message_, *signal);
      for (std::size_t i = 0; i < bits.size(); ++i) {
        if ((taken[i] & bits[i]) != 0)
          fail(key,
               fmt::format("signal {} of message {} overlaps another signal", signal->name, message_->name),
               "unused bits");
        taken[i] = static_cast<std::uint8_t>(taken[i] | bits[i]);
      }
    }
  }

  void check_crc() const {
    if (map_.integrity != can::Integrity::counter_crc) return;
    const can::SignalCodec crc(*message_->find(map_.crc));
    const unsigned count = can::bytes_of(map_.polynomial);
    const bool whole = crc.fills_bytes(count);
    if (!is_own() && (!whole || crc.first_byte() + count != message_->length))
      fail("crc",
           fmt::format("signal {} of message {} is not the last byte of the message", map_.crc,
                       message_->name),
           "the CRC there");
    if (!whole)
      fail(
          "crc",
          fmt::format("signal {} of message {} is not {}", map_.crc, message_->name,
                      count == 1 ? "a whole byte" : "two whole bytes"),
          fmt::format("a signal of {} bits that fills {}, as polynomial {}{} requires, or another polynomial",
                      8 * count, count == 1 ? "a byte" : "two bytes", word_of(map_.polynomial),
                      count == 1 ? "" : " (the default above 8 bytes)"));
  }

  void check_standard_id(std::uint32_t id) const {
    if (message_->id == id && !message_->extended) return;
    Checked::fail(axis_.wire.name,
                  "message {} has identifier 0x{:X} in {}, expected 0x{:X}, which follows from the node id",
                  message_->name, message_->id, config.bus.dbc.string(), id);
  }

  template <class Member>
  void check_field(const can::Field<Payload, Member>& field) const {
    const auto named = map_.signals.find(field.role);
    if (named == map_.signals.end()) return;
    const can::Signal& signal = *message_->find(named->second);
    const can::SignalCodec codec(signal);
    if (field.quantity != can::Quantity::number) check_unit(field, signal);
    const std::string_view role = field.role;
    if (role == "sync_counter" && !holds_integers(codec, 1, can::sync_counter_max))
      fail_at_integers(field.role, signal, codec,
                       fmt::format("1 to {}, the range of the SYNC counter", can::sync_counter_max));
    if ((role == "enable" || role == "clear_fault") && !holds_integers(codec, 0, 1))
      fail_at_integers(field.role, signal, codec, "0 and 1");
    if (role == "in_position" || role == "limited" || role == "reference_finished")
      expect_integers(field.role, signal, codec, 1);
    if (role == "axis_state") expect_integers(field.role, signal, codec, controller::axis_state_count - 1);
    if (role == "cause") expect_integers(field.role, signal, codec, controller::cause_count - 1);
    if ((role == "scan_line" || role == "scan_frame") && axis_.scan_marker)
      expect_integers(field.role, signal, codec, 65'535);
    if (role == "mode") expect_integers(field.role, signal, codec, can::setpoint_mode::go_to);
    if (role == "setpoint") check_drive_range(signal, codec);
    const controller::AxisConfig& control = axis_.control;
    if (role == "position")
      check_positions("positions", control.supervision.position_min_um, control.supervision.position_max_um,
                      signal, codec);
    const double width_um = control.supervision.position_max_um - control.supervision.position_min_um;
    if (role == "following_error") check_positions("following errors", -width_um, width_um, signal, codec);
  }

  /// Returns true if the signal can represent every integer from `low` to `high` exactly.
  static bool holds_integers(const can::SignalCodec& codec, int low, int high) {
    std::array<std::uint8_t, 64> payload{};
    for (int value = low; value <= high; ++value)
      if (!codec.pack(value, payload) || std::abs(codec.unpack(payload) - value) > 1e-6) return false;
    return true;
  }

  void expect_integers(const std::string& key, const can::Signal& signal, const can::SignalCodec& codec,
                       std::size_t largest) const {
    if (!holds_integers(codec, 0, static_cast<int>(largest)))
      fail_at_integers(key, signal, codec, fmt::format("0 to {}", largest));
  }

  [[noreturn]] void fail_at_integers(const std::string& key, const can::Signal& signal,
                                     const can::SignalCodec& codec, const std::string& expected) const {
    fail(key,
         fmt::format("signal {} of message {} holds {} to {} in steps of {}", signal.name, message_->name,
                     codec.minimum(), codec.maximum(), codec.resolution()),
         expected);
  }

  template <class Member>
  void check_unit(const can::Field<Payload, Member>& field, const can::Signal& signal) const {
    const std::string ours = field.quantity == can::Quantity::drive ? axis_.wire.drive_unit : "um";
    if (can::decimal_step(signal.unit, ours)) return;
    const std::string place = is_own() ? fmt::format("{}.frames.{}.{}", path_, part_, field.role)
                                       : path_of(config, axis_.wire.drive_unit);
    document.fail_at(place,
                     fmt::format("signal {} of {} has the unit \"{}\" in {}, expected \"{}\" or "
                                 "the same unit with another prefix",
                                 signal.name, message_->name, signal.unit, config.bus.dbc.string(), ours));
  }

  void check_drive_range(const can::Signal& signal, const can::SignalCodec& codec) const {
    const can::DecimalStep step = *can::decimal_step(signal.unit, axis_.wire.drive_unit);
    const double low = step.to_ours(codec.minimum());
    const double high = step.to_ours(codec.maximum());
    const controller::Gate::Config& gate = axis_.control.gate;
    if (gate.drive_min >= low && gate.drive_max <= high) return;
    Checked::fail(gate.drive_max, "the drive range {}..{} does not fit signal {}, expected within {}..{}",
                  gate.drive_min, gate.drive_max, signal.name, low, high);
  }

  /// Checks that the signal can represent all values from `needed_low` to `needed_high`, in um. These values
  /// are the allowed positions of the axis, or the differences that two allowed positions can have (for a
  /// following error). `what` names the values in the error message.
  void check_positions(const char* what, double needed_low, double needed_high, const can::Signal& signal,
                       const can::SignalCodec& codec) const {
    const can::DecimalStep step = *can::decimal_step(signal.unit, "um");
    const double low = step.to_ours(codec.minimum());
    const double high = step.to_ours(codec.maximum());
    if (needed_low >= low && needed_high <= high) return;
    Checked::fail(axis_.control.supervision.position_max_um,
                  "the {} {}..{} um do not fit signal {}, expected within {}..{} um", what, needed_low,
                  needed_high, signal.name, low, high);
  }

  void check_states() const {
    const auto named = map_.signals.find("state");
    if (named == map_.signals.end()) return;
    const can::SignalCodec codec(*message_->find(named->second));
    const auto check = [&](const char* key, const std::vector<std::int64_t>& values) {
      std::array<std::uint8_t, 64> payload{};
      for (const std::int64_t value : values) {
        codec.pack_raw(value, payload);
        if (codec.unpack_raw(payload) != value)
          fail(key,
               fmt::format("{} does not fit signal {} of message {}", value, named->second, message_->name),
               "raw values that the signal can contain");
      }
    };
    check("state_off", map_.states.off);
    check("state_ready", map_.states.ready);
    check("state_enabled", map_.states.enabled);
    check("state_fault", map_.states.fault);
    if (map_.states.ready.empty() || map_.states.enabled.empty())
      fail(map_.states.ready.empty() ? "state_ready" : "state_enabled",
           fmt::format("no raw value of signal {} is configured", named->second),
           "a raw value for ready and a raw value for enabled; the two may be equal");
  }

  const AxisConfig& axis_;
  /// True if a message that is not in [axis.frames] must have the identifier that the protocol defines. False
  /// if the axis shares its command message with an earlier axis: both axes then have the same amplifier
  /// node, and the defined identifiers contain the number of this node.
  bool has_standard_id_;
  std::string path_;
  const char* part_;
  can::MessageMap map_;
  const can::Message* message_ = nullptr;
  std::vector<std::pair<std::string, const can::Signal*>> used_;
};

}  // namespace

void check_frames(const Checked& checked, std::size_t axis) {
  const Config& config = checked.config;
  const can::AxisWire& wire = config.axes[axis].wire;
  if (!wire.frames && wire.message_prefix.empty())
    checked.document.fail_at(
        fmt::format("axis[{}]", axis),
        "missing key message_prefix, expected the key in [[axis]], or the table [axis.frames] instead");
  FrameCheck<can::AmpCommand>(checked, axis, "command").run(can::receive_pdo_base + wire.amplifier_node);
  FrameCheck<can::AmpStatus>(checked, axis, "status").run(can::transmit_pdo_base + wire.amplifier_node);
  FrameCheck<can::SensorSample>(checked, axis, "sample").run(can::transmit_pdo_base + wire.sensor_node);
  FrameCheck<can::ControllerStatus>(checked, axis, "").run(can::controller_status_base + wire.amplifier_node);
  FrameCheck<can::Setpoint>(checked, axis, "").run(can::setpoint_base + wire.amplifier_node);
  FrameCheck<can::ScanMarker>(checked, axis, "").run(can::scan_marker_base + wire.amplifier_node);
  const auto expect = [&]<class Payload>(const bool& is_used) {
    if (!is_used || can::message_map_in<Payload>(config.database, wire)) return;
    checked.fail(is_used, "no message {}{} in {}, expected this message for {} = true", wire.message_prefix,
                 Payload::name, config.bus.dbc.string(), key_of(config.axes[axis], is_used));
  };
  expect.template operator()<can::Setpoint>(config.axes[axis].live_setpoint);
  expect.template operator()<can::ScanMarker>(config.axes[axis].scan_marker);
}

std::vector<std::string> protection_warnings(const Config& config) {
  std::vector<std::string> warnings;
  std::set<std::string> judged;  // names of the messages checked so far, because axes may share a message
  for (const AxisConfig& axis : config.axes)
    for (const auto& [name, protection] : protections(axis.wire, config.database)) {
      if (!protection.crc || !judged.insert(name).second) continue;
      const std::size_t length = config.database.find(name)->length;
      const unsigned covered =
          can::wire_length(static_cast<std::uint8_t>(length)) - can::bytes_of(protection.polynomial);
      const unsigned most = can::most_bytes_guarded(protection.polynomial);
      if (covered > most)
        warnings.push_back(fmt::format(
            "message {} of axis {}: {} covers {} bytes, but detects every pair of wrong bits only in at most "
            "{} bytes: use polynomial = \"CRC-16\", with two bytes for the CRC",
            name, axis.wire.name, word_of(protection.polynomial), covered, most));
    }
  return warnings;
}

std::vector<std::string> format_warnings(const Config& config) {
  std::vector<std::string> warnings;
  for (const std::string& name : fd_messages(config)) {
    const can::Message& message = *config.database.find(name);
    if (message.fd) continue;
    warnings.push_back(fmt::format(
        "message {} (BO_ {}) in {} has {} bytes, but its VFrameFormat is classical CAN: it is sent "
        "as CAN FD without bit-rate switch; set VFrameFormat = \"{}CAN_FD\", and CANFD_BRS = 1 for a "
        "bit-rate switch",
        name, can::Database::key_of(message.id, message.extended), config.bus.dbc.string(), message.length,
        message.extended ? "Extended" : "Standard"));
  }
  return warnings;
}

void check_identifiers(const Checked& checked) {
  const Config& config = checked.config;
  std::map<std::uint32_t, std::string> taken{{can::nmt_id, "NMT"},
                                             {can::sync_id, "SYNC"},
                                             {can::heartbeat_base + config.controller.node, "heartbeat"}};
  for (const AxisConfig& axis : config.axes) {
    for (const std::uint32_t node : {axis.wire.amplifier_node, axis.wire.sensor_node}) {
      taken.emplace(can::heartbeat_base + node, fmt::format("the heartbeat of node {}", node));
      taken.emplace(can::emergency_base + node, fmt::format("the emergency of node {}", node));
      taken.emplace(can::sdo_request_base + node, fmt::format("the SDO request to node {}", node));
      taken.emplace(can::sdo_response_base + node, fmt::format("the SDO response of node {}", node));
    }
  }
  const auto take = [&](const std::optional<can::MessageMap>& map, const std::string& place) {
    if (!map) return;
    const can::Message& message = can::find_message(config.database, *map);
    const auto [before, is_new] = taken.emplace(message.id, message.name);
    if (!is_new)
      checked.document.fail_at(place, fmt::format("message {} has identifier 0x{:X}, which {} uses, expected "
                                                  "an unused identifier",
                                                  message.name, message.id, before->second));
  };
  const auto take_once = [&]<class Payload>(std::size_t i, const char* part) {
    if (first_sharing<Payload>(config, i) == i)
      take(can::message_map<Payload>(config.axes[i].wire),
           fmt::format("axis[{}].frames.{}.message", i, part));
  };
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const can::AxisWire& wire = config.axes[i].wire;
    take_once.template operator()<can::AmpCommand>(i, "command");
    take_once.template operator()<can::AmpStatus>(i, "status");
    take_once.template operator()<can::SensorSample>(i, "sample");
    take(can::message_map_in<can::ControllerStatus>(config.database, wire), "bus.dbc");
    take(can::message_map_in<can::Setpoint>(config.database, wire), "bus.dbc");
    take(can::message_map_in<can::ScanMarker>(config.database, wire), "bus.dbc");
  }
}

}  // namespace hystcan::config
