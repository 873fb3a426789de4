#include "app/io/screen.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "app/io/standard_streams.h"

namespace hystcan::app {

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

}  // namespace hystcan::app
