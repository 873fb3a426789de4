#include "app/command_line/decode_findings.h"

#include <fmt/format.h>

#include <algorithm>

#include "can/dbc/message_decoder.h"

namespace hystcan::app {
namespace {

using can::FrameKind;
using can::Message;

constexpr std::size_t classical_bytes = 8;

// SAE J1939-21: the parameter groups and control bytes that announce a transport.
constexpr std::uint32_t connection_management = 0xEC00;
constexpr std::uint8_t request_to_send = 16;
constexpr std::uint8_t broadcast_announce = 32;

/// Below 0xF000 the low byte is an address and not a part of the group.
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
        fmt::format("message {} has {} bytes, of which one frame shows {}: a message of several frames is "
                    "not assembled",
                    message->name, message->length, frame.length));
  for (const can::Signal& signal : message->signals)
    if (!can::is_decodable(signal))
      findings.push_back(
          fmt::format("message {}: signal {}, {}, is left out, expected 1 to 64 bits, or 32 or 64 for "
                      "an IEEE 754 number",
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
      fmt::format("message {} of {} bytes comes by the transport protocol of J1939 (PGN {}): its frames are "
                  "not assembled, and it is not decoded",
                  found->name, found->length, announced));
}

}  // namespace hystcan::app
