// A folder that is either complete or absent.
#pragma once

#include <filesystem>
#include <string_view>

namespace hystcan::app {

/// Files are written to a temporary folder next to `path`; commit() renames it to `path`. Without commit()
/// the temporary folder is removed.
class NewFolder {
 public:
  /// Throws Error if a file or a folder with content has this name; RunError if the folder cannot be created.
  explicit NewFolder(const std::filesystem::path& path);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  /// Returns the path of the temporary folder.
  const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path given_, path_, temporary_;
};

/// Throws Error if the path exists and is not an empty folder.
void require_new(const std::filesystem::path& path);

}  // namespace hystcan::app
