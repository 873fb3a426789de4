// What the kernel counts of a CAN interface, without a socket on it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "config/schema/config.h"

namespace hystcan::app {

/// What the frames of a configuration are on average. The kernel counts frames and bytes alone: with these it
/// follows how many of them were CAN FD.
struct AverageFrames {
  double bitrate_bit_per_s = 0.0;  ///< 0: not known
  double classical_bytes = 0.0;    ///< payload of a classical frame
  double fd_bytes = 0.0;           ///< of an FD frame; 0: there are none
  double fd_time_s = 0.0;          ///< of an FD frame on the bus, with both bit rates

  /// The time that so many frames with so many bytes take on the bus.
  double busy_s(double frames, double bytes) const;
};
AverageFrames average_frames(const config::Config& config);

/// The state of an interface; the rates are NaN where they are not known.
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

  /// An empty interface is a simulated bus.
  BusCounters(std::string interface, const AverageFrames& average,
              std::filesystem::path network = "/sys/class/net")
      : average_(average), network_(std::move(network)), report_{.interface = std::move(interface)} {}

  /// Rates since the call before, if that is long enough ago.
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
