// A copy of the shipped configuration in a temporary folder, for tests that change it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/scratch.h"

namespace hystcan::support {

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

class ShippedCopy {
 public:
  ShippedCopy() { std::filesystem::copy(HYSTCAN_SOURCE_DIR "/config", folder()); }

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path operator/(const char* name) const { return folder_ / name; }

  /// Replaces the first `what` in the file with `with`. The test fails if the file does not contain `what`.
  void edit(const char* name, const std::string& what, const std::string& with) const {
    std::string text = read_file(folder_ / name);
    const auto at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what << " is not in " << name;
    text.replace(at, what.size(), with);
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

 private:
  ScratchFolder folder_;
};

}  // namespace hystcan::support
