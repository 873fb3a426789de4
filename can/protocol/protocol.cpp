#include "can/protocol/protocol.h"

#include <algorithm>

namespace hystcan::can {
namespace {

Frame make_frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  Frame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

bool is_classical(const Frame& frame, std::uint8_t length) {
  return frame.kind == FrameKind::data && !frame.extended && frame.length == length;
}

}  // namespace

std::string_view to_string(NmtCommand command) {
  switch (command) {
    case NmtCommand::start:
      return "start";
    case NmtCommand::stop:
      return "stop";
    case NmtCommand::enter_pre_operational:
      return "enter pre-operational";
    case NmtCommand::reset_node:
      return "reset node";
    case NmtCommand::reset_communication:
      return "reset communication";
  }
  return "unknown command";
}

Frame nmt_frame(Nmt nmt) { return make_frame(nmt_id, {static_cast<std::uint8_t>(nmt.command), nmt.node}); }

Frame sync_frame(std::uint8_t counter) { return make_frame(sync_id, {counter}); }

Frame heartbeat_frame(std::uint8_t node, NmtState state) {
  return make_frame(heartbeat_base + node, {static_cast<std::uint8_t>(state)});
}

Frame emergency_frame(std::uint8_t node, Emergency emergency) {
  Frame frame = make_frame(emergency_base + node, {static_cast<std::uint8_t>(emergency.code & 0xFF),
                                                   static_cast<std::uint8_t>(emergency.code >> 8),
                                                   emergency.error_register, 0, 0, 0, 0, 0});
  std::ranges::copy(emergency.manufacturer, frame.data.begin() + 3);
  return frame;
}

std::optional<Nmt> parse_nmt(const Frame& frame) {
  if (!is_classical(frame, 2)) return std::nullopt;
  return Nmt{static_cast<NmtCommand>(frame.data[0]), frame.data[1]};
}

std::optional<std::uint8_t> parse_sync(const Frame& frame) {
  if (!is_classical(frame, 1) || !is_sync_counter(frame.data[0])) return std::nullopt;
  return frame.data[0];
}

bool is_sync(const Frame& frame) { return is_classical(frame, 0) || parse_sync(frame).has_value(); }

std::optional<NmtState> parse_heartbeat(const Frame& frame) {
  if (!is_classical(frame, 1)) return std::nullopt;
  return static_cast<NmtState>(frame.data[0]);
}

bool is_heartbeat_of(std::uint8_t node, const Frame& frame) {
  if (frame.id != heartbeat_base + node) return false;
  const auto state = parse_heartbeat(frame);
  return state == NmtState::boot_up || state == NmtState::stopped || state == NmtState::operational ||
         state == NmtState::pre_operational;
}

std::optional<Emergency> parse_emergency(const Frame& frame) {
  if (!is_classical(frame, 8)) return std::nullopt;
  Emergency emergency{.code = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8),
                      .error_register = frame.data[2]};
  std::copy_n(frame.data.begin() + 3, emergency.manufacturer.size(), emergency.manufacturer.begin());
  return emergency;
}

const Message& find_message(const Database& database, const MessageMap& map) {
  if (const Message* found = database.find(map.message)) return *found;
  throw std::invalid_argument("no message " + map.message);
}

}  // namespace hystcan::can
