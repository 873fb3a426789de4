// A lab's own frames in the configuration, and the functions that are lost if a role has no signal.
#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "can/protocol/protocol.h"

namespace hystcan::config {

/// True for the roles without which control is impossible.
inline bool must_be_carried(std::string_view role) { return role == "setpoint" || role == "position"; }

/// The functions that the controller lacks, one sentence each; empty for the standard frames.
std::vector<std::string> losses(const can::AxisWire& axis);

/// The axis's messages that only CAN FD can carry.
std::vector<std::string> fd_messages(const can::AxisWire& axis, const can::Database& database);

/// The protection (counter, CRC) of the axis's messages, standard or the lab's own.
can::Protections protections(const can::AxisWire& axis, const can::Database& database);

template <class V>
void visit_crc(V& v, can::MessageMap& map) {
  std::string polynomial = map.polynomial == can::Crc8::sae_j1850 ? "SAE-J1850" : "CRC-8H2F";
  std::string covers = map.data_id.kind == can::DataId::Kind::identifier ? "identifier"
                       : map.data_id.kind == can::DataId::Kind::number   ? "data_id"
                                                                         : "payload";
  v.required("crc", map.crc);
  v.choice("polynomial", polynomial, {"SAE-J1850", "CRC-8H2F"});
  v.choice("crc_covers", covers, {"identifier", "data_id", "payload"});
  map.polynomial = polynomial == "SAE-J1850" ? can::Crc8::sae_j1850 : can::Crc8::autosar_8h2f;
  map.data_id.kind = covers == "identifier" ? can::DataId::Kind::identifier
                     : covers == "data_id"  ? can::DataId::Kind::number
                                            : can::DataId::Kind::none;
  if (covers == "data_id") v.required("data_id", map.data_id.number);
}

template <class V>
void visit_integrity(V& v, can::MessageMap& map) {
  std::string integrity = map.integrity == can::Integrity::none      ? "none"
                          : map.integrity == can::Integrity::counter ? "counter"
                                                                     : "counter+crc";
  v.choice("integrity", integrity, {"none", "counter", "counter+crc"});
  map.integrity = integrity == "none"      ? can::Integrity::none
                  : integrity == "counter" ? can::Integrity::counter
                                           : can::Integrity::counter_crc;
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
