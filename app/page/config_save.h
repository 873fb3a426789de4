// What is in force but not in the configuration file, as an edit of the file that keeps its comments.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace hystcan::app {

struct ConfigSave {
  std::string text;    ///< of the file with the edit
  std::string diff;    ///< lines, with `- ` and `+ ` before those that change; empty if none does
  std::string digest;  ///< of the file as it is and of the edit
};

/// `unsaved`: as in the answer to `settings`. Throws config::Error where the file has no place for a key.
ConfigSave save_of(const std::filesystem::path& file, const nlohmann::json& unsaved);

/// Lines of both texts, with two lines of context around each change.
std::string line_diff(const std::string& before, const std::string& after);

}  // namespace hystcan::app
