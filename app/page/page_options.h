// The options with which a page's server is started.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "app/page/bus_counters.h"

namespace hystcan::app {

struct PageOptions {
  std::filesystem::path config;
  std::string source = "controller";  ///< source of the data: "controller" or "demo"
  std::string interface {};           ///< CAN interface; empty: the bus is simulated
  AverageFrames frames{};
  bool exposed = false;
  std::string start_command{};
  std::function<std::filesystem::path()> controller_socket, twin_socket;
  std::chrono::seconds answer_limit{5};  ///< longest time for the controller to answer a command
  /// Starts a new rehearsal after the previous one ended; throws if that is not possible. Set only for a
  /// demo.
  std::function<void()> start_again{};
};

}  // namespace hystcan::app
