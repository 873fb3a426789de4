#include "app/page/bus_counters.h"

#include <algorithm>
#include <fstream>
#include <numeric>

#include "can/frame_bits.h"
#include "config/schema/bus_plan.h"

namespace hystcan::app {
namespace {

constexpr auto shortest_time = std::chrono::milliseconds(900);

// Size of a classical frame with an 11-bit identifier: 44 bits besides its data, and 3 bits between frames.
// Stuff bits increase the size by about a tenth.
constexpr double bits_of_a_frame = 47.0;
constexpr double stuffing = 1.1;

std::uint64_t number_in(const std::filesystem::path& file) {
  std::uint64_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

/// Returns a CAN FD frame with the identifier, size and bit rates of `planned`, and with the data bytes 0, 1,
/// 2, ... These bytes cause a typical number of stuff bits.
can::Frame fd_frame(const can::PeriodicFrame& planned) {
  can::Frame frame{.id = planned.id,
                   .extended = planned.extended,
                   .kind = can::FrameKind::fd,
                   .length = static_cast<std::uint8_t>(planned.bytes),
                   .fd_flags = planned.bit_rate_switch ? can::fd_bit_rate_switch : std::uint8_t{0}};
  std::iota(frame.data.begin(), frame.data.end(), std::uint8_t{0});
  return frame;
}

}  // namespace

AverageFrames average_frames(const config::Config& config) {
  AverageFrames average{.bitrate_bit_per_s = static_cast<double>(config.bus.bitrate_bit_per_s)};
  double classical_per_s = 0.0, fd_per_s = 0.0;
  for (const config::PlannedFrame& planned : config::plan_bus(config).frames) {
    const can::PeriodicFrame& frame = planned.frame;
    const double per_s = 1.0 / can::seconds(frame.period);
    const bool is_fd = can::wire_kind(frame.bytes, frame.fd) == can::FrameKind::fd;
    (is_fd ? fd_per_s : classical_per_s) += per_s;
    (is_fd ? average.fd_bytes : average.classical_bytes) += per_s * frame.bytes;
    if (is_fd)
      average.fd_time_s += per_s * can::seconds(can::transmission_time(can::frame_bits(fd_frame(frame)).all(),
                                                                       config.bus.rates()));
  }
  average.classical_bytes /= classical_per_s;  // never divides by 0: SYNC is a classical frame
  if (fd_per_s > 0.0) {
    average.fd_bytes /= fd_per_s;
    average.fd_time_s /= fd_per_s;
  }
  return average;
}

double AverageFrames::busy_s(double frames, double bytes) const {
  double fd = 0.0;
  if (fd_bytes > classical_bytes)
    fd = std::clamp((bytes - frames * classical_bytes) / (fd_bytes - classical_bytes), 0.0, frames);
  const double others = frames - fd;
  const double payload = std::max(bytes - fd * fd_bytes, 0.0);
  return fd * fd_time_s + stuffing * (others * bits_of_a_frame + 8.0 * payload) / bitrate_bit_per_s;
}

/// Reads the frame and byte counters. A virtual interface also receives the frames that it sends, so only its
/// sent frames are counted.
std::optional<BusCounters::Count> BusCounters::count(Clock::time_point now) const {
  const std::filesystem::path folder = network_ / report_.interface;
  std::error_code ignored;
  if (report_.interface.empty() || !std::filesystem::exists(folder, ignored)) return std::nullopt;
  const std::filesystem::path statistics = folder / "statistics";
  Count counted{now, number_in(statistics / "tx_packets"), number_in(statistics / "tx_bytes")};
  if (std::filesystem::exists(folder / "device", ignored)) {
    counted.frames += number_in(statistics / "rx_packets");
    counted.bytes += number_in(statistics / "rx_bytes");
  }
  return counted;
}

std::string BusCounters::state() const {
  if (report_.interface.empty()) return "simulated";
  std::error_code ignored;
  if (!std::filesystem::exists(network_ / report_.interface, ignored)) return "missing";
  std::string flags;
  std::ifstream(network_ / report_.interface / "flags") >> flags;
  const bool is_up = !flags.empty() && (std::strtoul(flags.c_str(), nullptr, 16) & 1UL) != 0;
  return is_up ? "up" : "down";
}

BusReport BusCounters::report(Clock::time_point now) {
  const std::optional<Count> counted = count(now);
  if (!counted || !last_ || counted->frames < last_->frames) {
    report_ = {.interface = report_.interface};
    last_ = counted;
  } else if (now - last_->time >= shortest_time) {
    const double time_s = std::chrono::duration<double>(now - last_->time).count();
    const auto frames = static_cast<double>(counted->frames - last_->frames);
    const auto bytes = static_cast<double>(counted->bytes - last_->bytes);
    report_.frames_per_s = frames / time_s;
    if (average_.bitrate_bit_per_s > 0.0)
      report_.load_percent = 100.0 * average_.busy_s(frames, bytes) / time_s;
    last_ = counted;
  }
  report_.state = state();
  return report_;
}

}  // namespace hystcan::app
