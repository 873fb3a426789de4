// The table of `monitor`: one line about the bus, then one row for each message.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can/log/traffic.h"

namespace hystcan::app {

struct BusLine {
  std::string interface;
  bool up = true;
  can::BusState state = can::BusState::active;
  std::uint64_t lost = 0;           ///< frames the kernel dropped
  std::chrono::microseconds now{};  ///< since 1970-01-01 UTC; ages are relative to it
};

/// Lines without their ends, not cut to any width.
std::vector<std::string> monitor_lines(const BusLine& bus, const can::Traffic& traffic);

/// One object, in one line.
std::string monitor_json(const BusLine& bus, const can::Traffic& traffic);

}  // namespace hystcan::app
