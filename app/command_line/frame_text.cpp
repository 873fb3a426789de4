#include "app/command_line/frame_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "can/dbc/text.h"
#include "can/log/error_frame.h"
#include "config/files/csv.h"

namespace hystcan::app {
namespace {

using can::DecodedSignal;
using can::FrameKind;
using can::LoggedFrame;
using can::Message;

std::string time_text(std::chrono::microseconds time) {
  return fmt::format("{}.{:06}", time.count() / 1'000'000, time.count() % 1'000'000);
}

std::string in_one_line(std::string_view text) { return config::in_one_line(can::dbc::to_utf8(text)); }
std::string csv_field(std::string_view text) { return config::csv_field(can::dbc::to_utf8(text)); }

/// Formats a number with 17 significant digits, or as "nan" without its sign, which has no meaning.
std::string csv_number(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.17g}", value); }

std::string_view kind_text(FrameKind kind) {
  switch (kind) {
    case FrameKind::data:
      return "data";
    case FrameKind::remote:
      return "remote";
    case FrameKind::fd:
      return "fd";
    case FrameKind::error:
      return "error";
  }
  return "unknown";
}

/// Returns the reason why a frame does not contain its whole message: it is a remote frame or too short.
/// Returns an empty text for a complete frame.
std::string shortcoming(const can::Frame& frame, const Message& message) {
  if (frame.kind == FrameKind::remote) return "remote";
  if (frame.length < message.length) return fmt::format("{} of {} bytes", frame.length, message.length);
  return {};
}

constexpr std::size_t classical_bytes = 8;

// SAE J1939-21 sends a message that is longer than a frame in several frames. A frame of the parameter group
// `connection_management` announces such a message. The first byte of this frame (control byte) is
// `request_to_send` for a message to one node, or `broadcast_announce` for a message to all nodes.
constexpr std::uint32_t connection_management = 0xEC00;
constexpr std::uint8_t request_to_send = 16;
constexpr std::uint8_t broadcast_announce = 32;

/// Returns the J1939 parameter group number (PGN) in an extended identifier. In groups below 0xF000, the low
/// byte is the destination address, so it is set to 0.
std::uint32_t parameter_group(std::uint32_t id) {
  const std::uint32_t group = id >> 8U & 0x3FFFFU;
  return (group & 0xFF00U) < 0xF000U ? group & 0x3FF00U : group;
}

std::string kind_of(const can::Signal& signal) {
  if (signal.value_type == can::ValueType::unreadable)
    return fmt::format("declared as an IEEE 754 number of {} bits", signal.length);
  return fmt::format("of {} bits", signal.length);
}

}  // namespace

std::string id_text(std::uint32_t id, bool extended) { return fmt::format("{:0{}X}", id, extended ? 8 : 3); }

std::string json_string(std::string_view text) { return nlohmann::json(can::dbc::to_utf8(text)).dump(); }

std::string json_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.17g}", value) : std::string("null");
}

std::string raw_text(const DecodedSignal& decoded) {
  const bool bits = decoded.signal->value_type != can::ValueType::integer || !decoded.signal->is_signed;
  return bits ? std::to_string(static_cast<std::uint64_t>(decoded.raw)) : std::to_string(decoded.raw);
}

std::string signals_text(const std::vector<DecodedSignal>& signals) {
  std::string text;
  for (const DecodedSignal& decoded : signals) {
    text += fmt::format("{}{}={:.12g}", text.empty() ? "" : ", ", decoded.signal->name, decoded.physical);
    if (!decoded.signal->unit.empty()) text += ' ' + in_one_line(decoded.signal->unit);
    if (!decoded.name.empty()) text += " (" + in_one_line(decoded.name) + ')';
  }
  return text;
}

std::string signals_json(const std::vector<DecodedSignal>& signals) {
  std::string text = "{";
  for (const DecodedSignal& decoded : signals)
    fmt::format_to(std::back_inserter(text), R"({}{}:{{"raw":{},"value":{},"unit":{},"name":{}}})",
                   text.size() == 1 ? "" : ",", json_string(decoded.signal->name), raw_text(decoded),
                   json_number(decoded.physical), json_string(decoded.signal->unit),
                   decoded.name.empty() ? std::string("null") : json_string(decoded.name));
  return text + '}';
}

std::string fd_flags_json(const can::Frame& frame) {
  if (frame.kind != FrameKind::fd) return {};
  return fmt::format(R"(,"brs":{},"esi":{})", (frame.fd_flags & can::fd_bit_rate_switch) != 0,
                     (frame.fd_flags & can::fd_error_state) != 0);
}

const std::string& FrameText::operator()(const LoggedFrame& logged) {
  line_.clear();
  const bool error = logged.frame.kind == FrameKind::error;
  if (error) {
    const auto drops = can::drops_reported_by(logged.frame);
    lost_ += drops.value_or(0);
    if (!drops) ++error_frames_;
  } else {
    ++frames_;
  }
  const Message* message = error ? nullptr : can::message_of(database_, logged.frame);
  if (!error && message == nullptr) ++unknown_;
  if (format_ == FrameFormat::text) write_text(logged, message);
  if (format_ == FrameFormat::csv && message != nullptr) write_csv(logged, *message);
  if (format_ == FrameFormat::json) write_json(logged, message);
  return line_;
}

void FrameText::write_text(const LoggedFrame& logged, const Message* message) {
  const can::Frame& frame = logged.frame;
  fmt::format_to(std::back_inserter(line_), "({}) {} ", time_text(logged.time), logged.interface);
  if (frame.kind == FrameKind::error) {
    line_ += "error: " + can::describe_error(frame);
  } else if (message == nullptr) {
    line_ += can::candump_frame(frame) + " (no message of the database)";
  } else {
    line_ += message->name;
    const std::string signals = signals_text(can::decode_signals(*message, frame));
    if (!signals.empty()) line_ += ' ' + signals;
    if (const std::string why = shortcoming(frame, *message); !why.empty()) line_ += " [" + why + ']';
  }
  line_ += '\n';
}

void FrameText::write_csv(const LoggedFrame& logged, const Message& message) {
  for (const DecodedSignal& decoded : can::decode_signals(message, logged.frame))
    fmt::format_to(std::back_inserter(line_), "{},{},{},{},{},{},{},{},{}\n", time_text(logged.time),
                   csv_field(logged.interface), id_text(logged.frame.id, logged.frame.extended), message.name,
                   decoded.signal->name, raw_text(decoded), csv_number(decoded.physical),
                   csv_field(decoded.signal->unit), csv_field(decoded.name));
}

void FrameText::write_json(const LoggedFrame& logged, const Message* message) {
  const can::Frame& frame = logged.frame;
  const auto out = std::back_inserter(line_);
  fmt::format_to(out, R"({{"time_s":{},"interface":{},"kind":"{}","id":{},"extended":{},"data":")",
                 time_text(logged.time), json_string(logged.interface), kind_text(frame.kind), frame.id,
                 frame.extended);
  if (frame.kind != FrameKind::remote)
    for (const std::uint8_t byte : frame.payload()) fmt::format_to(out, "{:02X}", byte);
  line_ += '"';
  line_ += fd_flags_json(frame);
  if (frame.kind == FrameKind::error) {
    fmt::format_to(out, R"(,"error":{})", json_string(can::describe_error(frame)));
    if (const auto drops = can::drops_reported_by(frame)) fmt::format_to(out, R"(,"lost":{})", *drops);
  } else if (message == nullptr) {
    line_ += R"(,"message":null)";
  } else {
    fmt::format_to(out, R"(,"message":{},"signals":{})", json_string(message->name),
                   signals_json(can::decode_signals(*message, frame)));
  }
  line_ += "}\n";
}

std::vector<std::string> DecodeFindings::add(const can::LoggedFrame& logged) {
  std::vector<std::string> findings;
  const can::Frame& frame = logged.frame;
  if (frame.kind == FrameKind::error || frame.kind == FrameKind::remote) return findings;
  examine_transport(frame, findings);
  const Message* message = can::message_of(database_, frame);
  if (message == nullptr || !decoded_.insert(message).second) return findings;
  const std::size_t one_frame = frame.kind == FrameKind::fd ? frame.data.size() : classical_bytes;
  if (message->length > one_frame)
    findings.push_back(
        fmt::format("message {} has {} bytes, a frame at most {}: "
                    "hystcan does not join the frames of a message",
                    message->name, message->length, frame.length));
  for (const can::Signal& signal : message->signals)
    if (!can::is_decodable(signal))
      findings.push_back(
          fmt::format("message {}: signal {}, {}, is not decoded, "
                      "expected 1 to 64 bits, or 32 or 64 for an IEEE 754 number",
                      message->name, signal.name, kind_of(signal)));
  return findings;
}

void DecodeFindings::examine_transport(const can::Frame& frame, std::vector<std::string>& findings) {
  if (!frame.extended || frame.length != 8 || parameter_group(frame.id) != connection_management) return;
  if (frame.data[0] != request_to_send && frame.data[0] != broadcast_announce) return;
  const std::uint32_t announced =
      frame.data[5] | std::uint32_t{frame.data[6]} << 8U | std::uint32_t{frame.data[7]} << 16U;
  const auto found = std::ranges::find_if(database_.messages, [&](const Message& message) {
    return message.extended && message.length > classical_bytes && parameter_group(message.id) == announced;
  });
  if (found == database_.messages.end() || !transported_.insert(announced).second) return;
  findings.push_back(
      fmt::format("message {} of {} bytes uses the transport protocol of J1939 (PGN {}), "
                  "which hystcan does not decode",
                  found->name, found->length, announced));
}

}  // namespace hystcan::app
