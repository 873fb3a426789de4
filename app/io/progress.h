// A progress bar for a person who waits: on a terminal, and nowhere else.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace hystcan::app {

class Progress {
 public:
  /// `total`: of whatever is counted; 0 where it is not known.
  Progress(std::string what, std::uint64_t total, std::string unit = "rows");
  ~Progress();  ///< wipes the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap: looks at the clock once in some thousand calls, draws ten times a second.
  void at(std::uint64_t done, std::uint64_t rows) {
    if (shown_ && (++calls_ & 0xfff) == 0) draw(done, rows);
  }

  /// For what takes long: looks at the clock each time.
  void at_once(std::uint64_t done) {
    if (shown_) draw(done, done);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void draw(std::uint64_t done, std::uint64_t rows);

  std::string what_;
  std::uint64_t total_;
  std::string unit_;
  bool shown_;
  std::uint64_t calls_ = 0;
  Clock::time_point start_, last_;
};

}  // namespace hystcan::app
