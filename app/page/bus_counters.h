// Reads the kernel's counters of a CAN interface, from which frame rate and bus load are computed. No socket
// on the interface is needed.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// Average size of the frames of a configuration. The kernel counts all frames and bytes, but does not count
/// CAN FD frames separately. Their number is estimated from these averages.
struct AverageFrames {
  double bitrate_bit_per_s = 0.0;  ///< nominal bit rate; 0: unknown
  double classical_bytes = 0.0;    ///< average data bytes of a classical frame
  double fd_bytes = 0.0;           ///< average data bytes of a CAN FD frame; 0: there are none
  double fd_time_s = 0.0;          ///< average duration of a CAN FD frame in s, at nominal and data bit rate

  /// Estimates how long this number of frames, with this total number of data bytes, occupies the bus.
  double busy_s(double frames, double bytes) const;
};
AverageFrames average_frames(const config::Config& config);

/// State and traffic of a CAN interface. A rate that is not known is NaN.
struct BusReport {
  std::string interface;
  std::string state{};  ///< "up", "down", "missing" (no such interface) or "simulated"
  double frames_per_s = std::numeric_limits<double>::quiet_NaN();
  double load_percent = std::numeric_limits<double>::quiet_NaN();
};
template <class V>
void visit(V& v, BusReport& a) {
  v.member("interface", a.interface, {"", "name"});
  v.member("state", a.state, {"", "`up`, `down`, `missing`, `simulated`"});
  v.member("frames_per_s", a.frames_per_s, {"1/s", "frames of the interface"});
  v.member("load_percent", a.load_percent, {"%", "load, estimated from the counters of the interface"});
}

class BusCounters {
 public:
  using Clock = std::chrono::steady_clock;

  /// `interface`: name of the CAN interface; if empty, the bus is simulated. `average`: average size of the
  /// frames, from which the bus load is estimated.
  BusCounters(std::string interface, const AverageFrames& average,
              std::filesystem::path network = "/sys/class/net")
      : average_(average), network_(std::move(network)), report_{.interface = std::move(interface)} {}

  /// Returns the state, and the traffic since the previous call. If the previous call was less than 0.9 s
  /// ago, returns the rates of that call again.
  BusReport report(Clock::time_point now = Clock::now());

 private:
  struct Count {
    Clock::time_point time;
    std::uint64_t frames = 0, bytes = 0;
  };

  std::optional<Count> count(Clock::time_point now) const;
  std::string state() const;

  AverageFrames average_;
  std::filesystem::path network_;
  std::optional<Count> last_;
  BusReport report_;
};

}  // namespace hystcan::app
