// `hystcan demo --page`: the operator's page of a rehearsal, paced in real time.
#pragma once

#include <filesystem>
#include <string>

namespace hystcan::app {

/// Runs until a signal. If `config` is empty, uses a copy of the shipped stage, so that the page can't change
/// the original.
int run_demo_page(const std::filesystem::path& config, const std::string& listen);

}  // namespace hystcan::app
