#include "app/stage/lab_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "base/words.h"
#include "can/protocol/protocol.h"
#include "config/schema/frames.h"

namespace hystcan::app {
namespace {

using can::Message;
using can::MessageMap;
using can::Quantity;
using can::Signal;

enum class FramePart : std::uint8_t { command, sample, status };
constexpr auto words(FramePart) { return std::to_array<std::string_view>({"command", "sample", "status"}); }

struct Role {
  FramePart part;
  Quantity quantity;
  const char* name;
  const char* what;
  const char* own_option = nullptr;  ///< option for this role; null: --role PART.NAME

  std::string key() const { return fmt::format("{}.{}", word_of(part), name); }
  std::string option() const { return own_option != nullptr ? own_option : "--role " + key(); }
  bool is(std::string_view other) const { return name == other; }
};

/// All roles that a signal can have, in the order in which the user is asked about them.
constexpr Role all_roles[] = {
    {FramePart::command, Quantity::drive, "setpoint", "Commanded drive", "--setpoint"},
    {FramePart::command, Quantity::number, "enable", "Switch that enables the amplifier", "--enable"},
    {FramePart::command, Quantity::number, "clear_fault", "Bit that clears a fault"},
    {FramePart::command, Quantity::number, "sync_counter", "SYNC counter in the command frame"},
    {FramePart::command, Quantity::number, "counter", "Frame counter of a command"},
    {FramePart::command, Quantity::number, "crc", "CRC of a command"},
    {FramePart::sample, Quantity::position, "position", "Measured position", "--position"},
    {FramePart::sample, Quantity::number, "status", "Status of the sensor, 0 if good"},
    {FramePart::sample, Quantity::number, "sync_counter", "SYNC counter in the sample frame"},
    {FramePart::sample, Quantity::number, "counter", "Frame counter of a sample"},
    {FramePart::sample, Quantity::number, "crc", "CRC of a sample"},
    {FramePart::status, Quantity::drive, "output", "Measured output of the amplifier"},
    {FramePart::status, Quantity::number, "state", "State of the amplifier"},
    {FramePart::status, Quantity::number, "fault", "Fault of the amplifier, 0 if none"},
    {FramePart::status, Quantity::number, "counter", "Frame counter of a status"},
    {FramePart::status, Quantity::number, "crc", "CRC of a status"}};

constexpr std::string_view states_key = "status.states";
/// The user's answer if the frames have no signal for a role.
constexpr std::string_view no_signal = "none";

/// Parses a text such as 0/16/32/64,65: the raw values of the amplifier states off, ready, enabled and fault.
/// The values of off and fault may be missing. Returns `nullopt` if the text is invalid.
std::optional<can::StateValues> parsed_states(std::string_view text) {
  can::StateValues states{{}, {}, {}, {}};
  std::vector<std::int64_t>* const lists[] = {&states.off, &states.ready, &states.enabled, &states.fault};
  std::size_t list = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(",/"), text.size());
    const auto raw = parsed_number<std::int64_t>(text.substr(0, end));
    if (raw) lists[list]->push_back(*raw);
    if (!raw && end != 0) return std::nullopt;
    if (end < text.size() && text[end] == '/' && ++list == std::size(lists)) return std::nullopt;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (list != 3 || states.ready.empty() || states.enabled.empty()) return std::nullopt;
  return states;
}

/// Returns the first 12 signals as text, and the number of the others.
std::string list_of(const std::vector<std::string>& signals) {
  const std::size_t shown = std::min<std::size_t>(signals.size(), 12);
  return fmt::format("{}{}", fmt::join(std::span(signals).first(shown), ", "),
                     shown < signals.size() ? fmt::format(" and {} more", signals.size() - shown) : "");
}

/// Asks the user which signals of the lab's DBC belong to one axis.
class FrameQuestions {
 public:
  FrameQuestions(const StageFacts& stage, const can::Database& database, const StatedRoles& stated,
                 std::size_t axis, Questions& questions)
      : stage_(stage), database_(database), stated_(stated), axis_(axis), questions_(questions) {}

  can::AxisFrames ask() {
    for (const Role& role : all_roles) ask_for(role);
    for (const FramePart part : every<FramePart>()) protect(part);
    std::optional<MessageMap> status;
    if (!map_of(FramePart::status).message.empty()) status = map_of(FramePart::status);
    return {.command = map_of(FramePart::command), .status = status, .sample = map_of(FramePart::sample)};
  }

 private:
  MessageMap& map_of(FramePart part) { return maps_[static_cast<std::size_t>(part)]; }
  const can::AxisWire& wire() const { return stage_.axes[axis_].config.wire; }

  std::optional<std::string> stated(const std::string& key, const std::string& option) const {
    const auto found = stated_.find(key);
    if (found == stated_.end()) return std::nullopt;
    return of_axis(option.c_str(), found->second, axis_, stage_.axes.size());
  }

  void ask_for(const Role& role) {
    MessageMap& map = map_of(role.part);
    const std::string unit = unit_of(role);
    const bool is_needed = config::must_be_carried(role.name);
    const std::vector<std::string> found = candidates(role);
    const std::optional<std::string> known = stated(role.key(), role.option());
    const bool is_asked = !found.empty() && (!map.message.empty() || !unit.empty()) &&
                          (!role.is("crc") || map.carries("counter"));
    if (!known && !is_needed && !is_asked) return;
    const std::string list = list_of(found) + (is_needed ? "" : found.empty() ? "none" : ", none");
    const std::string what =
        fmt::format("{}{} (axis {})", role.what, unit.empty() ? "" : " in " + unit, wire().name);
    const std::string answer = questions_.text(
        {role.option(), what, "", list}, known,
        is_needed || role.is("enable") ? std::nullopt : std::optional(std::string(no_signal)),
        [&](const std::string& signal) {
          const auto is_it = [&](const std::string& one) {
            return one == signal || one.starts_with(signal + " [");
          };
          return unless((!is_needed && signal == no_signal) || std::ranges::any_of(found, is_it),
                        "'{}', expected for axis {} one of: {}", signal, wire().name, list);
        });
    if (answer.empty())
      throw Error(
          fmt::format("{} missing: {}", role.option(), what),
          {.expected = found.empty() ? "a signal, but the DBC has no suitable signal" : "one of: " + list});
    if (answer == no_signal) return;
    const std::size_t dot = answer.find('.');
    map.message = answer.substr(0, dot);
    map.signals[role.name] = answer.substr(dot + 1);
    if (role.is("state")) ask_for_states(map);
  }

  /// Returns the unit that a signal with this role must have: the drive's unit, "um", or an empty text for a
  /// number.
  std::string unit_of(const Role& role) const {
    if (role.quantity == Quantity::number) return {};
    return role.quantity == Quantity::drive ? wire().drive_unit : "um";
  }

  /// Returns the signals that may have this role, such as "AmpSet.Volt [mV]". If the message of this part
  /// (command, sample or status) is known, only its unused signals are possible; otherwise the signals of all
  /// messages that no other part uses.
  std::vector<std::string> candidates(const Role& role) {
    const MessageMap& map = map_of(role.part);
    std::vector<std::string> found;
    for (const Message& message : database_.messages) {
      const bool is_other = map.message.empty()
                                ? std::ranges::count(maps_, message.name, &MessageMap::message) > 0
                                : message.name != map.message;
      for (const Signal& signal : message.signals)
        if (!is_other && may_have(role, signal) &&
            std::ranges::none_of(map.signals, [&](const auto& used) { return used.second == signal.name; }))
          found.push_back(fmt::format("{}.{}{}", message.name, signal.name,
                                      signal.unit.empty() ? "" : " [" + signal.unit + "]"));
    }
    return found;
  }

  /// Returns true if the signal can have this role: every frame of its message contains the signal, and the
  /// unit of the signal fits.
  bool may_have(const Role& role, const Signal& signal) const {
    if (!can::is_decodable(signal) || signal.multiplexing.present_at) return false;
    if (role.quantity == Quantity::number) return signal.unit.empty() || signal.length == 1;
    return !signal.unit.empty() && can::decimal_step(signal.unit, unit_of(role)).has_value();
  }

  const Signal& declared(const MessageMap& map, std::string_view role) const {
    return can::find_signal(can::find_message(database_, map), map.signals.find(role)->second);
  }

  void ask_for_states(MessageMap& map) {
    std::vector<std::string> names;
    for (const auto& [raw, name] : declared(map, "state").values)
      names.push_back(fmt::format("{} {}", raw, name));
    const Question question{fmt::format("--role {}", states_key), "Raw values of off/ready/enabled/fault", "",
                            fmt::format("example: 0/16/32/64,65 (two values of fault); in the DBC: {}",
                                        names.empty() ? "no names" : list_of(names))};
    const std::string answer = questions_.text(
        question, stated(std::string(states_key), question.option), {}, [](const std::string& text) {
          return unless(parsed_states(text).has_value(),
                        "'{}', expected raw values as 0/16/32/64,65: off, ready, enabled, and two of fault",
                        text);
        });
    if (answer.empty())
      throw Error(fmt::format("{} missing: {}, {}", question.option, question.what, question.why));
    map.states = *parsed_states(answer);
  }

  /// Moves the signals for counter and CRC from the list of signals to the integrity check of the message.
  void protect(FramePart part) {
    MessageMap& map = map_of(part);
    map.integrity = can::Integrity::none;
    if (map.carries("crc") && !map.carries("counter"))
      throw Error(fmt::format("--role {0}.counter missing: {0}.crc cannot be checked without this counter",
                              word_of(part)));
    if (map.carries("crc")) {
      map.integrity = can::Integrity::counter_crc;
      map.data_id.kind = can::DataId::Kind::none;
      if (declared(map, "crc").length == 16) map.polynomial = can::Crc::crc16;
      map.crc = map.signals.extract("crc").mapped();
    } else if (map.carries("counter")) {
      map.integrity = can::Integrity::counter;
    }
    if (map.carries("counter")) map.counter = map.signals.extract("counter").mapped();
  }

  const StageFacts& stage_;
  const can::Database& database_;
  const StatedRoles& stated_;
  std::size_t axis_;
  Questions& questions_;
  std::array<MessageMap, words(FramePart{}).size()> maps_{};
};

/// Returns each prefix P for which the database has the messages PAmpCommand, PAmpStatus and PSensorSample.
std::vector<std::string> standard_prefixes(const can::Database& database) {
  std::vector<std::string> found;
  for (const Message& message : database.messages) {
    if (!message.name.ends_with(can::AmpCommand::name)) continue;
    const std::string prefix = message.name.substr(0, message.name.size() - can::AmpCommand::name.size());
    const auto has = [&](std::string_view name) {
      return database.find(prefix + std::string(name)) != nullptr;
    };
    if (has(can::AmpStatus::name) && has(can::SensorSample::name)) found.push_back(prefix);
  }
  return found;
}

/// Returns the CANopen node number in the message's identifier; 0 if the identifier contains none.
std::uint8_t node_of(const Message& message) {
  const std::int64_t node = std::int64_t{message.id} - can::transmit_pdo_base;
  return message.extended || node < 1 || node > 127 ? std::uint8_t{0} : static_cast<std::uint8_t>(node);
}

void take_standard_frames(can::AxisWire& wire, const can::Database& database, const std::string& prefix,
                          const std::string& file) {
  const Message& command = *database.find(prefix + std::string(can::AmpCommand::name));
  if (const Signal* setpoint = command.find("Setpoint");
      setpoint != nullptr && !can::decimal_step(setpoint->unit, wire.drive_unit))
    throw Error(file, fmt::format("the unit of the setpoint in {} is {}", command.name, setpoint->unit),
                expect("{} (--unit)", wire.drive_unit));
  wire.message_prefix = prefix;
  wire.amplifier_node = node_of(*database.find(prefix + std::string(can::AmpStatus::name)));
  wire.sensor_node = node_of(*database.find(prefix + std::string(can::SensorSample::name)));
}

/// Chooses a message prefix for an axis. `left`: prefixes that no other axis has; the chosen prefix is
/// removed from this list. Returns the prefix that equals the axis's name (upper and lower case are the
/// same), or the first prefix in the list if there is none.
std::string prefix_of(const std::string& axis, std::vector<std::string>& left) {
  auto found = std::ranges::find_if(
      left, [&](const std::string& prefix) { return strcasecmp(prefix.c_str(), axis.c_str()) == 0; });
  if (found == left.end()) found = left.begin();
  std::string prefix = *found;
  left.erase(found);
  return prefix;
}

/// If the database has standard frames, assigns them to the axes and returns true. Throws Error if the
/// database has frames for fewer axes than the stage.
bool have_standard_frames(StageFacts& stage, const can::Database& database) {
  std::vector<std::string> prefixes = standard_prefixes(database);
  if (prefixes.empty()) return false;
  const std::string file = stage.config.bus.dbc.string();
  if (prefixes.size() < stage.axes.size())
    throw Error(file,
                fmt::format("has the standard frames of {} ({})", counted(prefixes.size(), "axis", "axes"),
                            fmt::join(prefixes, ", ")),
                expect("the frames of {} axes", stage.axes.size()));
  for (AxisFacts& axis : stage.axes) {
    can::AxisWire& wire = axis.config.wire;
    take_standard_frames(wire, database, prefix_of(wire.name, prefixes), file);
  }
  return true;
}

}  // namespace

void add_role(StatedRoles& roles, const std::string& text) {
  const std::string key = text.substr(0, text.find('='));
  std::vector<std::string> keys{std::string(states_key)};
  for (const Role& role : all_roles)
    if (role.own_option == nullptr) keys.push_back(role.key());
  if (key.size() == text.size() || std::ranges::count(keys, key) == 0)
    throw Error(fmt::format("--role: '{}'", text),
                expect("KEY=MSG.SIG with one of these keys: {}", fmt::join(keys, ", ")));
  roles[key].push_back(text.substr(key.size() + 1));
}

void find_frames(StageFacts& stage, const StatedRoles& stated, Questions& questions) {
  const can::Database database = can::load_dbc(stage.config.bus.dbc);
  if (have_standard_frames(stage, database)) {
    for (const auto& [key, signals] : stated)
      if (!signals.empty())
        throw Error(stage.config.bus.dbc,
                    fmt::format("has the standard frames, so a signal for {} is not allowed", key));
    return;
  }
  for (std::size_t i = 0; i < stage.axes.size(); ++i)
    stage.axes[i].config.wire.frames = FrameQuestions(stage, database, stated, i, questions).ask();
}

}  // namespace hystcan::app
