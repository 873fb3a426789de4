// A folder that is complete or absent.
#pragma once

#include <filesystem>
#include <string_view>

namespace hystcan::app {

/// What is written goes to a temporary folder beside it; commit() gives that its name. Without commit() it is
/// removed.
class NewFolder {
 public:
  /// Throws Error if there is such a folder with something in it, or a file of this name; RunError if
  /// it cannot be made.
  explicit NewFolder(const std::filesystem::path& path);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// The temporary folder.
  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path given_, path_, temporary_;
};

/// Throws Error if the path is there and is not an empty folder.
void require_new(const std::filesystem::path& path);

}  // namespace hystcan::app
