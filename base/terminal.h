// What a terminal shows in place: a progress bar, and its alternate screen.
#pragma once

#include <termios.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// One line of fewer than `columns` characters, without its end: `what [=====     ] rest`. `share`: 0 to 1. A
/// narrow
/// terminal has no bar, a very narrow one only the beginning of the text.
std::string progress_line(std::string_view what, double share, std::string_view rest, std::size_t columns);

/// A progress bar, shown only on a terminal that can erase it (TERM is not "dumb"). It fits the width of the
/// terminal.
class Progress {
 public:
  /// `total`: the final value of `done`; 0 if it is not known.
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

/// The first `columns` characters of a line of UTF-8.
std::string_view cut(std::string_view line, std::size_t columns);

/// The alternate screen, redrawn in place. Reads single keys. The destructor restores the terminal.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// What does not fit is cut off at the right and below.
  void show(const std::vector<std::string>& lines) const;
  /// True once the user has typed q.
  bool quit() const;

 private:
  termios before_{};
  bool keys_ = false;
};

}  // namespace hystcan
