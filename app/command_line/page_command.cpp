#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/socket_place.h"
#include "app/page/page_host.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "base/threads.h"
#include "config/schema/config.h"
#include "controller/telemetry.h"

namespace hystcan::app {
namespace {

struct PageArguments {
  std::filesystem::path config;
  std::string interface;
  std::string listen = "127.0.0.1:8080";
  std::vector<std::string> names;
  std::filesystem::path socket, twin_socket;
  bool expose = false;
  bool token = false;
};

PageOptions page_options(const PageArguments& arguments, const config::Config& config) {
  const std::string interface = config.bus.interface;
  const std::filesystem::path configured =
      arguments.socket.empty() ? std::filesystem::path(config.controller.control_socket) : arguments.socket;
  return {
      .config = std::filesystem::absolute(arguments.config),
      .interface = interface,
      .frames = average_frames(config),
      .start_command = fmt::format("hystcan controller {}", shell_word(arguments.config)),
      .controller_socket = [=] { return configured.empty() ? find_socket(interface) : configured; },
      .twin_socket =
          [=, given = arguments.twin_socket] { return given.empty() ? find_twin_socket(interface) : given; }};
}

int run_page(const PageArguments& arguments) {
  config::Config config = config::load(arguments.config);
  if (!arguments.interface.empty()) config.bus.interface = arguments.interface;
  if (arguments.token) {
    print(token_of(find_page_token(config.bus.interface)) + "\n");
    return done;
  }
  const std::filesystem::path file = page_token(config.bus.interface);
  const std::string token = token_of(file);
  PageListening listening = PageListening::at(arguments.listen);
  listening.names = arguments.names;
  listening.expose = arguments.expose;
  PageHost host(page_options(arguments, config), listening, token);
  print(fmt::format("page: {}\n", host.url()));
  flush_output();
  spdlog::info("the token that allows changes in the page is in {}; show it with hystcan page {} --token",
               file.string(), shell_word(arguments.config));
  yield_to_the_control_thread();
  host.run();
  return done;
}

}  // namespace

void add_page(CLI::App& cli, int& status) {
  auto options = std::make_shared<PageArguments>();
  CLI::App* command =
      cli.add_subcommand("page", "Serve the operator's page of a running controller or twin to browsers");
  command->add_option("CONFIG", options->config, "configuration (TOML) of the controller")->required();
  add_checked(*command, "--interface", options->interface, interface_name(),
              "CAN interface; default: as configured");
  command->add_option("--listen", options->listen, "address and port; port 0 selects any free port")
      ->capture_default_str();
  command->add_flag("--expose", options->expose,
                    "allow an address that other machines can reach (not encrypted)");
  command->add_option("--name", options->names,
                      "additional host name of this machine that a browser may use in its address");
  command->add_option(
      "--socket", options->socket,
      "control socket of the controller; default: control_socket in CONFIG, or if it is empty, the "
      "usual one for the CAN interface");
  command->add_option("--twin-socket", options->twin_socket,
                      "control socket of the twin; default: the usual one for the CAN interface");
  command->add_flag("--token", options->token,
                    "print the token that you enter in the page to allow changes, then end");
  command->callback([options, &status] { status = run_page(*options); });
}

}  // namespace hystcan::app
