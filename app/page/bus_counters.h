// The kernel's counters of a CAN interface, read without a socket on it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// The average frames of a configuration. The kernel counts only frames and bytes; these averages give the
/// number of CAN FD frames among them.
struct AverageFrames {
  double bitrate_bit_per_s = 0.0;  ///< 0: unknown
  double classical_bytes = 0.0;    ///< average payload of a classical frame
  double fd_bytes = 0.0;           ///< average payload of an FD frame; 0: no FD frames
  double fd_time_s = 0.0;          ///< time of an FD frame on the bus, with both bit rates

  /// Returns the bus time of this number of frames with this total number of bytes.
  double busy_s(double frames, double bytes) const;
};
AverageFrames average_frames(const config::Config& config);

/// The state of an interface; unknown rates are NaN.
struct BusReport {
  std::string interface;
  std::string state{};  ///< "up", "down", "missing", "simulated"
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

  /// If `interface` is empty, the bus is simulated.
  BusCounters(std::string interface, const AverageFrames& average,
              std::filesystem::path network = "/sys/class/net")
      : average_(average), network_(std::move(network)), report_{.interface = std::move(interface)} {}

  /// Returns the rates since the previous call; if it was too recent, the previous rates.
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
