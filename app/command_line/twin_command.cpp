#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/command_line/truth_log.h"
#include "app/live/answer_json.h"
#include "app/live/control_socket.h"
#include "app/live/live_loop.h"
#include "app/live/machine_setup.h"
#include "app/live/node_watch.h"
#include "app/live/sample_stream.h"
#include "app/live/samples.h"
#include "app/live/socket_place.h"
#include "app/live/twin_command_handler.h"
#include "app/stage/option_check.h"
#include "base/output_file.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"
#include "twin/twin.h"

namespace hystcan::app {
namespace {

struct TwinArguments {
  std::filesystem::path config;
  std::string interface;
  bool force_interface = false;
  std::vector<std::string> axes;
  std::string socket;
  std::filesystem::path truth;
};

std::vector<WatchedAmplifier> amplifiers_of(const twin::Twin& twin) {
  std::vector<WatchedAmplifier> amplifiers;
  amplifiers.reserve(twin.axes().size());
  for (const auto& axis : twin.axes()) amplifiers.push_back({axis->wire, &axis->amplifier});
  return amplifiers;
}

/// Logs when an injected fault begins and ends, in s since the start of the twin.
void log_faults(twin::Twin& twin, can::Time started) {
  twin.faults().on_event([started](const twin::FaultSpec& spec, bool begins, can::Time when) {
    spdlog::info("{:.3f} s: {} {}", can::seconds(when - started), twin::describe(spec),
                 begins ? "begins" : "ends");
  });
}

/// Opens the control socket and, in the same folder, the socket of the sample stream. If the default path
/// cannot be used, for example because another twin uses it, logs a warning and continues without sockets.
void open(std::optional<ControlSocket>& control, std::optional<SampleStream>& stream,
          const TwinArguments& options, const std::string& interface, LiveLoop& loop,
          TwinCommandHandler& handler, const std::string& greeting, SampleBoard& samples) {
  if (options.socket == "none") return;
  try {
    const std::filesystem::path file =
        options.socket.empty() ? default_twin_socket(interface) : std::filesystem::path(options.socket);
    control.emplace(loop.context(), file, handler);
    stream.emplace(loop.context(), stream_beside(file), greeting, samples);
    spdlog::info("control socket {}; to show the status: hystcan ctl --socket {} status", file.string(),
                 file.string());
  } catch (const RunError& error) {
    if (!options.socket.empty()) throw;
    spdlog::warn("the control socket cannot be opened: {}", error.what());
  }
}

twin::Config twin_of(const config::Config& config, const TwinArguments& options) {
  if (options.axes.empty()) return twin_config(config);
  return at_place("--axis", [&] { return twin::with_axes(twin_config(config), options.axes); });
}

std::vector<std::string> names_of(const twin::Config& config) {
  std::vector<std::string> names;
  names.reserve(config.axes.size());
  for (const twin::WiredAxisConfig& axis : config.axes) names.push_back(axis.wire.name);
  return names;
}

int run_twin(const TwinArguments& options) {
  const config::Config config = config::load(options.config);
  const twin::Config chosen = twin_of(config, options);
  const std::string interface = options.interface.empty() ? config.bus.interface : options.interface;
  if (!options.force_interface && !can::is_virtual_interface(interface))
    throw RunError(
        fmt::format("{} is a real CAN interface, on which a twin would answer instead of real nodes",
                    interface),
        {.remedy = "use --force-interface to allow this"});
  if (!options.truth.empty()) refuse_to_overwrite(options.truth, options.config);
  LiveLoop loop(interface);
  twin::Twin twin(chosen, config.database, loop.scheduler(), loop.attach());
  check_interface(config, interface);
  log_faults(twin, loop.scheduler().now());
  std::optional<TruthLog> truth;
  if (!options.truth.empty()) truth.emplace(options.truth, names_of(chosen));
  SampleBoard samples(truth_columns.size(), 10'000);
  twin.on_truth([&, started = loop.scheduler().now()](const twin::Truth& sampled) {
    if (truth) truth->write(sampled);
    if (samples.is_listening()) samples.put(sample_of(sampled, started));
  });
  twin.start();
  for (const twin::WiredAxisConfig& axis : chosen.axes)
    spdlog::info("{}: amplifier node {}, sensor node {} on {}", axis.wire.name, axis.wire.amplifier_node,
                 axis.wire.sensor_node, interface);
  const auto end = [&] {
    twin.shut_down();
    for (const auto& axis : twin.axes())
      spdlog::info("{}: amplifier off, at its safe value {:.3f}", axis->name, axis->plant.drive());
    loop.stop();
  };
  const auto stopping = loop.scheduler().make_timer(end);
  TwinCommandHandler handler(twin, loop.scheduler(), [&] {
    // The twin ends 20 ms after the command `stop` was executed, so that the client receives the answer
    // before the socket is closed.
    stopping->expire_at(loop.scheduler().now() + std::chrono::milliseconds(20));
  });
  std::optional<ControlSocket> socket;
  std::optional<SampleStream> stream;
  open(socket, stream, options, interface, loop, handler, as_json(stream_greeting(config, chosen)).dump(),
       samples);
  NodeWatch watch(twin.station(), amplifiers_of(twin), loop.scheduler(), interface, end);
  loop.run([&](int) { end(); });
  watch.log_bus();
  const auto lost_output = print_patiently(closing_text(twin.station(), amplifiers_of(twin)));
  if (truth)
    if (const auto lost = truth->close()) throw RunError(*lost);
  refuse_if_taken(twin.station(), interface);
  if (lost_output) throw RunError(*lost_output);
  return done;
}

}  // namespace

void add_twin(CLI::App& cli, int& status) {
  auto options = std::make_shared<TwinArguments>();
  CLI::App* command =
      cli.add_subcommand("twin", "Simulate the amplifier and sensor nodes of a stage on the bus");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  add_checked(*command, "--interface", options->interface, interface_name(),
              "CAN interface; default: as configured");
  command->add_flag("--force-interface", options->force_interface, "allow a real CAN interface");
  command->add_option("--axis", options->axes, "axis to simulate; repeat it for several (default: all)")
      ->allow_extra_args(false);
  command->add_option("--truth", options->truth,
                      "CSV file for the true motion of the stages, one row per sample");
  command->add_option("--socket", options->socket, "file of the control socket, or `none`");
  command->callback([options, &status] { status = run_twin(*options); });
}

}  // namespace hystcan::app
