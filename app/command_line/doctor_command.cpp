#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/command_line/commands.h"
#include "app/live/doctor.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

struct DoctorArguments {
  std::filesystem::path config;
  std::string interface;
  bool send = false;
  bool json = false;
};

Verdict worst_of(const std::vector<Finding>& findings) {
  return std::ranges::max(findings, {}, &Finding::verdict).verdict;
}

void print_findings_json(const std::vector<Finding>& findings) {
  nlohmann::json checks = nlohmann::json::array();
  for (const Finding& finding : findings)
    checks.push_back({{"check", finding.check},
                      {"verdict", to_string(finding.verdict)},
                      {"figure", finding.figure},
                      {"cure", finding.cure}});
  print("{}\n",
        nlohmann::json{{"verdict", to_string(worst_of(findings))}, {"checks", std::move(checks)}}.dump(2));
}

void print_text(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    print("{:<9} {:<14} {}\n", to_string(finding.verdict), finding.check, finding.figure);
    if (!finding.cure.empty()) print("{:<25}-> {}\n", "", finding.cure);
  }
}

int run_doctor(const DoctorArguments& options) {
  const config::Config config = config::load(options.config);
  const std::string interface = options.interface.empty() ? config.bus.interface : options.interface;

  std::vector<Finding> findings = examine_machine(config.controller);
  std::ranges::move(examine_process(config.controller), std::back_inserter(findings));
  findings.push_back(examine_wake_up(config.controller, std::chrono::seconds(1)));
  findings.push_back(examine_receive_path(config.controller, interface));
  std::ranges::move(examine_interface(config, interface, options.send), std::back_inserter(findings));
  std::ranges::move(examine_analogue(config), std::back_inserter(findings));

  if (options.json)
    print_findings_json(findings);
  else
    print_text(findings);
  return worst_of(findings) == Verdict::bad ? failed : done;
}

}  // namespace

void add_doctor(CLI::App& cli, int& status) {
  auto options = std::make_shared<DoctorArguments>();
  CLI::App* command =
      cli.add_subcommand("doctor", "Check whether this computer and its bus can run a configuration");
  command->add_option("CONFIG", options->config, "configuration (TOML)")->required();
  add_checked(*command, "--interface", options->interface, interface_name(),
              "CAN interface; default: as configured");
  command->add_flag(
      "--send", options->send,
      "also measure the round trip on a real interface, with 200 empty frames of identifier 0x7FF");
  command->add_flag("--json", options->json, "print the findings as JSON");
  command->callback([options, &status] { status = run_doctor(*options); });
}

}  // namespace hystcan::app
