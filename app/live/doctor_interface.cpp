// The checks of `hystcan doctor` for the CAN interface.
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

/// Maximum length of the transmit queue for a good verdict. This program queues at most eight frames at a
/// time. A longer queue can fill with frames of other programs, which then delay the commands.
constexpr std::uint32_t long_queue_frames = 100;
/// Error counter value at which the controller state "error warning" begins (ISO 11898-1).
constexpr unsigned warning_count = 96;

/// Maximum round-trip time of a frame, as a share of the cycle period, for a good verdict. A longer round
/// trip leaves too little time for the sample, the command and the other axes.
constexpr double good_round_trip_share = 0.2;
constexpr int round_trips = 200;
constexpr std::chrono::milliseconds format_listening{300};
constexpr std::size_t most_heard = 1000;
constexpr std::uint32_t test_id = 0x7FF;  ///< identifier with the lowest priority; CANopen does not use it

Finding examine_bit_rate(const config::Config& config, const std::string& name, const can::Interface& found) {
  const double wanted = config.bus.bitrate_bit_per_s;
  if (!found.bitrate_bit_per_s) return {"bit rate", Verdict::good, "none (virtual interface)"};
  const double real = *found.bitrate_bit_per_s;
  std::string figure =
      fmt::format("{:g} kbit/s, sample point {:g} %", 1e-3 * real, 100.0 * found.sample_point.value_or(0.0));
  if (found.data_bitrate_bit_per_s)
    figure += fmt::format(", {:g} kbit/s in the data phase", 1e-3 * *found.data_bitrate_bit_per_s);
  if (real != wanted)
    return {"bit rate", Verdict::bad, fmt::format("{}, configured {:g} kbit/s", figure, 1e-3 * wanted),
            fmt::format("ip link set {0} down; "
                        "ip link set {0} up type can bitrate {1:.0f}, or correct bitrate_bit_per_s",
                        name, wanted)};
  const bool has_fd = !config::fd_messages(config).empty() && found.data_bitrate_bit_per_s.has_value();
  if (!has_fd || config.bus.data_bitrate_bit_per_s != 0) return {"bit rate", Verdict::good, figure};
  return {"bit rate", Verdict::doubtful,
          figure + ", but the configuration has no bit rate for the data phase",
          fmt::format("CAN FD frames are sent without bit-rate switch, and many nodes do not answer them; "
                      "set bus.data_bitrate_bit_per_s = {}",
                      *found.data_bitrate_bit_per_s)};
}

Finding examine_restart(const std::string& name, const can::Interface& found) {
  if (!found.restart_ms) return {"restart-ms", Verdict::good, "none (never bus-off)"};
  return judged("restart-ms", *found.restart_ms > 0, std::to_string(*found.restart_ms),
                fmt::format("the interface does not recover from bus-off by itself; ip link set {0} down; "
                            "ip link set {0} up type can restart-ms 100",
                            name));
}

Finding examine_queue(const config::Config& config, const std::string& name, const can::Interface& found) {
  const std::uint32_t frames = found.transmit_queue_frames;
  // The queue must hold the frames of one cycle: the SYNC, a command for each axis, and one heartbeat or
  // status.
  const auto needed = static_cast<std::uint32_t>(config.axes.size() + 2);
  const bool fits = frames >= needed && frames <= long_queue_frames;
  return judged("queue", found.queue_discipline == "noqueue" || fits,
                fmt::format("{}, {}", counted(frames, "frame"),
                            found.queue_discipline.empty() ? "none" : found.queue_discipline),
                fmt::format("ip link set {} txqueuelen {}: {}", name, std::max(10U, 2 * needed),
                            frames < needed ? "the frames of one cycle must fit into the queue"
                                            : "frames in a long queue are old when they are sent"));
}

Finding examine_errors(const std::string& name, const can::Interface& found) {
  Finding finding{.check = "errors",
                  .verdict = Verdict::good,
                  .figure = found.bus_state ? std::string(to_string(*found.bus_state)) : "not reported"};
  if (found.error_counters) {
    const auto [transmit, receive] = *found.error_counters;
    finding.figure += fmt::format(", error counters {} transmit, {} receive", transmit, receive);
    if (std::max(transmit, receive) >= warning_count) finding.verdict = Verdict::doubtful;
  }
  if (found.bus_offs.value_or(0) > 0)
    finding.figure += fmt::format(", bus-off {} so far", counted(*found.bus_offs, "time"));
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

/// Measures the time of a frame from one socket to another socket on the same interface. On a real interface,
/// the second socket receives the frame only after it was sent on the wire and acknowledged by a node.
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
              fmt::format("test frame {} of {} was not received{}", i + 1, round_trips,
                          error != 0 ? ": " + std::generic_category().message(error) : ""),
              "no node acknowledges frames; check that a node is on the bus, the wiring and the bit rate"};
    times.add(std::chrono::steady_clock::now() - begun);
  }
  const controller::TimeSummary summary = times.summary();
  const bool fast = summary.p99_us <= good_round_trip_share * 1e6 / config.controller.rate_Hz;
  return judged("round trip", fast,
                fmt::format("mean {:.0f} us, p99 {:.0f} us, max {:.0f} us", summary.mean_us, summary.p99_us,
                            summary.max_us),
                "see the rows wake-up, priority and kernel; USB hubs and USB power saving also add delay");
}

/// Returns the frames of configured messages that arrive within the time `format_listening`.
std::vector<can::Frame> listen(const config::Config& config, const std::string& name) {
  std::vector<can::Filter> filters;
  for (const config::AxisConfig& axis : config.axes)
    for (const can::Message* message : config::messages_of(axis.wire, config.database))
      filters.push_back({.id = message->id, .extended = message->extended});
  const Descriptor socket(can::open_raw_socket(name, filters));
  can::ReceiveBatch batch;
  std::vector<can::Frame> heard;
  const auto until = std::chrono::steady_clock::now() + format_listening;
  for (auto left = format_listening; left > left.zero() && heard.size() < most_heard;
       left = std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now())) {
    pollfd readable{.fd = socket.get(), .events = POLLIN, .revents = 0};
    if (::poll(&readable, 1, static_cast<int>(left.count())) != 1) break;
    const int count = batch.read(socket.get());
    for (int i = 0; i < count; ++i) heard.push_back(batch.frame(static_cast<std::size_t>(i)));
  }
  return heard;
}

std::string format_of(can::FrameKind kind, bool bit_rate_switch) {
  if (kind == can::FrameKind::remote) return "a remote frame";
  if (kind != can::FrameKind::fd) return "a classical frame";
  return bit_rate_switch ? "CAN FD with bit-rate switch" : "CAN FD without bit-rate switch";
}

}  // namespace

Finding examine_formats(const config::Config& config, std::span<const can::Frame> heard) {
  std::size_t messages_heard = 0;
  for (const config::AxisConfig& axis : config.axes) {
    for (const can::Message* message : config::messages_of(axis.wire, config.database)) {
      const auto found = std::ranges::find_if(heard, [&](const can::Frame& frame) {
        return frame.id == message->id && frame.extended == message->extended &&
               frame.kind != can::FrameKind::error;
      });
      if (found == heard.end()) continue;
      ++messages_heard;
      const std::string is = format_of(found->kind, (found->fd_flags & can::fd_bit_rate_switch) != 0);
      const std::string expected =
          format_of(can::wire_kind(message->length, message->fd), message->bit_rate_switch);
      if (is == expected) continue;
      const bool is_used = found->kind == can::FrameKind::fd && message->fd;
      return {"frame format", Verdict::bad, fmt::format("{} arrives as {}", message->name, is),
              fmt::format("set {} to send {}: the attributes VFrameFormat and CANFD_BRS in {} "
                          "and bus.data_bitrate_bit_per_s = {} require this format; {}",
                          message->sender.empty() ? "the node" : message->sender, expected,
                          config.bus.dbc.string(), config.bus.data_bitrate_bit_per_s,
                          is_used ? "many nodes do not answer frames without bit-rate switch"
                                  : "the controller ignores frames of another format")};
    }
  }
  return {"frame format", Verdict::good,
          messages_heard == 0 ? "no frames received"
                              : fmt::format("{} as defined in the DBC", counted(messages_heard, "message"))};
}

std::vector<Finding> examine_interface(const config::Config& config, const std::string& interface,
                                       bool send) {
  try {
    const can::Interface found = can::require_can_interface(interface);
    can::require_able_to_send(interface, found);
    can::require_able_to_carry_fd(interface, found, config::fd_messages(config), config.bus.rates());
    std::vector<Finding> findings{{"interface", Verdict::good, interface + " is up"},
                                  examine_bit_rate(config, interface, found),
                                  examine_restart(interface, found),
                                  examine_queue(config, interface, found),
                                  examine_errors(interface, found),
                                  examine_formats(config, listen(config, interface))};
    if (send || can::is_virtual_interface(interface))
      findings.push_back(examine_round_trip(config, interface));
    else
      findings.push_back(
          {"round trip", Verdict::good, "not measured; --send measures it with frames on this bus"});
    return findings;
  } catch (const RunError& error) {
    Finding finding = refused("interface", Verdict::bad, error);
    if (finding.cure.empty()) finding.cure = "choose another interface with --interface";
    return {finding};
  }
}

}  // namespace hystcan::app
