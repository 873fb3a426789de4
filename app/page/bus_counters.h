// What the kernel counts of a CAN interface, without a socket on it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace hystcan::app {

class BusCounters {
 public:
  using Clock = std::chrono::steady_clock;

  /// An empty interface is a simulated bus. `bitrate_bit_per_s`: 0 if it is not known.
  BusCounters(std::string interface, double bitrate_bit_per_s,
              std::filesystem::path network = "/sys/class/net")
      : interface_(std::move(interface)),
        bitrate_bit_per_s_(bitrate_bit_per_s),
        network_(std::move(network)) {}

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
  double bitrate_bit_per_s_;
  std::filesystem::path network_;
  std::optional<Count> last_;
  std::optional<double> frames_per_s_, load_percent_;
};

}  // namespace hystcan::app
