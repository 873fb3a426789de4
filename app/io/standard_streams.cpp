#include "app/io/standard_streams.h"

#include <fcntl.h>
#include <stdio_ext.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "app/io/bounded_output.h"
#include "app/io/exit_status.h"

namespace hystcan::app {
namespace {

[[noreturn]] void fail_output() { throw std::system_error(errno, std::generic_category()); }

void discard_output() {
  __fpurge(stdout);
  std::clearerr(stdout);
}

}  // namespace

void prepare_standard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  // open() takes the lowest number that is free. Standard output is open for reading only: a write to it fails.
  for (const auto& [stream, mode] :
       {std::pair(STDIN_FILENO, O_RDONLY), {STDOUT_FILENO, O_RDONLY}, {STDERR_FILENO, O_WRONLY}})
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF) static_cast<void>(::open("/dev/null", mode));
}

void print(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) fail_output();
}

void flush_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) fail_output();
}

std::string lost_output_text(std::string_view reason) {
  return fmt::format("standard output: cannot be written: {}", reason);
}

std::string print_patiently(std::string_view text) {
  const Written written = write_within(STDOUT_FILENO, text, std::chrono::seconds(5));
  if (written == Written::all) return {};
  return lost_output_text(written == Written::failed ? std::generic_category().message(errno)
                                                     : "nobody reads it");
}

bool is_lost_output() {
  const bool lost = std::ferror(stdout) != 0;
  if (lost) discard_output();
  return lost;
}

int print_for_reader(const std::function<int()>& command) {
  try {
    const int status = command();
    flush_output();
    return status;
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::broken_pipe || !is_lost_output()) throw;
    return done;
  }
}

void note_text(std::string_view text) noexcept { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace hystcan::app
