// Paths of measured datasets, which are not part of this repository. They are in the directory
// HYSTCAN_DATA, or in shared/data beside the repository.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace hystcan::identification {

inline std::filesystem::path measured(const std::string& name) {
  const char* directory = std::getenv("HYSTCAN_DATA");
  const std::filesystem::path root = directory != nullptr ? directory : HYSTCAN_SOURCE_DIR "/../shared/data";
  return root / (name + ".csv");
}

}  // namespace hystcan::identification
