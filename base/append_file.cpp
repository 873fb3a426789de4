#include "base/append_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace hystcan {
namespace {

constexpr std::size_t enough_bytes = 1 << 16;

std::error_code last_error() { return {errno, std::generic_category()}; }

/// Writes `text` to the file. Sets `done` to the number of bytes that were written, also if it returns an
/// error.
std::error_code write_all(int descriptor, std::string_view text, std::size_t& done) {
  for (done = 0; done < text.size();) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return last_error();
    done += static_cast<std::size_t>(count);
  }
  return {};
}

}  // namespace

AppendFile::AppendFile(std::filesystem::path path, Existing existing) : path_(std::move(path)) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path_, ignored);
  is_regular_ = !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
  const int how = !is_regular_ ? 0 : existing == Existing::replace ? O_CREAT | O_TRUNC : O_CREAT | O_EXCL;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | how, 0666);
  if (descriptor_ < 0) throw std::system_error(last_error(), path_.string() + ": cannot be written");
  kept_.reserve(enough_bytes);
}

AppendFile::~AppendFile() { close(); }

void AppendFile::add(std::string_view lines) {
  if (kept_.size() + lines.size() > enough_bytes) flush();
  if (lines.size() > enough_bytes)
    write(lines);
  else if (!error_)
    kept_ += lines;
}

std::error_code AppendFile::flush() {
  write(kept_);
  kept_.clear();
  return error_;
}

void AppendFile::write(std::string_view lines) {
  if (error_ || descriptor_ < 0) return;
  std::size_t done = 0;
  error_ = write_all(descriptor_, lines, done);
  if (error_) {
    done = lines.substr(0, done).rfind('\n') + 1;  // length of the complete lines; 0 if no line is complete
    if (is_regular_ && ::ftruncate(descriptor_, static_cast<off_t>(written_ + done)) != 0)
      error_ = last_error();
  }
  written_ += done;
}

std::error_code AppendFile::sync() {
  if (!flush() && is_regular_ && descriptor_ >= 0 && ::fdatasync(descriptor_) != 0) error_ = last_error();
  return error_;
}

std::error_code AppendFile::close() {
  flush();
  if (descriptor_ >= 0 && ::close(std::exchange(descriptor_, -1)) != 0 && !error_) error_ = last_error();
  return error_;
}

std::string AppendFile::error_text() const {
  return error_ ? fmt::format("{}: cannot be written: {}", path_.string(), error_.message()) : std::string();
}

bool AppendFile::is_in_place() const {
  struct stat open {
  }, named{};
  return descriptor_ >= 0 && ::fstat(descriptor_, &open) == 0 && ::stat(path_.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace hystcan
