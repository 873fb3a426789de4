#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/commands.h"
#include "app/live.h"
#include "config/config.h"
#include "twin/twin.h"

namespace hystcan::app {
namespace {

struct Options {
  std::filesystem::path config;
  std::string interface;
  bool force_interface = false;
};

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
  twin.start();
  for (const twin::AxisConfig& axis : config.twin.axes)
    spdlog::info("{}: amplifier node {}, sensor node {} on {}", axis.wire.name, axis.wire.amplifier_node,
                 axis.wire.sensor_node, interface);
  loop.run([&] {
    twin.shut_down();
    for (const auto& axis : twin.axes())
      spdlog::info("{}: amplifier off, at its safe value {:.3f}", axis->name, axis->plant.drive());
    loop.stop();
  });
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
