#include "can/protocol/layout.h"

namespace hystcan::can {

const Signal& find_signal(const Message& message, const std::string& name) {
  const Signal* const found = message.find(name);
  if (found == nullptr) throw std::invalid_argument("message " + message.name + " has no signal " + name);
  if (message.length > Frame{}.data.size() || bytes_needed(*found) > message.length)
    throw std::invalid_argument("signal " + name + " lies outside message " + message.name);
  return *found;
}

Protection protection_of(const Message& message, const MessageMap& map) {
  Protection protection{.polynomial = map.polynomial, .data_id = map.data_id};
  if (map.integrity == Integrity::none) return protection;
  protection.counter.emplace(find_signal(message, map.counter));
  if (map.integrity == Integrity::counter) return protection;
  const Signal& crc = find_signal(message, map.crc);
  std::array<std::uint8_t, 64> bits{};
  SignalCodec(crc).pack_raw(-1, bits);
  if (crc.length != 8 || std::ranges::find(bits, std::uint8_t{0xFF}) == bits.end())
    throw std::invalid_argument("signal " + map.crc + " of message " + message.name + " is not a whole byte");
  protection.crc.emplace(crc);
  return protection;
}

StateTable::StateTable(const StateValues& values) {
  // If one value stands for two states, it reads as the more severe state.
  const std::array by_state{&values.off, &values.ready, &values.enabled, &values.fault};
  for (std::size_t i = by_state.size(); i-- > 0;)
    for (const std::int64_t raw : *by_state[i]) known_.emplace_back(raw, static_cast<AmpState>(i));
  for (std::size_t i = 0; i < by_state.size(); ++i)
    sent_[i] = by_state[i]->empty() ? (i == 0 ? 0 : sent_[0]) : by_state[i]->front();
}

AmpState StateTable::state(std::int64_t raw) const {
  for (const auto& [value, state] : known_)
    if (value == raw) return state;
  return AmpState::off;
}

}  // namespace hystcan::can
