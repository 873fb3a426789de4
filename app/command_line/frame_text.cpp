#include "app/command_line/frame_text.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "can/log/error_words.h"

namespace hystcan::app {
namespace {

using can::DecodedSignal;
using can::FrameKind;
using can::LoggedFrame;
using can::Message;

std::string time_text(std::chrono::microseconds time) {
  return fmt::format("{}.{:06}", time.count() / 1'000'000, time.count() % 1'000'000);
}

/// Length of the UTF-8 sequence at the beginning; 0 if there is none. Overlong forms and surrogates are
/// invalid.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  const bool overlong = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xF0 && byte(1) < 0x90);
  const bool beyond = (first == 0xED && byte(1) >= 0xA0) || (first == 0xF4 && byte(1) >= 0x90);
  return overlong || beyond ? 0 : length;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      result += c;
    } else {
      result += static_cast<char>(0xC0U | code >> 6U);
      result += static_cast<char>(0x80U | (code & 0x3FU));
    }
  }
  return result;
}

/// Replaces control characters, which would break a line in two.
std::string in_one_line(std::string_view text) {
  std::string result = utf8(text);
  for (char& c : result)
    if (static_cast<unsigned char>(c) < 0x20 || c == '\x7F') c = ' ';
  return result;
}

std::string csv_field(std::string_view text) {
  std::string field = in_one_line(text);
  if (field.find_first_of(",\"") == std::string::npos) return field;
  std::string quoted = "\"";
  for (const char c : field) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

/// The sign of nan has no meaning and is left out.
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

/// The reason why a frame carries only a part of its message; empty if it carries all.
std::string shortcoming(const can::Frame& frame, const Message& message) {
  if (frame.kind == FrameKind::remote) return "remote";
  if (frame.length < message.length) return fmt::format("{} of {} bytes", frame.length, message.length);
  return {};
}

}  // namespace

std::string id_text(std::uint32_t id, bool extended) { return fmt::format("{:0{}X}", id, extended ? 8 : 3); }

std::string json_string(std::string_view text) { return nlohmann::json(utf8(text)).dump(); }

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
    line_ += can::candump_frame(frame, logged.fd_flags) + " (no message of the database)";
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

}  // namespace hystcan::app
