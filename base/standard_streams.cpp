#include "base/standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <stdio_ext.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdio>

#include "base/error.h"

namespace hystcan {
namespace {

[[noreturn]] void fail_output() { throw std::system_error(errno, std::generic_category()); }

void discard_output() {
  __fpurge(stdout);
  std::clearerr(stdout);
}

}  // namespace

void prepare_standard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  // open() uses the lowest free number, which is the number of the closed stream. /dev/null becomes standard
  // output read-only, so that a write to it fails.
  for (const auto& [stream, mode] :
       {std::pair(STDIN_FILENO, O_RDONLY), {STDOUT_FILENO, O_RDONLY}, {STDERR_FILENO, O_WRONLY}})
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF) static_cast<void>(::open("/dev/null", mode));
}

std::string shell_word(const std::filesystem::path& path) {
  const std::string& word = path.native();
  const auto is_plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_@%+=:,./-").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::ranges::all_of(word, is_plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string printable(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : '\0');
    // U+0080 to U+009F in UTF-8: control characters of two bytes
    if (byte == 0xC2 && next >= 0x80 && next < 0xA0) {
      result += fmt::format("\\x{:02x}", next);
      ++i;
    } else if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F) {
      result += fmt::format("\\x{:02x}", byte);
    } else {
      result += text[i];
    }
  }
  return result;
}

void print(std::string_view text) {
  static const bool is_terminal = isatty(STDOUT_FILENO) == 1;
  print_sequence(is_terminal ? std::string_view(printable(text)) : text);
}

void print_sequence(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) fail_output();
}

void flush_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) fail_output();
}

std::string lost_output_text(std::string_view reason) {
  return fmt::format("standard output: cannot be written: {}", reason);
}

Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + timeout;
  while (!text.empty()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd stream{.fd = descriptor, .events = POLLOUT, .revents = 0};
    const int ready = ::poll(&stream, 1, static_cast<int>(std::clamp<long>(left.count(), 0, INT_MAX)));
    if (ready == 0) return Written::timed_out;
    if (ready < 0 && errno != EINTR) return Written::failed;
    if (ready < 0) continue;
    // poll() guarantees that a ready pipe accepts PIPE_BUF bytes without waiting.
    const ssize_t written = ::write(descriptor, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (written < 0 && errno != EINTR && errno != EAGAIN) return Written::failed;
    text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return Written::all;
}

std::optional<std::string> print_patiently(std::string_view text) {
  const Written written = write_within(STDOUT_FILENO, text, std::chrono::seconds(5));
  if (written == Written::all) return std::nullopt;
  return lost_output_text(written == Written::failed ? std::generic_category().message(errno)
                                                     : "the receiving program does not read the output");
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

void note_sequence(std::string_view text) noexcept { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace hystcan
