// The start options of a page's server.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "app/page/bus_counters.h"

namespace hystcan::app {

struct PageOptions {
  std::filesystem::path config;
  std::string source = "controller";  ///< or "demo"
  std::string interface {};           ///< empty: simulated
  AverageFrames frames{};
  bool exposed = false;
  std::string start_command{};
  std::function<std::filesystem::path()> controller_socket, twin_socket;
  std::chrono::seconds answer_limit{5};  ///< time for the controller to answer a command
  /// Only for a demo: starts another rehearsal, or throws the reason why it can't.
  std::function<void()> start_again{};
};

}  // namespace hystcan::app
