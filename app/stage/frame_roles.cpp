#include "app/stage/frame_roles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>

#include "app/stage/signal_likeness.h"
#include "base/error.h"
#include "base/text.h"
#include "can/protocol/protocol.h"

namespace hystcan::app {
namespace {

using can::Message;
using can::MessageMap;
using can::Signal;

const Words command_words{"set",  "cmd",     "command", "target", "demand",
                          "soll", "request", "ctrl",    "drive",  "ref"};
const Words status_words{"get", "act",    "actual",   "meas", "monitor", "read",
                         "ist", "status", "feedback", "out",  "state"};
const Words position_words{"pos",  "position", "disp", "displacement", "weg",
                           "sens", "sensor",   "meas", "gap",          "stroke"};

const Words counter_words{"counter", "cnt", "alive", "rolling", "seq", "count"};
const Words crc_words{"crc", "checksum", "chk"};
const Words reserved_words{"reserve", "rsvd", "spare", "unused", "pad", "dummy"};

/// In the order in which they are tried. The wider ones name a single bit, and nothing that switches off.
const Words enable_words{"enable", "en", "on", "active", "enabled", "freigabe"};
const Words wider_enable_words{"ena",    "enb", "enbl", "activ",   "power",   "pwr",
                               "output", "hv",  "run",  "operate", "release", "einschalt"};
const Words off_words{"disable", "inhibit", "off", "stop", "not"};

bool is_in_every_frame(const Signal& signal) {
  return can::is_decodable(signal) && !signal.multiplexing.present_at;
}

/// One message's roles beside the one that it was found by.
class Roles {
 public:
  Roles(AxisFacts& into, std::string of, const Message& message)
      : into_(into), of_(std::move(of)), message_(message) {
    map_.message = message.name;
  }

  void take(const char* role, const Signal& signal, const std::string& because) {
    map_.signals[role] = signal.name;
    used_.insert(&signal);
    into_.roles.push_back({of_ + "." + role, message_.name, signal.name, because});
  }
  /// A signal without unit that has one of the words and none of the others. Null: not found, and listed so.
  const Signal* look_for(const char* role, const Words& words, const Words& others = {}) {
    const Signal* found = unlisted(words, others);
    if (found != nullptr)
      take(role, *found, std::string(word_in(found->name, words)));
    else
      miss(role);
    return found;
  }
  const Signal* unlisted(const Words& words, const Words& others = {}) const {
    for (const Signal& signal : message_.signals)
      if (!used_.contains(&signal) && is_in_every_frame(signal) && !word_in(signal.name, words).empty() &&
          word_in(signal.name, others).empty())
        return &signal;
    return nullptr;
  }
  void miss(const std::string& role) { into_.not_found.push_back(of_ + "." + role); }

  void look_for_enable();
  void states(const Signal& signal);
  MessageMap finished();

 private:
  AxisFacts& into_;
  std::string of_;
  const Message& message_;
  MessageMap map_;
  std::set<const Signal*> used_;
};

/// By its name, where that is unambiguous. It is a number without a unit, or a bit. One that is neither
/// counter nor CRC nor reserved, and has another name, may be it too.
void Roles::look_for_enable() {
  std::vector<const Signal*> left, named;
  for (const Signal& signal : message_.signals)
    if (!used_.contains(&signal) && is_in_every_frame(signal) &&
        (signal.unit.empty() || signal.length == 1) && signal.length <= 8 &&
        word_in(signal.name, counter_words).empty() && word_in(signal.name, crc_words).empty() &&
        word_in(signal.name, reserved_words).empty())
      left.push_back(&signal);
  for (const Signal* signal : left) into_.enable_candidates.push_back(signal->name);
  const auto is_bit = [](const Signal* signal) { return signal->length == 1; };
  std::ranges::copy_if(left, std::back_inserter(named),
                       [](const Signal* signal) { return !word_in(signal->name, enable_words).empty(); });
  if (named.size() > 1 && std::ranges::count_if(named, is_bit) == 1)
    std::erase_if(named, [&](const Signal* signal) { return !is_bit(signal); });
  if (named.empty())
    std::ranges::copy_if(left, std::back_inserter(named), [&](const Signal* signal) {
      return is_bit(signal) && !word_in(signal->name, wider_enable_words).empty() &&
             word_in(signal->name, off_words).empty();
    });
  if (named.size() == 1)
    take("enable", *named.front(), "its name");
  else if (left.empty())
    miss("enable");
}

/// Raw values of the states by their names in the DBC.
void Roles::states(const Signal& signal) {
  can::StateValues found{{}, {}, {}, {}};
  for (const auto& [raw, name] : signal.values) {
    if (!word_in(name, {"fault", "error", "trip", "over", "under", "watchdog", "alarm", "timeout", "fail"})
             .empty())
      found.fault.push_back(raw);
    else if (!word_in(name, {"ready", "standby", "stby", "idle", "init"}).empty())
      found.ready.push_back(raw);
    else if (!word_in(name, {"off", "disabled", "inactive", "stopped"}).empty())
      found.off.push_back(raw);
    else if (!word_in(name, {"on", "enabled", "active", "run", "operational", "operating"}).empty())
      found.enabled.push_back(raw);
  }
  if (found.enabled.empty() || found.off.empty()) {
    miss(fmt::format("state (the DBC does not name the values of {})", signal.name));
    return;
  }
  for (std::vector<std::int64_t>* raw : {&found.ready, &found.fault})
    if (raw->empty()) raw->push_back(found.off.front());
  take("state", signal, "names of its values");
  map_.states = found;
}

/// With the message's counter and CRC.
MessageMap Roles::finished() {
  const Signal* counter = unlisted(counter_words, {"sync", "error"});
  const Signal* crc = unlisted(crc_words);
  map_.integrity = can::Integrity::none;
  if (counter != nullptr) {
    map_.integrity = crc != nullptr ? can::Integrity::counter_crc : can::Integrity::counter;
    map_.counter = counter->name;
    into_.roles.push_back({of_ + ".counter", message_.name, counter->name, "counts frames"});
  }
  if (crc != nullptr && counter != nullptr) {
    map_.crc = crc->name;
    map_.data_id.kind = can::DataId::Kind::none;
    if (crc->length == 16) map_.polynomial = can::Crc::crc16;
    into_.roles.push_back({of_ + ".crc", message_.name, crc->name,
                           fmt::format("{} of the payload, assumed", word_of(map_.polynomial))});
    miss("crc's polynomial and what it covers: a DBC does not say that");
  } else if (crc != nullptr) {
    miss("counter, without which " + crc->name + " is not checked");
  }
  return map_;
}

MessageMap command_of(AxisFacts& axis, const LikeSignal& setpoint) {
  Roles found(axis, "command", *setpoint.message);
  found.take("setpoint", *setpoint.signal, setpoint.because);
  found.look_for("clear_fault", {"clear", "rst", "reset", "ack", "clr"});
  found.look_for("sync_counter", {"sync"});
  found.look_for_enable();
  return found.finished();
}

std::optional<MessageMap> status_of(AxisFacts& axis, const LikeSignal& output) {
  if (output.message == nullptr) {
    axis.not_found.emplace_back("status (output, state, fault)");
    return std::nullopt;
  }
  Roles found(axis, "status", *output.message);
  found.take("output", *output.signal, output.because);
  const Signal* state = found.unlisted({"state", "st", "status", "mode"});
  if (state != nullptr)
    found.states(*state);
  else
    found.miss("state");
  found.look_for("fault", {"fault", "error", "err", "alarm"});
  return found.finished();
}

MessageMap sample_of(AxisFacts& axis, const LikeSignal& position) {
  Roles found(axis, "sample", *position.message);
  found.take("position", *position.signal, position.because);
  found.look_for("status", {"status", "err", "error", "state", "fault"}, {"valid"});
  found.look_for("sync_counter", {"sync"});
  return found.finished();
}

/// "AmpSet.Volt [mV], ..." of everything in this unit.
std::string all_in(const can::Database& database, std::string_view unit) {
  std::vector<std::string> found;
  for (const Message& message : database.messages)
    for (const Signal& signal : message.signals)
      if (converts(signal, unit))
        found.push_back(fmt::format("{}.{} [{}]", message.name, signal.name, signal.unit));
  if (found.empty()) return "it has no signal in that unit";
  constexpr std::size_t most = 12;
  const std::size_t shown = std::min(found.size(), most);
  return fmt::format("it has {}{}",
                     fmt::join(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     shown < found.size() ? fmt::format(" and {} more", found.size() - shown) : "");
}

void require(const LikeSignal& choice, const std::string& axis, const char* role, std::string_view unit,
             const can::Database& database, const std::string& file) {
  if (choice.message != nullptr) return;
  throw Error(fmt::format("{}: axis {} has no signal like a {} in {}, expected one: {}", file, axis, role,
                          unit, all_in(database, unit)));
}

/// The prefixes P of PAmpCommand, PAmpStatus, PSensorSample.
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

/// 0: its identifier does not say it.
std::uint8_t node_of(const Message& message) {
  const std::int64_t node = std::int64_t{message.id} - can::transmit_pdo_base;
  return message.extended || node < 1 || node > 127 ? std::uint8_t{0} : static_cast<std::uint8_t>(node);
}

void take_standard_frames(can::AxisWire& wire, const can::Database& database, const std::string& prefix,
                          const std::string& file) {
  const Message& command = *database.find(prefix + std::string(can::AmpCommand::name));
  if (const Signal* setpoint = command.find("Setpoint");
      setpoint != nullptr && !converts(*setpoint, wire.drive_unit))
    throw Error(fmt::format("{}: the setpoint of {} is in {}, expected {} (--unit)", file, command.name,
                            setpoint->unit, wire.drive_unit));
  wire.message_prefix = prefix;
  wire.amplifier_node = node_of(*database.find(prefix + std::string(can::AmpStatus::name)));
  wire.sensor_node = node_of(*database.find(prefix + std::string(can::SensorSample::name)));
}

/// The prefix that is the axis's name, else the next one that is not yet taken.
std::string prefix_of(const std::string& axis, std::vector<std::string>& left) {
  auto found = std::ranges::find(left, in_lower_case(axis),
                                 [](const std::string& prefix) { return in_lower_case(prefix); });
  if (found == left.end()) found = left.begin();
  std::string prefix = *found;
  left.erase(found);
  return prefix;
}

}  // namespace

std::vector<AxisFacts> propose_roles(const can::Database& database, std::vector<AxisFacts> axes,
                                     const std::string& file) {
  std::vector<std::string> prefixes = standard_prefixes(database);
  if (prefixes.size() >= axes.size()) {
    for (AxisFacts& axis : axes) {
      can::AxisWire& wire = axis.config.wire;
      take_standard_frames(wire, database, prefix_of(wire.name, prefixes), file);
    }
    return axes;
  }
  if (!prefixes.empty())
    throw Error(fmt::format("{}: it has the standard frames of {} ({}), expected those of {} axes", file,
                            counted(prefixes.size(), "axis", "axes"), fmt::join(prefixes, ", "),
                            axes.size()));
  std::set<const Message*> taken;
  const auto take = [&taken](LikeSignal found) {
    if (found.message != nullptr) taken.insert(found.message);
    return found;
  };
  const Words drive_names{"volt", "voltage", "u", "v", "current", "i"};
  for (AxisFacts& axis : axes) {
    can::AxisWire& wire = axis.config.wire;
    const controller::Gate::Config& gate = axis.config.control.gate;
    const model::Interval drives{gate.drive_min, gate.drive_max};
    const LikeSignals likeness(database, axes.size() == 1 ? "" : wire.name, taken);
    const LikeSignal setpoint =
        take(likeness.best(wire.drive_unit, drives, command_words, status_words, drive_names));
    require(setpoint, wire.name, "setpoint", wire.drive_unit, database, file);
    const LikeSignal position =
        take(likeness.best("um", axis.travel_um, position_words, command_words, {"x", "y", "z"}));
    require(position, wire.name, "position", "um", database, file);
    const LikeSignal output =
        take(likeness.best(wire.drive_unit, drives, status_words, command_words, drive_names));
    wire.frames = can::AxisFrames{.command = command_of(axis, setpoint),
                                  .status = status_of(axis, output),
                                  .sample = sample_of(axis, position)};
  }
  return axes;
}

bool asks_for_enable(const AxisFacts& axis) {
  return !axis.enable_candidates.empty() && !axis.config.wire.frames->command.carries("enable");
}

void state_enable(AxisFacts& axis, const std::string& signal) {
  can::MessageMap& command = axis.config.wire.frames->command;
  command.signals.erase("enable");
  std::erase_if(axis.roles, [](const AxisFacts::Row& row) { return row.role == "command.enable"; });
  if (signal == no_enable) {
    axis.not_found.emplace_back("command.enable: there is none, as stated");
    return;
  }
  command.signals["enable"] = signal;
  axis.roles.push_back({"command.enable", command.message, signal, "stated"});
}

std::string table_of(const AxisFacts& axis) {
  const can::AxisWire& wire = axis.config.wire;
  if (!wire.frames)
    return fmt::format("axis {}: the standard frames, {}AmpCommand and so on\n", wire.name,
                       wire.message_prefix);
  std::string text = fmt::format("axis {}: by likeness of names and units\n  {:<22} {:<20} {:<20} {}\n",
                                 wire.name, "role", "message", "signal", "because of");
  for (const AxisFacts::Row& row : axis.roles)
    text += fmt::format("  {:<22} {:<20} {:<20} {}\n", row.role, row.message, row.signal, row.because);
  for (const std::string& role : axis.not_found) text += fmt::format("  not found: {}\n", role);
  return text;
}

}  // namespace hystcan::app
