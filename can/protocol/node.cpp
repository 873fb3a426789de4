#include "can/protocol/node.h"

#include <algorithm>
#include <utility>

namespace hystcan::can {
namespace {

Frame node_frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  Frame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size())};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

bool is_classical(const Frame& frame, std::uint8_t length) {
  return frame.kind == FrameKind::data && !frame.extended && frame.length == length;
}

using ErrorText = std::pair<std::uint16_t, std::string_view>;
constexpr std::array emergency_texts{
    ErrorText{0x0000, "error reset, or no error"},
    ErrorText{0x1000, "generic error"},
    ErrorText{0x2000, "current"},
    ErrorText{0x2100, "current, device input side"},
    ErrorText{0x2200, "current inside the device"},
    ErrorText{0x2300, "current, device output side"},
    ErrorText{0x3000, "voltage"},
    ErrorText{0x3100, "mains voltage"},
    ErrorText{0x3200, "voltage inside the device"},
    ErrorText{0x3300, "output voltage"},
    ErrorText{0x4000, "temperature"},
    ErrorText{0x4100, "ambient temperature"},
    ErrorText{0x4200, "device temperature"},
    ErrorText{0x5000, "device hardware"},
    ErrorText{0x6000, "device software"},
    ErrorText{0x6100, "internal software"},
    ErrorText{0x6200, "user software"},
    ErrorText{0x6300, "data set"},
    ErrorText{0x7000, "additional modules"},
    ErrorText{0x8000, "monitoring"},
    ErrorText{0x8100, "communication"},
    ErrorText{0x8110, "CAN overrun, objects lost"},
    ErrorText{0x8120, "CAN in error-passive mode"},
    ErrorText{0x8130, "life guard or heartbeat error"},
    ErrorText{0x8140, "recovered from bus-off"},
    ErrorText{0x8150, "CAN identifier collision"},
    ErrorText{0x8200, "protocol error"},
    ErrorText{0x8210, "PDO not processed, length error"},
    ErrorText{0x8220, "PDO length exceeded"},
    ErrorText{0x8230, "multiplex PDO not processed, destination object not available"},
    ErrorText{0x8240, "unexpected SYNC data length"},
    ErrorText{0x8250, "RPDO timeout"},
    ErrorText{0x9000, "external error"},
    ErrorText{0xF000, "additional functions"},
    ErrorText{0xFF00, "device-specific"},
};

}  // namespace

std::string_view to_string(NmtCommand command) {
  constexpr std::array names{std::pair(NmtCommand::start, "start"), std::pair(NmtCommand::stop, "stop"),
                             std::pair(NmtCommand::enter_pre_operational, "enter pre-operational"),
                             std::pair(NmtCommand::reset_node, "reset node"),
                             std::pair(NmtCommand::reset_communication, "reset communication")};
  for (const auto& [each, name] : names)
    if (each == command) return name;
  return "unknown command";
}

Frame nmt_frame(Nmt nmt) { return node_frame(nmt_id, {static_cast<std::uint8_t>(nmt.command), nmt.node}); }

Frame sync_frame(std::uint8_t counter) { return node_frame(sync_id, {counter}); }

Frame heartbeat_frame(std::uint8_t node, NmtState state) {
  return node_frame(heartbeat_base + node, {static_cast<std::uint8_t>(state)});
}

Frame emergency_frame(std::uint8_t node, Emergency emergency) {
  Frame frame = node_frame(emergency_base + node, {static_cast<std::uint8_t>(emergency.code & 0xFF),
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
  if (frame.id != sync_id || !is_classical(frame, 1) || !is_sync_counter(frame.data[0])) return std::nullopt;
  return frame.data[0];
}

bool is_sync(const Frame& frame) {
  return (frame.id == sync_id && is_classical(frame, 0)) || parse_sync(frame).has_value();
}

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

std::string_view emergency_text(std::uint16_t code) {
  for (const unsigned mask : {0xFFFFU, 0xFF00U, 0xF000U}) {
    const unsigned group = code & mask;
    if (group == 0 && code != 0) continue;  // only the code 0x0000 has the text "no error"
    const auto found = std::ranges::find(emergency_texts, group, &ErrorText::first);
    if (found != emergency_texts.end()) return found->second;
  }
  return "reserved error code";
}

NmtSlave::NmtSlave(Bus& bus, Scheduler& scheduler, std::uint8_t node, Duration heartbeat_period,
                   ChangeHandler on_change)
    : bus_(bus),
      node_(node),
      scheduler_(scheduler),
      period_(heartbeat_period),
      on_change_(std::move(on_change)),
      heartbeat_(scheduler.make_timer([this] { beat(); })) {}

void NmtSlave::boot_up(NmtCommand reset) {
  if (id_taken_) return;
  last_reset_ = reset;
  started_ = true;
  state_ = NmtState::boot_up;
  heartbeat_is_due_ = false;
  bus_.send(heartbeat_frame(node_, state_));
  on_change_(state_);
  enter(NmtState::pre_operational);
  heartbeat_->expire_at(scheduler_.now() + period_);
}

void NmtSlave::handle(const Frame& frame) {
  if (is_heartbeat_of(node_, frame)) return retire();
  if (frame.id != nmt_id || is_silent()) return;
  const auto nmt = parse_nmt(frame);
  if (!nmt || (nmt->node != 0 && nmt->node != node_)) return;
  switch (nmt->command) {
    case NmtCommand::start:
      return enter(NmtState::operational);
    case NmtCommand::stop:
      return enter(NmtState::stopped);
    case NmtCommand::enter_pre_operational:
      return enter(NmtState::pre_operational);
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      return boot_up(nmt->command);
  }
}

void NmtSlave::retire() {
  id_taken_ = true;
  heartbeat_->cancel();
  enter(NmtState::stopped);
}

void NmtSlave::enter(NmtState state) {
  if (state == state_) return;
  state_ = state;
  on_change_(state);
}

void NmtSlave::beat() {
  const Time now = scheduler_.now();
  heartbeat_->expire_at(now + period_);
  heartbeat_is_due_ = last_slot_ && now - *last_slot_ < period_;
  if (!heartbeat_is_due_) bus_.send(heartbeat_frame(node_, state_));
}

bool NmtSlave::on_slot() {
  if (is_silent()) return false;
  last_slot_ = scheduler_.now();
  if (heartbeat_is_due_) bus_.send(heartbeat_frame(node_, state_));
  return std::exchange(heartbeat_is_due_, false);
}

void HeartbeatMonitor::on_heartbeat(NmtState state, Time now) {
  if (state == NmtState::boot_up) ++boot_ups_;
  state_ = state;
  last_ = now;
}

std::optional<NmtState> HeartbeatMonitor::state(Time now) const {
  if (!state_ || now - last_ > timeout_) return std::nullopt;
  return state_;
}

}  // namespace hystcan::can
