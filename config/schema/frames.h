// A lab's own frames in the configuration, and the functions that are lost if a role has no signal.
#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "can/protocol/protocol.h"

namespace hystcan::config {

/// True for the roles without which control is impossible.
inline bool must_be_carried(std::string_view role) { return role == "setpoint" || role == "position"; }

/// The amplifier's status says when it is enabled and when it has tripped.
bool reports_state(const can::AxisWire& axis);

/// The functions that the controller lacks, one sentence each; empty for the standard frames.
std::vector<std::string> losses(const can::AxisWire& axis);

/// The axis's messages that only CAN FD can carry.
std::vector<std::string> fd_messages(const can::AxisWire& axis, const can::Database& database);

/// The protection (counter, CRC) of the axis's messages, standard or the lab's own.
can::Protections protections(const can::AxisWire& axis, const can::Database& database);

template <class V>
void visit_crc(V& v, can::MessageMap& map) {
  v.required("crc", map.crc);
  v.choice("polynomial", map.polynomial);
  v.choice("crc_covers", map.data_id.kind);
  if (map.data_id.kind == can::DataId::Kind::number) v.required("data_id", map.data_id.number);
}

template <class V>
void visit_integrity(V& v, can::MessageMap& map) {
  v.choice("integrity", map.integrity);
  if (map.integrity == can::Integrity::none) return;
  v.required("counter", map.counter);
  if (map.integrity == can::Integrity::counter_crc) visit_crc(v, map);
}

template <class Payload, class V>
void visit_frame(V& v, can::MessageMap& map) {
  v.required("message", map.message);
  const auto name = [&](const auto& field) {
    const auto found = map.signals.find(field.role);
    std::string signal = found == map.signals.end() ? std::string() : found->second;
    if (must_be_carried(field.role))
      v.required(field.role, signal);
    else
      v.name(field.role, signal);
    if (!signal.empty()) map.signals[field.role] = signal;
  };
  std::apply([&](const auto&... field) { (name(field), ...); }, Payload::fields());
  if (map.carries("state")) {
    v.whole_numbers("state_off", map.states.off);
    v.whole_numbers("state_ready", map.states.ready);
    v.whole_numbers("state_enabled", map.states.enabled);
    v.whole_numbers("state_fault", map.states.fault);
  }
  visit_integrity(v, map);
}

}  // namespace hystcan::config
