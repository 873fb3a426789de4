#include "app/stage/new_folder.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "base/error.h"

namespace hystcan::app {
namespace {

/// Throws an error because the folder `path` cannot be created. The message names the deepest existing parent
/// folder, in which the system refused to create a folder.
[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  std::error_code ignored;
  std::filesystem::path present = (path.has_filename() ? path : path.parent_path()).parent_path();
  while (present.has_relative_path() && !std::filesystem::exists(present, ignored))
    present = present.parent_path();
  if (present.empty()) present = ".";
  if (!std::filesystem::is_directory(present, ignored))
    throw Error(path, fmt::format("{} is not a folder", present.string()));
  throw RunError(path, fmt::format("cannot be created in the folder {}: {}", present.string(),
                                   std::generic_category().message(error)));
}

/// Returns the absolute path without a trailing slash. With the slash, parent_path() would be the folder
/// itself.
std::filesystem::path named(const std::filesystem::path& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

}  // namespace

void require_new(const std::filesystem::path& path) {
  if (path.empty()) throw Error("the folder has no name");
  std::error_code error;
  const auto status = std::filesystem::symlink_status(path, error);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_directory(status)) throw Error(path, "exists already", expect("a new folder"));
  const bool is_empty = std::filesystem::is_empty(path, error);
  if (error) throw RunError(path, fmt::format("cannot be read: {}", error.message()));
  if (!is_empty)
    throw Error(path, "is not empty", {.expected = "a new folder", .remedy = "nothing is overwritten"});
}

NewFolder::NewFolder(const std::filesystem::path& path) : given_(path) {
  require_new(path);
  path_ = named(path);
  std::error_code error;
  std::filesystem::create_directories(path_.parent_path(), error);
  if (error) fail(path, error.value());
  std::string name = (path_.parent_path() / ("." + path_.filename().string() + ".XXXXXX")).string();
  if (mkdtemp(name.data()) == nullptr) fail(path, errno);
  temporary_ = name;
}

NewFolder::~NewFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
}

void NewFolder::commit() {
  const mode_t mask = umask(0);
  umask(mask);
  std::error_code error;  // rename() also replaces an existing empty folder
  std::filesystem::permissions(temporary_, static_cast<std::filesystem::perms>(0777 & ~mask), error);
  std::filesystem::rename(temporary_, path_, error);
  if (error) fail(given_, error.value());
  temporary_.clear();
}

}  // namespace hystcan::app
