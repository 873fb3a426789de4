#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/card_opener.h"
#include "app/live/live_loop.h"
#include "app/live/machine_setup.h"
#include "app/live/node_watch.h"
#include "app/live/realtime.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "config/document/document.h"
#include "config/schema/config.h"
#include "node/analogue/analogue_station.h"
#include "node/analogue/guard.h"

namespace hystcan::app {
namespace {

struct NodeArguments {
  std::filesystem::path config;
  std::string interface;
  bool reads = false;
};

using AnalogueAxes = std::vector<node::WiredAnalogueAxis>;

/// Calls `open`, which opens a channel of the axis on its card. If that fails, throws an error that names the
/// key of the channel in the configuration.
template <class Open>
auto at_its_key(const config::Config& config, const node::WiredAnalogueAxis& axis, Open open) {
  try {
    return open();
  } catch (const node::ChannelError& error) {
    const auto found = std::ranges::find(config.axes, axis.wire.name,
                                         [](const config::AxisConfig& one) { return one.wire.name; });
    config::Document(config.file)
        .fail_at(fmt::format("axis[{}].analogue.{}", found - config.axes.begin(), error.key), error.what());
  }
}

/// Formats a value with this number of decimals. A number that rounds to zero has no sign.
std::string fixed(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return text.starts_with('-') && text.find_first_of("123456789") == std::string::npos ? text.substr(1)
                                                                                       : text;
}

void warn_of_stroke(const node::WiredAnalogueAxis& axis, const node::VoltageRange& input) {
  const std::string warning = node::stroke_warning(axis.config, axis.positions, input);
  if (!warning.empty())
    spdlog::warn("{}: {}; choose a larger range of position_input", axis.wire.name, warning);
}

/// Reads the position of an axis and, if it is wired, the monitor output of the amplifier from the card, for
/// `hystcan node --read`. Writes nothing to the card.
class Readings {
 public:
  Readings(const node::WiredAnalogueAxis& axis, node::Cards& cards) : axis_(axis) {
    node::AxisCard card(cards, axis.config.device);
    node::check_channels(axis, card);
    position_ = node::opened("position_input", [&] { return card.input(axis.config.position_input.place); });
    node::check_positions(axis.config, axis.positions, position_->range());
    warn_of_stroke(axis, position_->range());
    if (const auto& monitor = axis.config.output_input)
      output_ = node::opened("output_input", [&] { return card.input(*monitor); });
  }

  std::string line() {
    const node::AnalogueConfig& config = axis_.config;
    std::string text = fmt::format(
        "{}: position {}", axis_.wire.name,
        in_volts(*position_, [&](double volts) { return fixed(config.position_um(volts), 4) + " um"; }));
    if (output_)
      text += fmt::format("; output {}", in_volts(*output_, [&](double volts) {
                            return fixed(volts / config.volts_per_drive, 4) + " " + axis_.wire.drive_unit;
                          }));
    return text + "\n";
  }

 private:
  static std::string in_volts(node::VoltageInput& input, const std::function<std::string(double)>& physical) {
    const std::optional<double> volts = input.read();
    if (!volts) return "conversion failed";
    return fmt::format("{} V = {}", fixed(*volts, 5), physical(*volts));
  }

  const node::WiredAnalogueAxis& axis_;
  std::unique_ptr<node::VoltageInput> position_;
  std::unique_ptr<node::VoltageInput> output_;  ///< input for the amplifier's monitor output; null: not wired
};

int show_readings(const config::Config& config, const AnalogueAxes& axes) {
  boost::asio::io_context context;
  can::AsioScheduler scheduler(context);
  boost::asio::signal_set signals(context, SIGINT, SIGTERM);
  signals.async_wait([&](const boost::system::error_code&, int) { context.stop(); });
  node::Cards cards(card_opener(config, axes, scheduler));
  std::vector<std::unique_ptr<Readings>> all;
  for (const node::WiredAnalogueAxis& axis : axes)
    all.push_back(at_its_key(config, axis, [&] { return std::make_unique<Readings>(axis, cards); }));
  std::unique_ptr<can::Timer> timer;
  const auto show = [&] {
    for (const auto& one : all) print(one->line());
    flush_output();
    timer->expire_at(scheduler.now() + std::chrono::milliseconds(200));
  };
  timer = scheduler.make_timer(show);
  show();
  context.run();
  return done;
}

node::AllDevices open_devices(const config::Config& config, const AnalogueAxes& axes, node::Cards& cards) {
  node::AllDevices devices;
  for (const node::WiredAnalogueAxis& axis : axes)
    devices.push_back(
        at_its_key(config, axis, [&] { return std::make_unique<node::AnalogueDevices>(axis, cards); }));
  for (const auto& one : devices) warn_of_stroke(one->axis, one->input.range());
  return devices;
}

/// Returns how long the guard waits for the node before it makes the outputs safe. This is the shortest
/// watchdog time of all axes, but at least 10 ms, so that short delays of the node have no effect.
node::Guard::Duration patience_of(const AnalogueAxes& axes) {
  node::Guard::Duration shortest = std::chrono::hours(1);
  for (const node::WiredAnalogueAxis& axis : axes)
    shortest = std::min(shortest, axis.config.amplifier.command_timeout);
  return std::max<node::Guard::Duration>(shortest, std::chrono::milliseconds(10));
}

/// Starts a guard: a process that writes the safe drives if the node hangs or ends. Before that, a trial with
/// another guard shows that a guard can do this. Throws RunError if the trial fails.
std::unique_ptr<node::Guard> tried_guard(const node::AllDevices& devices, node::Guard::Duration patience) {
  const auto make_safe = [&devices] {
    bool all = true;
    for (const auto& one : devices) all = one->output.make_safe() && all;
    return all;
  };
  node::Guard trial(make_safe, patience);
  const auto begun = std::chrono::steady_clock::now();
  if (!trial.abandon())
    throw RunError(
        "the guard cannot write the safe drives: the card rejects them, or another program uses the card; "
        "check the card, and stop the other program");
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begun;
  auto guard = std::make_unique<node::Guard>(make_safe, patience);
  for (const auto& one : devices) one->output.obey(guard->takeovers());
  spdlog::info("guard process {}: test passed, outputs safe within {:.1f} ms", guard->process(),
               took.count());
  return guard;
}

/// Moves each simulated stage once before the controller starts. The first motion of a simulated stage takes
/// milliseconds of computing time, so that the controller would miss cycles. On a real card this writes only
/// the safe drives, which the guard's trial has already written.
void move_once(const node::AllDevices& devices, can::Time now) {
  for (const auto& one : devices) {
    one->output.make_safe();
    one->input.read(now);
  }
}

/// Calls Guard::beat() from the event loop, four times in each time `patience`. The guard is a second
/// process. If this process hangs, the guard gets no beat, and writes the safe drives after `patience`.
class GuardBeat {
 public:
  GuardBeat(node::Guard& guard, node::Guard::Duration patience, can::Scheduler& scheduler)
      : guard_(guard),
        period_(patience / 4),
        scheduler_(scheduler),
        timer_(scheduler.make_timer([this] { beat(); })) {
    beat();
  }

 private:
  void beat() {
    guard_.beat();
    if (const unsigned known = std::exchange(known_, guard_.takeovers()); known != known_)
      spdlog::warn(
          "the node was delayed, and its guard set the outputs to the safe drives; see `hystcan doctor`");
    timer_->expire_at(scheduler_.now() + period_);
  }

  node::Guard& guard_;
  node::Guard::Duration period_;
  can::Scheduler& scheduler_;
  unsigned known_ = 0;
  std::unique_ptr<can::Timer> timer_;
};

/// Applies [controller.realtime] to this process (`hystcan node`), except for `cpus`, because those CPUs are
/// for the control thread. Then sets the priority to node_priority(), one above the control thread. If the
/// kernel refuses this priority, the process keeps the priority of the control thread.
void become_realtime_beside(const config::Config& config) {
  if (!config.controller.realtime) return;
  config::Config elsewhere = config;
  elsewhere.controller.realtime->cpus.clear();
  become_realtime(elsewhere);
  if (const int priority = node_priority(*config.controller.realtime); priority > 0) take_priority(priority);
}

std::vector<WatchedAmplifier> amplifiers_of(const node::AnalogueStation& station) {
  std::vector<WatchedAmplifier> amplifiers;
  for (const auto& axis : station.axes()) amplifiers.push_back({axis->wire, &axis->amplifier});
  return amplifiers;
}

int run_node(const NodeArguments& options) {
  const config::Config config = config::load(options.config);
  const AnalogueAxes axes = analogue_axes(config);
  if (axes.empty())
    throw Error(config.file, "no axis has the table [axis.analogue]",
                {.remedy = "add the table, with the DAQ card, to at least one axis"});
  if (options.reads) return show_readings(config, axes);
  const std::string interface = options.interface.empty() ? config.bus.interface : options.interface;
  LiveLoop loop(interface);
  node::Cards cards(card_opener(config, axes, loop.scheduler()));
  const node::AllDevices devices = open_devices(config, axes, cards);
  const node::Guard::Duration patience = patience_of(axes);
  // The guard is a copy of this process and would also have its sockets. It is therefore started before any
  // socket exists.
  const auto guard = tried_guard(devices, patience);
  node::AnalogueStation station(devices, twin_config(config), config.database, loop.scheduler(),
                                loop.attach());
  check_interface(config, interface);
  become_realtime_beside(config);
  move_once(devices, loop.scheduler().now());
  station.station().start([&] { move_once(devices, loop.scheduler().now()); });
  for (const node::WiredAnalogueAxis& axis : axes)
    spdlog::info("{}: amplifier node {}, sensor node {} on {}, {}", axis.wire.name, axis.wire.amplifier_node,
                 axis.wire.sensor_node, interface, axis.config.device);
  const auto end = [&] {
    station.station().shut_down();
    loop.stop();
  };
  bool guard_died = false;
  boost::asio::posix::stream_descriptor end_of_guard(loop.context(), guard->descriptor());
  end_of_guard.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                          [&](const boost::system::error_code& error) {
                            if (error) return;
                            guard_died = true;
                            end();
                          });
  NodeWatch watch(station.station(), amplifiers_of(station), loop.scheduler(), interface, end);
  const GuardBeat beat(*guard, patience, loop.scheduler());
  loop.run([&](int) { end(); });
  end_of_guard.release();
  watch.log_bus();
  const auto lost_output = print_patiently(closing_text(station.station(), amplifiers_of(station)));
  refuse_if_taken(station.station(), interface);
  if (guard_died)
    throw RunError("the guard process ended, and the outputs have their safe drives; restart the node");
  if (!guard->abandon()) throw RunError("the card rejects the safe drives; switch the amplifiers off");
  if (lost_output) throw RunError(*lost_output);
  return done;
}

}  // namespace

void add_node(CLI::App& cli, int& status) {
  auto options = std::make_shared<NodeArguments>();
  CLI::App* command =
      cli.add_subcommand("node", "Run the amplifier and sensor nodes of analogue axes on a DAQ card");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  add_checked(*command, "--interface", options->interface, interface_name(),
              "CAN interface; default: as configured");
  command->add_flag("--read", options->reads,
                    "print volts and physical values five times a second; write nothing to the card");
  command->callback([options, &status] { status = run_node(*options); });
}

}  // namespace hystcan::app
