// Folders and files of one test program. Several tests and several builds may run at once: every path below
// is unique to one process.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace hystcan::support {

/// A new empty folder, removed by the destructor.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::path(testing::TempDir()) / "hystcan-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name);
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code gone;
    std::filesystem::remove_all(path_, gone);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Returns a path in a folder that is removed when the program ends.
inline std::filesystem::path scratch_file(const std::filesystem::path& name) {
  static const ScratchFolder folder;
  return folder / name;
}

}  // namespace hystcan::support
