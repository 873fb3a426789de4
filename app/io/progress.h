// A progress bar, shown only on a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace hystcan::app {

class Progress {
 public:
  /// `total`: the final value of `done`; 0 if it is not known.
  Progress(std::string what, std::uint64_t total, std::string unit = "rows");
  ~Progress();  ///< erases the bar
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap: reads the clock once in 4096 calls and draws at most ten times a second.
  void update(std::uint64_t done, std::uint64_t rows) {
    if (shown_ && (++calls_ & 0xfff) == 0) draw(done, rows);
  }

  /// For slow steps: reads the clock in each call.
  void update_now(std::uint64_t done) {
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
