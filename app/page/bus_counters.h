// What the kernel counts of a CAN interface, without a socket on it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
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

class BusCounters {
 public:
  using Clock = std::chrono::steady_clock;

  /// An empty interface is a simulated bus.
  BusCounters(std::string interface, const AverageFrames& average,
              std::filesystem::path network = "/sys/class/net")
      : interface_(std::move(interface)), average_(average), network_(std::move(network)) {}

  /// Rates since the call before, if that is long enough ago. docs/page_protocol.md has the keys.
  nlohmann::json report(Clock::time_point now = Clock::now());

 private:
  struct Count {
    Clock::time_point time;
    std::uint64_t frames = 0, bytes = 0;
  };

  std::optional<Count> count(Clock::time_point now) const;
  std::string state() const;

  std::string interface_;
  AverageFrames average_;
  std::filesystem::path network_;
  std::optional<Count> last_;
  std::optional<double> frames_per_s_, load_percent_;
};

}  // namespace hystcan::app
