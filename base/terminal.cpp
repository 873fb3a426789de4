#include "base/terminal.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "base/standard_streams.h"

namespace hystcan {
namespace {

constexpr std::size_t longest_bar = 30;
constexpr std::size_t shortest_bar = 5;

/// Returns true if standard error is a terminal that can return to the start of a line and erase the line.
bool can_show_a_bar() {
  const char* kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && (kind == nullptr || std::string_view(kind) != "dumb");
}

void show(const std::string& line) { note_sequence("\r" + line + "\033[K"); }

std::size_t columns_of_terminal() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const char* const named = std::getenv("COLUMNS");
  const std::string_view text = named != nullptr ? named : "";
  std::size_t columns = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), columns);
  return error == std::errc{} && columns > 0 ? columns : 80;
}

}  // namespace

std::string progress_line(std::string_view what, double share, std::string_view rest, std::size_t columns) {
  const std::size_t others = what.size() + rest.size() + std::string_view(" [] ").size();
  const std::size_t bar = std::min(longest_bar, columns - std::min(columns, others + 1));
  const auto filled = static_cast<std::size_t>(share * static_cast<double>(bar));
  const std::string line =
      bar < shortest_bar ? fmt::format("{} {}", what, rest)
                         : fmt::format("{} [{:=<{}}{:{}}] {}", what, "", filled, "", bar - filled, rest);
  return line.substr(0, columns - std::min<std::size_t>(columns, 1));
}

Progress::Progress(const std::string& what, std::uint64_t total, std::string unit)
    : what_(printable(what)),
      total_(total),
      unit_(std::move(unit)),
      shown_(can_show_a_bar()),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (last_ != start_) note_sequence("\r\033[K");
}

void Progress::draw(std::uint64_t done, std::uint64_t rows) {
  const Clock::time_point now = Clock::now();
  if (now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string counted = rows < 1'000'000
                                  ? fmt::format("{} {}", rows, unit_)
                                  : fmt::format("{:.3g} million {}", static_cast<double>(rows) * 1e-6, unit_);
  // The width is read for each drawing, because the user may have changed the size of the window.
  const std::size_t columns = columns_of_terminal();
  if (total_ == 0) {
    const std::string line = fmt::format("{}: {}, {:.0f} s", what_, counted, elapsed_s);
    return show(line.substr(0, columns - 1));
  }
  const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
  const double left_s = share > 0.0 ? elapsed_s * (1.0 - share) / share : 0.0;
  const std::string rest = fmt::format("{:3.0f} %  {}, {:.0f} s left", 100.0 * share, counted, left_s);
  show(progress_line(what_, share, rest, columns));
}

std::string_view cut(std::string_view line, std::size_t columns) {
  std::size_t at = 0;
  for (std::size_t seen = 0; at < line.size(); ++at)
    if ((static_cast<unsigned char>(line[at]) & 0xC0U) != 0x80 && ++seen > columns) break;
  return line.substr(0, at);
}

Screen::Screen() {
  if (::tcgetattr(STDIN_FILENO, &before_) == 0) {
    termios now = before_;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    keys_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &now) == 0;
  }
  std::fputs("\x1b[?1049h\x1b[?25l", stdout);
}

Screen::~Screen() {
  std::fputs("\x1b[?25h\x1b[?1049l", stdout);
  std::fflush(stdout);
  if (keys_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

void Screen::show(const std::vector<std::string>& lines) const {
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0)
    size = {24, 80, 0, 0};
  std::string text = "\x1b[H";
  for (std::size_t i = 0; i < std::min<std::size_t>(lines.size(), size.ws_row); ++i) {
    if (i > 0) text += "\r\n";
    text += cut(printable(lines[i]), size.ws_col);
    text += "\x1b[K";
  }
  print_sequence(text + "\x1b[J");
  flush_output();
}

bool Screen::quit() const {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  char key = '\0';
  while (keys_ && ::poll(&waiting, 1, 0) > 0 && ::read(STDIN_FILENO, &key, 1) == 1)
    if (key == 'q' || key == 'Q') return true;
  return false;
}

}  // namespace hystcan
