#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/live.h"
#include "app/live_run.h"
#include "app/report.h"
#include "config/config.h"
#include "twin/twin.h"

namespace hystcan::app {
namespace {

struct Options {
  std::filesystem::path config;
  std::string interface;
  bool force_interface = false;
};

std::string_view to_string(can::AmpState state) {
  static constexpr std::array<std::string_view, 4> names{"off", "ready", "enabled", "tripped"};
  return names[static_cast<std::size_t>(state)];
}

/// Says what becomes of the amplifiers and of the bus.
class Watch {
 public:
  /// `on_taken`: somebody else is one of the nodes.
  Watch(const twin::Twin& twin, can::Scheduler& scheduler, const std::string& interface,
        std::function<void()> on_taken)
      : twin_(twin),
        scheduler_(scheduler),
        started_(scheduler.now()),
        seen_(twin.axes().size()),
        bus_log_(interface, bus_log_sink()),
        on_taken_(std::move(on_taken)),
        timer_(scheduler.make_timer([this] { look(); })) {
    look();
  }

  void log_bus() {
    const auto connections = twin_.connections();
    bus_log_.sample(controller::report_of(connections, can::seconds(scheduler_.now() - started_)));
    bus_log_.write();
  }

 private:
  void look() {
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const twin::AmplifierNode& amplifier = twin_.axes()[i]->amplifier;
      if (std::exchange(seen_[i], amplifier.state()) == amplifier.state()) continue;
      const bool silence = (amplifier.fault() & can::amp_fault::command_timeout) != 0;
      spdlog::info("{}: amplifier {}{}", twin_.axes()[i]->name, to_string(amplifier.state()),
                   silence ? ": commands have stopped, output at its safe value" : "");
    }
    log_bus();
    if (twin_.taken_node()) return on_taken_();
    timer_->expire_at(scheduler_.now() + std::chrono::milliseconds(50));
  }

  const twin::Twin& twin_;
  can::Scheduler& scheduler_;
  can::Time started_;
  std::vector<can::AmpState> seen_;
  controller::BusLog bus_log_;
  std::function<void()> on_taken_;
  std::unique_ptr<can::Timer> timer_;
};

BusClosing closing_of(const twin::Twin& twin) {
  const auto connections = twin.connections();
  BusClosing closing{.bus = controller::report_of(connections, 0.0)};
  closing.rejected.reserve(twin.axes().size());
  for (const auto& axis : twin.axes())
    closing.rejected.push_back(can::rejected_frames(can::message_map<can::AmpCommand>(axis->wire)->message,
                                                    axis->amplifier.checker()));
  return closing;
}

int run_twin(const Options& options) {
  const config::Config config = config::load(options.config);
  const std::string interface = options.interface.empty() ? config.bus.interface : options.interface;
  if (!options.force_interface && !can::is_virtual_interface(interface))
    throw RunError(
        fmt::format("{} is a real CAN interface: a twin on it would answer in the place of real nodes; "
                    "--force-interface if that is what you want",
                    interface));
  LiveLoop loop(interface);
  twin::Twin twin(config.twin, config.database, loop.scheduler(), loop.attach());
  look_at_interface(config, interface);
  twin.start();
  for (const twin::AxisConfig& axis : config.twin.axes)
    spdlog::info("{}: amplifier node {}, sensor node {} on {}", axis.wire.name, axis.wire.amplifier_node,
                 axis.wire.sensor_node, interface);
  const auto end = [&] {
    twin.shut_down();
    for (const auto& axis : twin.axes())
      spdlog::info("{}: amplifier off, at its safe value {:.3f}", axis->name, axis->plant.drive());
    loop.stop();
  };
  Watch watch(twin, loop.scheduler(), interface, end);
  loop.run([&](int) { end(); });
  watch.log_bus();
  for (const std::string& line : describe(closing_of(twin))) fmt::print("{}\n", line);
  if (const auto node = twin.taken_node())
    throw RunError(
        fmt::format("{}: node {} is on this bus already: another twin, or the real node; end one of the two",
                    interface, *node));
  return done;
}

}  // namespace

void add_twin(CLI::App& cli, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command = cli.add_subcommand("twin", "Answer on the bus as amplifier and sensor nodes would");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  command->add_option("--interface", options->interface, "CAN interface instead of the configured one");
  command->add_flag("--force-interface", options->force_interface, "allow an interface that is not virtual");
  command->callback([options, &status] { status = run_twin(*options); });
}

}  // namespace hystcan::app
