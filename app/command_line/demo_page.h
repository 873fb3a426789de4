// `hystcan demo --page`: the operator's page of a rehearsal, paced in real time.
#pragma once

#include <filesystem>
#include <string>

namespace hystcan::app {

/// Until a signal. Without `config` a copy of the shipped stage, so that the page cannot change the original.
int run_demo_page(const std::filesystem::path& config, const std::string& listen);

}  // namespace hystcan::app
