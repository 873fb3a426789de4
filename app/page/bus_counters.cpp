#include "app/page/bus_counters.h"

#include <fstream>
#include <nlohmann/json.hpp>

namespace hystcan::app {
namespace {

constexpr auto shortest_time = std::chrono::milliseconds(900);

// A classical frame with 11 bits of identifier: 44 bits beside its data, 3 between frames. Stuff bits are a
// tenth.
constexpr double bits_of_a_frame = 47.0;
constexpr double stuffing = 1.1;

std::uint64_t number_in(const std::filesystem::path& file) {
  std::uint64_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

}  // namespace

/// A virtual interface receives what it sends, and counts it twice.
std::optional<BusCounters::Count> BusCounters::count(Clock::time_point now) const {
  const std::filesystem::path folder = network_ / interface_;
  std::error_code ignored;
  if (interface_.empty() || !std::filesystem::exists(folder, ignored)) return std::nullopt;
  const std::filesystem::path statistics = folder / "statistics";
  Count counted{now, number_in(statistics / "tx_packets"), number_in(statistics / "tx_bytes")};
  if (std::filesystem::exists(folder / "device", ignored)) {
    counted.frames += number_in(statistics / "rx_packets");
    counted.bytes += number_in(statistics / "rx_bytes");
  }
  return counted;
}

std::string BusCounters::state() const {
  if (interface_.empty()) return "simulated";
  std::error_code ignored;
  if (!std::filesystem::exists(network_ / interface_, ignored)) return "missing";
  std::string flags;
  std::ifstream(network_ / interface_ / "flags") >> flags;
  const bool is_up = !flags.empty() && (std::strtoul(flags.c_str(), nullptr, 16) & 1UL) != 0;
  return is_up ? "up" : "down";
}

nlohmann::json BusCounters::report(Clock::time_point now) {
  const auto number = [](const std::optional<double>& value) {
    return value ? nlohmann::json(*value) : nlohmann::json();
  };
  const std::optional<Count> counted = count(now);
  if (!counted || !last_ || counted->frames < last_->frames) {
    frames_per_s_ = load_percent_ = std::nullopt;
    last_ = counted;
  } else if (now - last_->time >= shortest_time) {
    const double time_s = std::chrono::duration<double>(now - last_->time).count();
    const auto frames = static_cast<double>(counted->frames - last_->frames);
    const auto bytes = static_cast<double>(counted->bytes - last_->bytes);
    frames_per_s_ = frames / time_s;
    if (bitrate_bit_per_s_ > 0.0)
      load_percent_ =
          100.0 * stuffing * (frames * bits_of_a_frame + 8.0 * bytes) / (time_s * bitrate_bit_per_s_);
    last_ = counted;
  }
  return {{"interface", interface_},
          {"state", state()},
          {"frames_per_s", number(frames_per_s_)},
          {"load_percent", number(load_percent_)}};
}

}  // namespace hystcan::app
