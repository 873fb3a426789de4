#include "app/io/log_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "app/io/exit_status.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

constexpr std::size_t enough_bytes = 1 << 16;

/// Returns zero or the errno. `done` is the number of bytes that were written in either case.
int write_all(int descriptor, std::string_view text, std::size_t& done) {
  for (done = 0; done < text.size();) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    done += static_cast<std::size_t>(count);
  }
  return 0;
}

}  // namespace

LogFile::LogFile(const std::filesystem::path& path, bool overwrite) : path_(path) {
  if (path_.empty()) throw config::Error("output file is \"\", expected a name");
  std::error_code ignored;
  const auto status = std::filesystem::status(path_, ignored);
  regular_ = !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
  const int how = !regular_ ? 0 : overwrite ? O_CREAT | O_TRUNC : O_CREAT | O_EXCL;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | how, 0666);
  if (descriptor_ < 0 && errno == EEXIST)
    throw config::Error(
        fmt::format("{}: exists already, expected another name, or --overwrite", path_.string()));
  if (descriptor_ < 0) fail(errno);
}

LogFile::~LogFile() {
  if (descriptor_ < 0) return;
  std::size_t done = 0;
  write_all(descriptor_, kept_, done);
  ::close(descriptor_);
}

void LogFile::add(std::string_view line) {
  kept_ += line;
  kept_ += '\n';
  if (kept_.size() >= enough_bytes) flush();
}

void LogFile::flush() {
  const std::string text = std::exchange(kept_, {});
  std::size_t done = 0;
  const int error = write_all(descriptor_, text, done);
  if (error == 0) {
    written_ += static_cast<std::int64_t>(done);
    return;
  }
  const std::size_t last_end = done == 0 ? std::string::npos : text.rfind('\n', done - 1);
  const std::int64_t whole = last_end == std::string::npos ? 0 : static_cast<std::int64_t>(last_end) + 1;
  if (regular_ && ::ftruncate(descriptor_, written_ + whole) != 0) fail(errno);
  fail(error);
}

void LogFile::close() {
  flush();
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
}

void LogFile::fail(int error) const {
  throw RunError(
      fmt::format("{}: cannot be written: {}", path_.string(), std::generic_category().message(error)));
}

}  // namespace hystcan::app
