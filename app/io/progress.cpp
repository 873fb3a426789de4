#include "app/io/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace hystcan::app {

Progress::Progress(std::string what, std::uint64_t total, std::string unit)
    : what_(std::move(what)),
      total_(total),
      unit_(std::move(unit)),
      shown_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (last_ != start_) fmt::print(stderr, "\r\033[K");
}

void Progress::draw(std::uint64_t done, std::uint64_t rows) {
  const Clock::time_point now = Clock::now();
  if (now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string counted = rows < 1'000'000
                                  ? fmt::format("{} {}", rows, unit_)
                                  : fmt::format("{:.3g} million {}", static_cast<double>(rows) * 1e-6, unit_);
  if (total_ == 0) {
    fmt::print(stderr, "\r{}: {}, {:.0f} s\033[K", what_, counted, elapsed_s);
    return;
  }
  const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total_));
  const auto filled = static_cast<std::size_t>(30.0 * share);
  fmt::print(stderr, "\r{} [{:=<{}}{:{}}] {:3.0f} %  {}, {:.0f} s left\033[K", what_, "", filled, "",
             30 - filled, 100.0 * share, counted, share > 0.0 ? elapsed_s * (1.0 - share) / share : 0.0);
}

}  // namespace hystcan::app
