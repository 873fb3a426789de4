// Checks the cards of analogue axes and the process that drives them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>

#include "app/live/card_opener.h"
#include "app/live/doctor.h"
#include "app/live/realtime.h"
#include "base/text.h"
#include "can/socketcan/asio_scheduler.h"
#include "controller/timing.h"
#include "node/analogue/axis_card.h"
#include "node/analogue/axis_check.h"

namespace hystcan::app {
namespace {

/// Maximum duration of one position measurement (a sample), as a share of the cycle period, for a good
/// verdict. A longer measurement leaves too little time for the output and other axes.
constexpr double good_sample_share = 0.2;
constexpr int most_samples = 1000;
constexpr std::chrono::milliseconds longest_sampling{300};

/// Samples of a sensor, taken as fast as the card delivers them.
struct Sampling {
  controller::TimeStatistics times;
  int count = 0;
  double sum_um = 0.0, sum_um2 = 0.0;  ///< sums of d and of d^2 (d: position minus first position, in um)
  int without_position = 0;

  double rms_nm() const {
    const double mean_um = sum_um / count;
    return 1e3 * std::sqrt(std::max(0.0, sum_um2 / count - mean_um * mean_um));
  }
};

Sampling sample(node::CardInput& input) {
  Sampling result;
  std::optional<double> first_um;
  const auto begun = std::chrono::steady_clock::now();
  for (auto at = begun; at - begun < longest_sampling && result.count < most_samples; ++result.count) {
    const node::PositionInput::Reading reading = input.read({});
    const auto end = std::chrono::steady_clock::now();
    result.times.add(end - std::exchange(at, end));
    result.without_position += reading.status != 0 ? 1 : 0;
    if (!first_um) first_um = reading.position_um;
    const double um = reading.position_um - *first_um;
    result.sum_um += um;
    result.sum_um2 += um * um;
  }
  return result;
}

Finding examine_output(const node::WiredAnalogueAxis& axis, const node::VoltageRange& range) {
  const double volts_per_drive = axis.config.volts_per_drive;
  return {axis.wire.name + " output", Verdict::good,
          fmt::format("range {} V, of which the drives use {} V; resolution {:.3g} {}",
                      node::from_to(range.lo, range.hi),
                      node::from_to(volts_per_drive * axis.drives.min, volts_per_drive * axis.drives.max),
                      range.step / std::abs(volts_per_drive), axis.wire.drive_unit)};
}

Finding examine_input(const node::WiredAnalogueAxis& axis, const node::VoltageRange& range) {
  const node::AnalogueConfig& config = axis.config;
  const std::string warning = node::stroke_warning(config, axis.positions, range);
  return judged(
      axis.wire.name + " input", warning.empty(),
      !warning.empty()
          ? warning
          : fmt::format("range {} V measures {} um; resolution {:.3g} nm", node::from_to(range.lo, range.hi),
                        node::from_to(config.position_um(range.lo), config.position_um(range.hi)),
                        1e3 * std::abs(config.position_um_per_V) * range.step),
      "choose another range of position_input, or correct position_um_per_V and position_zero_um");
}

std::vector<Finding> examine_samples(const node::WiredAnalogueAxis& wired, node::CardInput& input,
                                     double rate_Hz) {
  const std::string& axis = wired.wire.name;
  const Sampling samples = sample(input);
  if (samples.without_position > 0)
    return {{axis + " noise", Verdict::bad,
             fmt::format("{} of {} samples have no position", samples.without_position, samples.count),
             "check the sensor's supply and cable, and the range of position_input (hystcan node --read)"}};
  const controller::TimeSummary times = samples.times.summary();
  const double period_us = 1e6 / rate_Hz;
  return {
      {axis + " noise", Verdict::good,
       fmt::format("{:.3g} nm RMS in {} samples", samples.rms_nm(), samples.count)},
      judged(axis + " sample", times.p99_us <= good_sample_share * period_us,
             fmt::format("mean {:.0f} us, p99 {:.0f} us, max {:.0f} us for {}", times.mean_us, times.p99_us,
                         times.max_us, counted(wired.config.position_input.average, "conversion")),
             "reduce average of position_input, use a faster card, or reduce rate_Hz")};
}

std::vector<Finding> examine_axis(const config::Config& config, const node::WiredAnalogueAxis& axis,
                                  node::Cards& cards) try {
  node::AxisCard card(cards, axis.config.device);
  const node::VoltageRange output = node::check_channels(axis, card);
  if (axis.config.output_input)
    node::opened("output_input", [&] { return card.input(*axis.config.output_input); });
  node::CardInput input(axis.config, card);
  node::check_positions(axis.config, axis.positions, input.range());
  const std::string& other = axis.config.position_input.place.device;
  std::vector<Finding> findings{
      {axis.wire.name + " device", Verdict::good,
       other.empty() ? axis.config.device : fmt::format("{}, input {}", axis.config.device, other)},
      examine_output(axis, output),
      examine_input(axis, input.range())};
  std::ranges::move(examine_samples(axis, input, config.controller.rate_Hz), std::back_inserter(findings));
  return findings;
} catch (const node::ChannelError& error) {
  return {refused(axis.wire.name + " " + error.key, Verdict::bad, error)};
}

/// Returns the folders in /proc of all processes `hystcan node`. Skips the guard process of each node, which
/// writes the safe drives if the node ends; its name is hystcan-guard.
std::vector<std::filesystem::path> node_processes(const std::filesystem::path& root) {
  std::vector<std::filesystem::path> found;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(root / "proc", none)) {
    if (!parsed_number<int>(entry.path().filename().string())) continue;
    if (first_line(entry.path() / "comm") != "hystcan") continue;
    const std::string arguments = first_line(entry.path() / "cmdline");  // each argument ends with a NUL
    if (arguments.find(std::string("\0node\0", 6)) != std::string::npos) found.push_back(entry.path());
  }
  return found;
}

Finding examine_node(const std::filesystem::path& process) {
  const SchedulingClass scheduling = class_of(process);
  const std::string locked = status_of(process, "VmLck:");
  return judged("node", scheduling.is_realtime() && !locked.starts_with("0 "),
                fmt::format("process {}: {}, {} locked", process.filename().string(), to_string(scheduling),
                            locked.empty() ? "nothing" : locked),
                "set priority and lock_memory in [controller.realtime], and restart the node");
}

Finding examine_future_node(const controller::Realtime& configured) {
  return judged("node", configured.priority > 0 && configured.lock_memory,
                fmt::format("not running; will run with {}, memory {}",
                            configured.priority > 0 ? fmt::format("FIFO {}", node_priority(configured))
                                                    : "no real-time priority",
                            configured.lock_memory ? "locked" : "not locked"),
                "set priority and lock_memory in [controller.realtime]");
}

}  // namespace

std::vector<Finding> examine_analogue(const config::Config& config, const std::filesystem::path& root) {
  const std::vector<node::WiredAnalogueAxis> axes = analogue_axes(config);
  if (axes.empty()) return {};
  std::vector<Finding> findings;
  std::ranges::transform(node_processes(root), std::back_inserter(findings), examine_node);
  if (!findings.empty()) {
    findings.push_back({"cards", Verdict::good, "not checked: the running node uses them"});
    return findings;
  }
  findings.push_back(examine_future_node(config.controller.realtime.value_or(controller::Realtime{})));
  boost::asio::io_context context;
  can::AsioScheduler scheduler(context);
  node::Cards cards(card_opener(config, axes, scheduler));
  for (const node::WiredAnalogueAxis& axis : axes)
    std::ranges::move(examine_axis(config, axis, cards), std::back_inserter(findings));
  return findings;
}

}  // namespace hystcan::app
