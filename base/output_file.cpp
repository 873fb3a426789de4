#include "base/output_file.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"

namespace hystcan {

namespace {

/// Writes the folder's entries to the disk with fsync(). Returns 0, or the errno of the failed call.
int sync_folder(const std::filesystem::path& folder) {
  const Descriptor descriptor(
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return descriptor.get() >= 0 && ::fsync(descriptor.get()) == 0 ? 0 : errno;
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path, Kind kind) : kind_(kind), path_(path) {
  if (path_.empty()) throw Error("output file is \"\"", expect("a name"));
  if (kind_ == Kind::durable) {
    open_beside();
    return;
  }
  std::error_code ignored;
  const auto status = std::filesystem::status(path_, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    file_ = std::fopen(path_.c_str(), "w");
    if (file_ == nullptr) fail(errno);
    return;
  }
  const auto target = std::filesystem::weakly_canonical(path_, ignored);
  if (!ignored) path_ = target;
  open_beside();
}

// Opens the temporary file beside the output file. Sets its permissions to those of the file that will be
// replaced, or to those of a new file. This is necessary because mkstemp() grants access only to the owner.
void OutputFile::open_beside() {
  struct stat replaced {};
  const bool is_there = ::lstat(path_.c_str(), &replaced) == 0 && S_ISREG(replaced.st_mode);
  if (is_there && (replaced.st_mode & (S_IWUSR | S_IWGRP | S_IWOTH)) == 0) fail(EACCES);
  std::string name = path_.string() + ".XXXXXX";
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) fail(errno);
  written_ = name;
  const mode_t mask = umask(0);
  umask(mask);
  fchmod(descriptor, is_there ? replaced.st_mode & 07777 : 0666 & ~mask);
  file_ = fdopen(descriptor, "w");
  if (file_ == nullptr) fail(errno);
}

OutputFile::~OutputFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!written_.empty()) std::remove(written_.c_str());
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail(errno);
}

void OutputFile::commit() {
  if (kind_ == Kind::durable && (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0)) fail(errno);
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail(errno);
  if (!written_.empty()) move_to_the_path();
}

const std::filesystem::path& OutputFile::written() const {
  if (written_.empty()) throw Error(path_, "is not a file");
  return written_;
}

void OutputFile::move_to_the_path() {
  if (std::rename(written_.c_str(), path_.c_str()) != 0) fail(errno);
  written_.clear();
  if (kind_ == Kind::plain) return;
  if (const int error = sync_folder(path_.parent_path()); error != 0) fail(error);
}

void OutputFile::fail(int error) const {
  throw RunError(path_, "cannot be written: " + std::generic_category().message(error));
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  OutputFile out(path);
  out.write(text);
  out.commit();
}

void refuse_as_folder(const std::filesystem::path& folder) {
  if (folder.empty()) throw Error("output folder is \"\"", expect("a name"));
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw Error(folder, "is not a folder", expect("one for the output"));
  std::filesystem::path present = std::filesystem::absolute(folder);
  while (!std::filesystem::exists(present, error) && present.has_relative_path())
    present = present.parent_path();
  if (::access(present.c_str(), W_OK | X_OK) != 0)
    throw RunError(folder, "cannot be created: " + std::generic_category().message(errno));
}

void create_folder(const std::filesystem::path& folder) {
  refuse_as_folder(folder);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw RunError(folder, "cannot be created: " + error.message());
}

void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input) {
  std::error_code ignored;
  if (std::filesystem::equivalent(output, input, ignored))
    throw Error(output, "is also an input", expect("another file as output"));
}

void refuse_to_overwrite_any_of(const std::filesystem::path& output, const std::filesystem::path& input) {
  std::error_code ignored;
  const bool is_in_it = std::filesystem::is_directory(input, ignored) &&
                        std::filesystem::equivalent(output.parent_path(), input, ignored);
  refuse_to_overwrite(output, is_in_it ? output : input);
}

void refuse_to_replace(const std::filesystem::path& output, bool may_overwrite) {
  std::error_code ignored;
  const std::string& name = output.native();
  // A path like /dev/stdout can be a regular file that the shell has opened. Its existence is not an error.
  const bool is_a_stream = name.starts_with("/dev/") || name.starts_with("/proc/");
  if (!may_overwrite && !is_a_stream && std::filesystem::is_regular_file(output, ignored))
    throw Error(output, "exists already", expect("another name, or --overwrite"));
}

void refuse_to_share(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::error_code ignored;
  if (std::filesystem::weakly_canonical(one, ignored) == std::filesystem::weakly_canonical(other, ignored))
    throw Error(one, "is written twice", expect("two files"));
}

}  // namespace hystcan
