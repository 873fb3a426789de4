// Terminal output that is redrawn in place: a progress bar, and the alternate screen.
#pragma once

#include <termios.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// Returns one line of fewer than `columns` characters, without its end: `what [=====     ] rest`. `share`: 0
/// to 1. On a narrow terminal the line has no bar; on a very narrow one it is the beginning of the text.
std::string progress_line(std::string_view what, double share, std::string_view rest, std::size_t columns);

/// A progress bar, shown only on a terminal that can erase it (TERM is not "dumb"). It fits the width of the
/// terminal.
class Progress {
 public:
  /// `total`: final value of `done`; 0 if it is unknown.
  Progress(const std::string& what, std::uint64_t total, std::string unit = "rows");
  ~Progress();  ///< erases the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Reads the clock and draws at most ten times a second.
  void update(std::uint64_t done) { update(done, done); }
  void update(std::uint64_t done, std::uint64_t rows) {
    if (shown_) draw(done, rows);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void draw(std::uint64_t done, std::uint64_t rows);

  std::string what_;
  std::uint64_t total_;
  std::string unit_;
  bool shown_;
  Clock::time_point start_, last_;
};

/// Returns the first `columns` characters of a UTF-8 line.
std::string_view cut(std::string_view line, std::size_t columns);

/// The alternate screen, redrawn in place. Reads single keys. The destructor restores the terminal.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Shows the lines; cuts them off at the right and at the bottom if they do not fit.
  void show(const std::vector<std::string>& lines) const;
  /// True after the user has typed q.
  bool quit() const;

 private:
  termios before_{};
  bool keys_ = false;
};

}  // namespace hystcan
