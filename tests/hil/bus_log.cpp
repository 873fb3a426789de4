#include "tests/hil/bus_log.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace hystcan::hil {
namespace {

using nlohmann::json;

struct Logged {
  double time_s = 0.0;
  unsigned identifier = 0;
  bool classical = false;  ///< a data frame of at most 8 bytes with a standard identifier
  std::vector<std::uint8_t> data;
};

unsigned hexadecimal(std::string_view digits) {
  unsigned value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  return value;
}

/// Parses a line such as "(1795553094.195982) vcan0 201#4E61BC00010703D9".
std::optional<Logged> logged(std::string_view line) {
  const std::size_t time_end = line.find(')');
  const std::size_t interface_end = line.rfind(' ');
  const std::size_t separator = line.find('#');
  if (!line.starts_with('(') || time_end >= interface_end || separator == line.npos ||
      interface_end > separator)
    return std::nullopt;
  Logged frame;
  std::from_chars(line.data() + 1, line.data() + time_end, frame.time_s);
  const std::string_view identifier = line.substr(interface_end + 1, separator - interface_end - 1);
  const std::string_view payload = line.substr(separator + 1);
  frame.identifier = hexadecimal(identifier);
  frame.classical = identifier.size() == 3 && !payload.starts_with('#') && !payload.starts_with('R');
  for (std::size_t i = 0; frame.classical && i + 1 < payload.size(); i += 2)
    frame.data.push_back(static_cast<std::uint8_t>(hexadecimal(payload.substr(i, 2))));
  return frame;
}

/// CRC-8 SAE J1850 over the identifier, low byte first, and the first seven bytes of the payload.
unsigned crc_of(const Logged& frame) {
  unsigned crc = 0xFF;
  const auto append = [&](unsigned byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x80) != 0 ? crc << 1 ^ 0x1D : crc << 1) & 0xFF;
  };
  append(frame.identifier & 0xFF);
  append(frame.identifier >> 8);
  for (int i = 0; i < 7; ++i) append(frame.data[static_cast<std::size_t>(i)]);
  return crc ^ 0xFF;
}

struct Message {
  std::string axis;  ///< empty: the message belongs to no axis
  std::string name;
  std::size_t length = 8;
  bool has_value = false;  ///< bytes 0 to 3 are a value in units of 10^-6, byte 6 is a counter, byte 7 is a
                           ///< CRC
  std::string full_name() const { return axis + name; }
};

std::map<unsigned, Message> messages() {
  std::map<unsigned, Message> all{{0x000, {.axis = "", .name = "Nmt", .length = 2}},
                                  {0x080, {.axis = "", .name = "Sync", .length = 1}},
                                  {0x77F, {.axis = "", .name = "ControllerHeartbeat", .length = 1}}};
  for (const auto& [axis, amplifier, sensor] : {std::tuple{"X", 1U, 2U}, std::tuple{"Y", 3U, 4U}}) {
    all[0x080 + amplifier] = {.axis = axis, .name = "AmpEmcy"};
    all[0x080 + sensor] = {.axis = axis, .name = "SensorEmcy"};
    all[0x180 + amplifier] = {.axis = axis, .name = "AmpStatus", .has_value = true};
    all[0x180 + sensor] = {.axis = axis, .name = "SensorSample", .has_value = true};
    all[0x200 + amplifier] = {.axis = axis, .name = "AmpCommand", .has_value = true};
    all[0x280 + amplifier] = {.axis = axis, .name = "ControllerStatus", .has_value = true};
    all[0x300 + amplifier] = {.axis = axis, .name = "Setpoint", .has_value = true};
    all[0x700 + amplifier] = {.axis = axis, .name = "AmpHeartbeat", .length = 1};
    all[0x700 + sensor] = {.axis = axis, .name = "SensorHeartbeat", .length = 1};
  }
  return all;
}

constexpr std::array states{"offline", "waiting", "initialising", "ready", "tracking", "faulted"};

class Findings {
 public:
  explicit Findings(bool series) : with_series_(series) {
    for (const char* axis : {"X", "Y"}) {
      result_["axis_states"][axis] = json::array();
      result_["last_axis_status"][axis] = nullptr;
    }
    for (const char* name :
         {"last_command", "last_enabled_command", "last_status", "first_fault", "drive_range"})
      result_[name] = nullptr;
    result_["seen"] = result_["wrong"] = json::object();
  }

  void add(const Logged& frame) {
    const auto known = messages_.find(frame.identifier);
    if (known == messages_.end() || !frame.classical) return is_wrong("unknown frame");
    const Message& message = known->second;
    count(result_["seen"], message.full_name());
    if (frame.data.size() != message.length) return is_wrong("length");
    if (message.has_value) add_value(frame, message);
  }

  json result() && {
    if (with_series_) result_["series"] = std::move(series_);
    return std::move(result_);
  }

 private:
  static void count(json& counts, const std::string& name) { counts[name] = counts.value(name, 0) + 1; }
  void is_wrong(const std::string& what) { count(result_["wrong"], what); }

  void add_value(const Logged& frame, const Message& message) {
    const auto& data = frame.data;
    const bool is_axis_status = message.name == "ControllerStatus";
    const unsigned counter = is_axis_status ? data[6] & 0x0FU : data[6];
    if (data[7] != crc_of(frame)) is_wrong("crc");
    const auto last = last_counter_.find(frame.identifier);
    if (last != last_counter_.end() && counter != (last->second + 1) % 16) is_wrong("counter");
    last_counter_[frame.identifier] = counter;
    const auto raw = static_cast<std::int32_t>(std::uint32_t{data[0]} | std::uint32_t{data[1]} << 8 |
                                               std::uint32_t{data[2]} << 16 | std::uint32_t{data[3]} << 24);
    const double value = raw * 1e-6;
    if (is_axis_status && !add_axis_status(message.axis, value, data)) return;
    if (with_series_)
      series_[message.axis][message.name].push_back(json::array({frame.time_s, value, data[4]}));
    if (message.full_name() == "XAmpStatus") add_status(frame, value);
    if (message.full_name() == "XAmpCommand") add_command(frame, value);
  }

  bool add_axis_status(const std::string& axis, double value, const std::vector<std::uint8_t>& data) {
    if (data[4] >= states.size() || (data[6] & 0x80) != 0) {
      is_wrong("axis status");
      return false;
    }
    const char* state = states[data[4]];
    json& passed = result_["axis_states"][axis];
    if (passed.empty() || passed.back() != state) passed.push_back(state);
    result_["last_axis_status"][axis] = {
        {"state", state}, {"cause", data[5]}, {"following_error", value}, {"limited", data[6] >> 5 & 1}};
    return true;
  }

  void add_status(const Logged& frame, double value) {
    json status{
        {"time_s", frame.time_s}, {"output", value}, {"state", frame.data[4]}, {"fault", frame.data[5]}};
    if (frame.data[4] == 3 && result_["first_fault"].is_null()) result_["first_fault"] = status;
    result_["last_status"] = std::move(status);
  }

  void add_command(const Logged& frame, double value) {
    const int enable = frame.data[4] & 1;
    const json command{{"time_s", frame.time_s}, {"setpoint", value}, {"enable", enable}};
    if (enable == 1) result_["last_enabled_command"] = command;
    json& range = result_["drive_range"];
    if (range.is_null()) range = json::array({value, value});
    range[0] = std::min(range[0].get<double>(), value);
    range[1] = std::max(range[1].get<double>(), value);
    result_["last_command"] = command;
  }

  const std::map<unsigned, Message> messages_ = messages();
  bool with_series_;
  std::map<unsigned, unsigned> last_counter_;
  json series_;
  json result_;
};

}  // namespace

json decoded(const std::string& log, bool series) {
  Findings findings(series);
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    const std::optional<Logged> frame = logged(line);
    if (!frame) return nullptr;
    findings.add(*frame);
  }
  return std::move(findings).result();
}

}  // namespace hystcan::hil
