// The names from the configuration: the message of the DBC and the signal of each role.
// can/protocol/layout.h compiles them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/e2e.h"

namespace hystcan::can {

enum class Integrity : std::uint8_t { none, counter, counter_crc };
constexpr auto words(Integrity) {
  return std::to_array<std::string_view>({"none", "counter", "counter+crc"});
}

/// Raw values of a state signal. The sender uses the first of each list. An unlisted value reads as off.
struct StateValues {
  std::vector<std::int64_t> off{0};
  std::vector<std::int64_t> ready{1};
  std::vector<std::int64_t> enabled{2};
  std::vector<std::int64_t> fault{3};
};

struct MessageMap {
  std::string message;
  std::map<std::string, std::string, std::less<>> signals{};  ///< by role; a role that is absent is not sent
  Integrity integrity = Integrity::counter_crc;
  std::string counter = "Counter";
  std::string crc = "Crc";
  Crc8 polynomial = Crc8::sae_j1850;
  DataId data_id{};
  StateValues states{};

  bool carries(std::string_view role) const { return signals.contains(role); }
};

/// The lab's own frames of one axis. Without a status message the controller does not read the amplifier.
struct AxisFrames {
  MessageMap command;
  std::optional<MessageMap> status{};
  MessageMap sample;
};

}  // namespace hystcan::can
