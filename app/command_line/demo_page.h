// `hystcan demo --page`: shows the operator's page of a rehearsal that runs at the speed of real time.
#pragma once

#include <filesystem>
#include <string>

namespace hystcan::app {

/// Serves the page at the address `listen` until a signal arrives. If `config` is empty, uses a copy of the
/// shipped example configuration, so that changes made on the page do not reach the original.
int run_demo_page(const std::filesystem::path& config, const std::string& listen);

}  // namespace hystcan::app
