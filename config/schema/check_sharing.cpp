#include <fmt/format.h>

#include <map>
#include <set>

#include "can/protocol/protocol.h"
#include "config/schema/check.h"
#include "config/schema/frames.h"

namespace hystcan::config {
namespace {

/// Checks one message that an axis shares with preceding axes.
template <class Payload>
class SharingCheck : Checked {
 public:
  /// `part` is the message's part in [axis.frames]: "command", "status" or "sample". `node` is the member
  /// with the id of the node that sends or receives the message.
  SharingCheck(const Checked& checked, std::size_t index, const char* part, std::uint8_t can::AxisWire::*node)
      : Checked(checked), index_(index), part_(part), node_(node) {}

  void run() const {
    const std::size_t first = first_sharing<Payload>(config, index_);
    if (first == index_) return;
    const can::MessageMap map = map_of(index_);
    const std::uint8_t &node = wire(index_).*node_, expected = wire(first).*node_;
    if (node != expected)
      fail(node, "{} is {}, expected {} as in axis {}: both axes use message {}",
           key_of(config.axes[index_], node), node, expected, wire(first).name, map.message);
    check_protection(map, first);
    const can::Message& message = can::find_message(config.database, map);
    for (std::size_t other = first; other < index_; ++other)
      if (first_sharing<Payload>(config, other) == first) check_signals(message, map, other);
  }

 private:
  const can::AxisWire& wire(std::size_t axis) const { return config.axes[axis].wire; }
  can::MessageMap map_of(std::size_t axis) const { return *can::message_map<Payload>(wire(axis)); }
  std::string place(std::string_view key) const {
    return fmt::format("axis[{}].frames.{}.{}", index_, part_, key);
  }

  void check_protection(const can::MessageMap& map, std::size_t first) const {
    const can::MessageMap theirs = map_of(first);
    const auto expect_same = [&](const char* key, bool is_same) {
      if (!is_same)
        document.fail_at(
            place(key),
            fmt::format(
                "{} differs from the value of axis {}, expected the same value: both axes use message {}",
                key, wire(first).name, map.message));
    };
    expect_same("integrity", map.integrity == theirs.integrity);
    if (map.integrity == can::Integrity::none) return;
    expect_same("counter", map.counter == theirs.counter);
    if (map.integrity == can::Integrity::counter) return;
    expect_same("crc", map.crc == theirs.crc);
    expect_same("polynomial", map.polynomial == theirs.polynomial);
    expect_same("crc_covers", map.data_id.kind == theirs.data_id.kind);
    expect_same("data_id", map.data_id.number == theirs.data_id.number);
  }

  /// Checks that this axis and the axis `other` use different bits of the message. They may share only the
  /// SYNC counter.
  void check_signals(const can::Message& message, const can::MessageMap& map, std::size_t other) const {
    const can::MessageMap theirs = map_of(other);
    for (const auto& [role, signal] : map.signals)
      for (const auto& [their_role, their_signal] : theirs.signals) {
        if (role == "sync_counter" && their_role == role && signal == their_signal) continue;
        if (share_bits(message, signal, their_signal))
          document.fail_at(place(role),
                           fmt::format("signal {} of message {} has bits of signal {} of axis {}, expected "
                                       "unused bits",
                                       signal, message.name, their_signal, wire(other).name));
      }
  }

  static bool share_bits(const can::Message& message, const std::string& one, const std::string& other) {
    const auto ours = bits_of(message, can::find_signal(message, one));
    const auto theirs = bits_of(message, can::find_signal(message, other));
    for (std::size_t i = 0; i < ours.size(); ++i)
      if ((ours[i] & theirs[i]) != 0) return true;
    return false;
  }

  std::size_t index_;
  const char* part_;
  std::uint8_t can::AxisWire::*node_;
};

/// Checks that only one axis configures SDO objects of a node (the lists amplifier_setup and sensor_setup),
/// if several axes share the node.
void check_setups(const Checked& checked, std::size_t index) {
  const Config& config = checked.config;
  const auto check = [&](std::size_t first, const std::vector<can::SdoWrite>& setup) {
    if (first == index || setup.empty()) return;
    checked.fail(setup,
                 "{} is for a node that axis {} also uses, expected the "
                 "SDO objects of this node only in that axis",
                 key_of(config.axes[index], setup), config.axes[first].wire.name);
  };
  const can::AxisWire& wire = config.axes[index].wire;
  check(first_sharing<can::AmpCommand>(config, index), wire.amplifier_setup);
  check(first_sharing<can::SensorSample>(config, index), wire.sensor_setup);
}

}  // namespace

std::vector<std::string> command_warnings(const Config& config) {
  std::map<std::string, std::set<std::string>> named;  // for each command message, its signals that axes use
  for (const AxisConfig& axis : config.axes) {
    const can::MessageMap map = *can::message_map<can::AmpCommand>(axis.wire);
    std::set<std::string>& signals = named[map.message];
    for (const auto& [role, signal] : map.signals) signals.insert(signal);
    signals.insert({map.counter, map.crc});
  }
  std::vector<std::string> warnings;
  for (const auto& [name, signals] : named) {
    const can::Message& message = *config.database.find(name);
    const std::vector<std::uint8_t> zeros(message.length);
    for (const can::Signal& signal : message.signals) {
      if (signals.contains(signal.name) || !can::is_decodable(signal)) continue;
      if (can::bytes_needed(signal) > message.length) continue;
      if (const double value = can::SignalCodec(signal).unpack(zeros); value != 0.0)
        warnings.push_back(fmt::format("message {}: signal {} has no role and is always sent as {:g} {}",
                                       name, signal.name, value, signal.unit));
    }
  }
  return warnings;
}

void check_sharing(const Checked& checked) {
  const Config& config = checked.config;
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    SharingCheck<can::AmpCommand>(checked, i, "command", &can::AxisWire::amplifier_node).run();
    SharingCheck<can::AmpStatus>(checked, i, "status", &can::AxisWire::amplifier_node).run();
    SharingCheck<can::SensorSample>(checked, i, "sample", &can::AxisWire::sensor_node).run();
    check_setups(checked, i);
    if (const std::size_t first = first_sharing<can::SensorSample>(config, i);
        config.axes[i].twin.sample_clock != config.axes[first].twin.sample_clock)
      checked.document.fail_at(
          fmt::format("axis[{}].twin.sensor", i),
          fmt::format(
              "the sample clock of the sensor differs from that of axis {}, expected equal clocks: the "
              "samples of both axes are in the same frame",
              config.axes[first].wire.name));
    const std::size_t first = first_sharing<can::AmpCommand>(config, i);
    if (first == i) continue;
    for (const std::size_t axis : {first, i})
      if (const bool& verify_watchdog = config.axes[axis].control.verify_watchdog)
        checked.fail(verify_watchdog,
                     "the commands of several axes are in the same frame, expected verify_watchdog = false: "
                     "the watchdog test of one axis would stop the commands of all these axes");
    if (config.controller.command_deadline >= controller::cycle_of(config.controller))
      checked.fail(config.controller.command_deadline,
                   "command_deadline_us is {:g}, expected less than the cycle, {:g}",
                   1e6 * can::seconds(config.controller.command_deadline), 1e6 / config.controller.rate_Hz);
  }
}

}  // namespace hystcan::config
