#include "app/command_line/monitor_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "app/command_line/frame_text.h"
#include "base/text.h"
#include "can/dbc/message_decoder.h"

namespace hystcan::app {
namespace {

using can::MessageTraffic;
using can::Traffic;

std::string_view name_of(const MessageTraffic& traffic) {
  return traffic.message != nullptr ? std::string_view(traffic.message->name) : "(unknown)";
}

can::Rejection cause(std::size_t index) { return static_cast<can::Rejection>(index); }

std::string rejects_text(const MessageTraffic& traffic) {
  std::string text;
  for (std::size_t i = 0; i < can::rejection_count; ++i)
    if (traffic.rejected[i] > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", traffic.rejected[i], to_string(cause(i)));
  return text.empty() ? text : " [rejected: " + text + ']';
}

std::string content(const MessageTraffic& traffic) {
  if (!traffic.newest) return {};
  const can::LoggedFrame& newest = *traffic.newest;
  if (traffic.message == nullptr) {
    const std::string text = can::candump_frame(newest.frame, newest.fd_flags);
    return text.substr(text.find('#') + 1);
  }
  return signals_text(can::decode_signals(*traffic.message, newest.frame));
}

double age_ms(const BusLine& bus, const MessageTraffic& traffic) {
  return std::max(0.0, std::chrono::duration<double, std::milli>(bus.now - traffic.last).count());
}

std::string row(const Traffic::Key& key, const MessageTraffic& traffic, const BusLine& bus,
                std::size_t width) {
  const std::string jitter = traffic.jitter_ms ? fmt::format("{:.3f}", *traffic.jitter_ms) : "-";
  const std::string age = traffic.newest ? fmt::format("{:.0f}", age_ms(bus, traffic)) : "-";
  return fmt::format("{:<{}} {:>8} {:>9} {:>9.1f} {:>9} {:>8}  {}{}", name_of(traffic), width,
                     id_text(key.second, key.first), traffic.count, traffic.rate_Hz, jitter, age,
                     content(traffic), rejects_text(traffic));
}

std::string state_text(const BusLine& bus) {
  return std::string(to_string(bus.up ? bus.state : can::BusState::down));
}

}  // namespace

std::vector<std::string> monitor_lines(const BusLine& bus, const Traffic& traffic) {
  std::string top = fmt::format("{}: {}", bus.interface, state_text(bus));
  if (const auto counters = traffic.error_counters())
    top += fmt::format(", error counters transmit {} receive {}", counters->transmit, counters->receive);
  top +=
      fmt::format(", {:.1f} frames/s, {}, {}, {} lost", traffic.rate_Hz(), counted(traffic.frames(), "frame"),
                  counted(traffic.error_frames(), "error frame"), bus.lost);
  std::size_t width = 12;
  for (const auto& [key, of_message] : traffic.messages())
    width = std::max(width, name_of(of_message).size());
  std::vector<std::string> lines{
      top, fmt::format("{:<{}} {:>8} {:>9} {:>9} {:>9} {:>8}  {}", "message", width, "id", "count", "rate/Hz",
                       "jitter/ms", "age/ms", "signals")};
  lines.reserve(lines.size() + traffic.messages().size());
  for (const auto& [key, of_message] : traffic.messages()) lines.push_back(row(key, of_message, bus, width));
  return lines;
}

std::string monitor_json(const BusLine& bus, const Traffic& traffic) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, R"({{"interface":{},"state":"{}","error_counters":)", json_string(bus.interface),
                 state_text(bus));
  if (const auto counters = traffic.error_counters())
    fmt::format_to(out, R"({{"transmit":{},"receive":{}}})", counters->transmit, counters->receive);
  else
    text += "null";
  fmt::format_to(out, R"(,"rate_Hz":{},"frames":{},"error_frames":{},"lost":{},"messages":[)",
                 json_number(traffic.rate_Hz()), traffic.frames(), traffic.error_frames(), bus.lost);
  const char* between = "";
  for (const auto& [key, of_message] : traffic.messages()) {
    fmt::format_to(out, R"({}{{"message":{},"id":{},"extended":{},"count":{},"rate_Hz":{},"jitter_ms":{})",
                   between, of_message.message ? json_string(of_message.message->name) : std::string("null"),
                   key.second, key.first, of_message.count, json_number(of_message.rate_Hz),
                   of_message.jitter_ms ? json_number(*of_message.jitter_ms) : std::string("null"));
    fmt::format_to(out, R"(,"age_ms":{},"rejected":{{)",
                   of_message.newest ? json_number(age_ms(bus, of_message)) : std::string("null"));
    for (std::size_t i = 0; i < can::rejection_count; ++i)
      fmt::format_to(out, R"({}"{}":{})", i == 0 ? "" : ",", to_string(cause(i)), of_message.rejected[i]);
    text += R"(},"signals":)";
    text += signals_json(of_message.message != nullptr && of_message.newest
                             ? can::decode_signals(*of_message.message, of_message.newest->frame)
                             : std::vector<can::DecodedSignal>());
    text += '}';
    between = ",";
  }
  return text + "]}\n";
}

}  // namespace hystcan::app
