// Output that a terminal redraws at the same place: a progress bar, and a full screen.
#pragma once

#include <termios.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan {

/// Returns a progress bar as one line of text, `what [=====     ] rest`, shorter than `columns` characters.
/// `share` is the filled part of the bar, 0 to 1. If the terminal is narrow, the line has no bar; if it is
/// very narrow, the text is cut off.
std::string progress_line(std::string_view what, double share, std::string_view rest, std::size_t columns);

/// A progress bar on standard error, as wide as the terminal. It is shown only if standard error is a
/// terminal that can erase a line (TERM is not "dumb").
class Progress {
 public:
  /// `total`: value of `done` at the end of the work; 0 if it is unknown, then the bar shows only counts and
  /// time.
  Progress(const std::string& what, std::uint64_t total, std::string unit = "rows");
  ~Progress();  ///< erases the bar from the terminal
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Redraws the bar, at most ten times a second. `done` is compared with the total; `rows` is the count that
  /// is shown.
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

/// Returns the beginning of a UTF-8 line, at most `columns` characters.
std::string_view cut(std::string_view line, std::size_t columns);

/// Shows a full screen of text on the terminal's alternate screen, and reads single keys. The destructor
/// restores the former screen.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Replaces the content of the screen by these lines. Cuts off lines that are too long, and lines below the
  /// last row.
  void show(const std::vector<std::string>& lines) const;
  /// Returns true if the user has typed q.
  bool quit() const;

 private:
  termios before_{};
  bool keys_ = false;
};

}  // namespace hystcan
