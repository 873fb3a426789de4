// Creates a folder that appears only when it is complete.
#pragma once

#include <filesystem>
#include <string_view>

namespace hystcan::app {

/// Creates a temporary folder next to `path`, for the files. commit() renames it to `path`. If commit() is
/// not called, the destructor removes the temporary folder.
class NewFolder {
 public:
  /// Throws Error if `path` is a file or a folder with content. Throws RunError if the folder cannot be
  /// created.
  explicit NewFolder(const std::filesystem::path& path);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// Returns the path of the temporary folder; an empty path after commit().
  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path given_, path_, temporary_;
};

/// Throws Error if `path` exists, unless it is an empty folder.
void require_new(const std::filesystem::path& path);

}  // namespace hystcan::app
