// The checks of the CAN interface.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <iterator>
#include <optional>
#include <system_error>

#include "app/live/doctor.h"
#include "base/input_file.h"
#include "base/text.h"
#include "can/socketcan/interface.h"
#include "can/socketcan/raw_socket.h"
#include "config/schema/frames.h"
#include "controller/timing.h"

namespace hystcan::app {
namespace {

/// The program's socket holds eight unsent frames; a longer queue holds frames of other programs.
constexpr std::uint32_t long_queue_frames = 100;
constexpr unsigned warning_count = 96;  ///< error counter at which error-warning begins (ISO 11898-1)

/// A round trip above this share of the period leaves hardly any time for sample, answer and other axes.
constexpr double good_round_trip_share = 0.2;
constexpr int round_trips = 200;
constexpr std::uint32_t test_id = 0x7FF;  ///< lowest priority; unused in CANopen

Finding examine_bit_rate(const config::Config& config, const std::string& name, const can::Interface& found) {
  const double wanted = config.bus.bitrate_bit_per_s;
  if (!found.bitrate_bit_per_s) return {"bit rate", Verdict::good, "none: a virtual interface"};
  const double real = *found.bitrate_bit_per_s;
  Finding finding{.check = "bit rate",
                  .verdict = Verdict::good,
                  .figure = fmt::format("{:g} kbit/s, sample point {:g} %", 1e-3 * real,
                                        100.0 * found.sample_point.value_or(0.0))};
  if (real == wanted) return finding;
  finding.verdict = Verdict::bad;
  finding.figure += fmt::format(", configured {:g} kbit/s", 1e-3 * wanted);
  finding.cure = fmt::format(
      "ip link set {0} down; ip link set {0} up type can bitrate {1:.0f}, or correct "
      "bitrate_bit_per_s",
      name, wanted);
  return finding;
}

Finding examine_restart(const std::string& name, const can::Interface& found) {
  if (!found.restart_ms) return {"restart-ms", Verdict::good, "none: never bus-off"};
  return judged("restart-ms", *found.restart_ms > 0, std::to_string(*found.restart_ms),
                fmt::format("bus-off lasts until the user ends it: ip link set {0} down; ip link set "
                            "{0} up type can restart-ms 100",
                            name));
}

Finding examine_queue(const config::Config& config, const std::string& name, const can::Interface& found) {
  const std::uint32_t frames = found.transmit_queue_frames;
  const auto needed = static_cast<std::uint32_t>(config.axes.size() + 2);  // commands, SYNC, housekeeping
  Finding finding{.check = "queue",
                  .verdict = Verdict::good,
                  .figure = fmt::format("{}, {}", counted(frames, "frame"),
                                        found.queue_discipline.empty() ? "none" : found.queue_discipline)};
  if (found.queue_discipline == "noqueue" || (frames >= needed && frames <= long_queue_frames))
    return finding;
  finding.verdict = Verdict::doubtful;
  finding.cure = fmt::format("ip link set {} txqueuelen {}: {}", name, std::max(10U, 2 * needed),
                             frames < needed ? "the frames of one cycle must fit"
                                             : "frames in a long queue are old when they are sent");
  return finding;
}

Finding examine_errors(const std::string& name, const can::Interface& found) {
  Finding finding{.check = "errors",
                  .verdict = Verdict::good,
                  .figure = found.bus_state ? std::string(to_string(*found.bus_state)) : "not reported"};
  if (found.error_counters) {
    const auto [transmit, receive] = *found.error_counters;
    finding.figure += fmt::format(", counters {} transmit, {} receive", transmit, receive);
    if (std::max(transmit, receive) >= warning_count) finding.verdict = Verdict::doubtful;
  }
  if (found.bus_offs.value_or(0) > 0)
    finding.figure += fmt::format(", {} bus-off so far", counted(*found.bus_offs, "time"));
  if (found.bus_state && *found.bus_state > can::BusState::active) finding.verdict = Verdict::doubtful;
  if (found.bus_state && *found.bus_state >= can::BusState::bus_off) finding.verdict = Verdict::bad;
  if (found.loopback || found.one_shot) {
    finding.verdict = Verdict::bad;
    finding.figure += found.loopback ? ", loopback mode" : ", one-shot mode";
    finding.cure = fmt::format("ip link set {0} down; ip link set {0} up type can {1} off", name,
                               found.loopback ? "loopback" : "one-shot");
  } else if (finding.verdict != Verdict::good) {
    finding.cure = "check wiring, termination (60 ohm between the lines) and the nodes' bit rates";
  }
  return finding;
}

/// Measures the time from one socket to another on the same interface. The frame passes the kernel and, on a
/// real interface, the wire, because the second socket gets it when it has been sent and acknowledged.
Finding examine_round_trip(const config::Config& config, const std::string& name) {
  const std::array only_test_frames{can::Filter{.id = test_id}};
  const Descriptor from(can::open_raw_socket(name, only_test_frames));
  const Descriptor to(can::open_raw_socket(name, only_test_frames));
  can::ReceiveBatch batch;
  controller::TimeStatistics times;
  for (int i = 0; i < round_trips; ++i) {
    const auto begun = std::chrono::steady_clock::now();
    const int error = can::write_frame(from.get(), {.id = test_id, .length = 0});
    pollfd readable{.fd = to.get(), .events = POLLIN, .revents = 0};
    if (error != 0 || ::poll(&readable, 1, 200) != 1 || batch.read(to.get()) < 1)
      return {"round trip", Verdict::bad,
              fmt::format("frame {} of {} did not come back{}", i + 1, round_trips,
                          error != 0 ? ": " + std::generic_category().message(error) : ""),
              "no node acknowledges: check that a node is on the bus, wiring and bit rate"};
    times.add(std::chrono::steady_clock::now() - begun);
  }
  const controller::TimeSummary summary = times.summary();
  const bool fast = summary.p99_us <= good_round_trip_share * 1e6 / config.controller.rate_Hz;
  return judged("round trip", fast,
                fmt::format("mean {:.0f} us, p99 {:.0f} us, max {:.0f} us", summary.mean_us, summary.p99_us,
                            summary.max_us),
                "see wake-up, priority and kernel; on USB adapters a hub and power saving cost too");
}

std::vector<std::string> fd_messages(const config::Config& config) {
  std::vector<std::string> messages;
  for (const config::AxisConfig& axis : config.axes)
    std::ranges::copy(config::fd_messages(axis.wire, config.database), std::back_inserter(messages));
  return messages;
}

}  // namespace

std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface,
                                       bool send) {
  try {
    const can::Interface found = can::require_can_interface(interface);
    can::require_able_to_send(interface, found);
    can::require_able_to_carry_fd(interface, found, fd_messages(config));
    std::vector<Finding> findings{{"interface", Verdict::good, interface + " is up"},
                                  examine_bit_rate(config, interface, found),
                                  examine_restart(interface, found),
                                  examine_queue(config, interface, found),
                                  examine_errors(interface, found)};
    if (send || can::is_virtual_interface(interface))
      findings.push_back(examine_round_trip(config, interface));
    else
      findings.push_back({"round trip", Verdict::good, "not tried: --send puts frames on this bus"});
    return findings;
  } catch (const RunError& error) {
    const std::string text = error.what();
    const auto cut = text.find("; ");
    return {
        {.check = "interface",
         .verdict = Verdict::bad,
         .figure = text.substr(0, cut),
         .cure = cut == std::string::npos ? "name another interface by --interface" : text.substr(cut + 2)}};
  }
}

}  // namespace hystcan::app
