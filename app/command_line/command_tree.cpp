#include "app/command_line/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live/control_protocol.h"
#include "base/error.h"
#include "config/document/closest.h"

namespace hystcan::app {
namespace {

/// Returns the program and the subcommands in the command line, the innermost last.
std::vector<const CLI::App*> named_commands(const CLI::App& cli) {
  std::vector<const CLI::App*> commands{&cli};
  for (auto inner = cli.get_subcommands(); !inner.empty(); inner = inner.front()->get_subcommands())
    commands.push_back(inner.front());
  return commands;
}

std::string name_of(const std::vector<const CLI::App*>& commands) {
  std::string name;
  for (const CLI::App* command : commands) name += (name.empty() ? "" : " ") + command->get_name();
  return name;
}

std::vector<std::string> subcommands_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

/// Returns the options of the innermost command as `--name`. If that command accepts the options of its
/// parent, as the subcommands of ctl do, the result includes the parent's options.
std::vector<std::string> options_of(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  for (auto command = commands.rbegin(); command != commands.rend(); ++command) {
    for (const CLI::Option* option : (*command)->get_options())
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    if (!(*command)->get_fallthrough()) break;
  }
  return names;
}

std::string hint(std::string_view name, const std::vector<std::string>& candidates) {
  if (const auto suggestion = config::meant_by(name, candidates))
    return fmt::format("did you mean '{}'?", *suggestion);
  return fmt::format("expected one of {}", fmt::join(candidates, ", "));
}

/// Returns the first argument that no command accepts. An unknown option has precedence, because other
/// unaccepted arguments may be its value.
std::optional<std::string> left_over(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> all;
  for (const CLI::App* command : commands)
    for (std::string& text : command->remaining())
      if (text != "--") all.push_back(std::move(text));
  const auto option =
      std::ranges::find_if(all, [](const std::string& text) { return text.starts_with('-'); });
  if (option != all.end()) return option->substr(0, option->find('='));
  return all.empty() ? std::nullopt : std::optional(all.front());
}

std::string refuse_left_over(const std::vector<const CLI::App*>& commands, const std::string& text) {
  if (text.starts_with('-'))
    return fmt::format("unknown option '{}': {}", text, hint(text, options_of(commands)));
  if (const auto inner = subcommands_of(*commands.back()); !inner.empty())
    return fmt::format("unknown command '{}': {}", text, hint(text, inner));
  return fmt::format("unexpected argument '{}'; see {} --help", text, name_of(commands));
}

/// Returns a clear message if an option is given twice or has no value, otherwise the parser's own message
/// `text`. The parser's message begins with the name of the option.
std::string refuse_values(const std::vector<const CLI::App*>& commands, const std::string& text) {
  for (const CLI::App* command : commands)
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 1 && option->get_items_expected_max() == 1)
        return fmt::format("{}: given {} times, expected once", option->get_name(), option->count());
      if (text.starts_with(option->get_name() + ":") && text.ends_with("missing"))
        return fmt::format("{}: the value is missing", option->get_name());
    }
  return text;
}

std::string reason_of(const std::vector<const CLI::App*>& commands, const CLI::ParseError& error) {
  const bool lacks = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if (lacks || dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
    if (const auto text = left_over(commands)) return refuse_left_over(commands, *text);
  if (lacks) {
    if (const auto inner = subcommands_of(*commands.back()); !inner.empty())
      return fmt::format("the command is missing, expected one of {}", fmt::join(inner, ", "));
    return fmt::format("{}; see {} --help", error.what(), name_of(commands));
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr)
    return refuse_values(commands, error.what());
  return error.what();
}

constexpr std::string_view exit_status =
    "Exit status: 0 done, 1 failed while running, 2 bad usage, config, model or data.";

using Examples = std::map<std::string, std::vector<std::string>>;

std::string example_of(const ControlCommand& row) {
  std::string line = fmt::format("hystcan ctl {}", row.ctl_word());
  for (const Argument& argument : row.arguments) {
    if (argument.ctl.starts_with('-') && !argument.example.empty()) line += fmt::format(" {}", argument.ctl);
    if (!argument.example.empty()) line += fmt::format(" {}", argument.example);
  }
  return line;
}

/// Returns the example lines of each command. The key is the command without the word `hystcan`, for example
/// "ctl status".
Examples examples() {
  Examples lines{
      {"demo", {"hystcan demo", "hystcan demo --all --config config/galfenol.toml --output galfenol-demo"}},
      {"init",
       {"hystcan init stage --record loops.csv --step step.csv --drive-max 100 --safe 0",
        "hystcan init stage --from piezo"}},
      {"controller",
       {"hystcan controller config/piezo.toml",
        "hystcan controller config/piezo.toml --interface can0 --record runs"}},
      {"twin", {"hystcan twin config/piezo.toml --interface vcan0"}},
      {"node", {"hystcan node stage.toml --read", "hystcan node stage.toml --interface vcan0"}},
      {"excite", {"hystcan excite config/piezo.toml --axis x --output loops.csv --rehearse"}},
      {"identify",
       {"hystcan identify loops.csv --output stage.model.toml --report report",
        "hystcan identify loops.csv --output x.model.toml --for stage.toml --axis x --write new.toml"}},
      {"validate", {"hystcan validate stage.model.toml other.csv --estimate-from 0.5"}},
      {"tune",
       {"hystcan tune config/piezo.toml --axis x --rehearse",
        "hystcan tune config/piezo.toml --record step.csv"}},
      {"simulate",
       {"hystcan simulate config/piezo.model.toml --input drive.csv --output position.csv",
        "hystcan simulate config/piezo.model.toml --inverse --input wanted.h5 --output drive.h5"}},
      {"check", {"hystcan check config/piezo.toml", "hystcan check --rates"}},
      {"doctor", {"hystcan doctor config/piezo.toml"}},
      {"ctl", {"hystcan ctl status", "hystcan ctl go x 12.5"}},
      {"ctl status", {"hystcan ctl status", "hystcan ctl --twin status"}},
      {"ctl settings", {"hystcan ctl --json settings"}},
      {"page", {"hystcan page config/piezo.toml"}},
      {"status", {"hystcan status", "hystcan status --watch --interface can0"}},
      {"monitor", {"hystcan monitor config/piezo.toml"}},
      {"decode", {"hystcan decode run.log --dbc config/hystcan.dbc"}},
      {"runs", {"hystcan runs hystcan-runs"}},
      {"export",
       {"hystcan export hystcan-runs/run_20261123T092000.123Z --axis x --signals reference_um,position_um "
        "--from 10 --to 12",
        "hystcan export hystcan-runs/run_20261123T092000.123Z --hdf5"}},
      {"plot",
       {"hystcan plot hystcan-runs/run_20261123T092000.123Z --output plots",
        "hystcan plot hystcan-demo/pi.csv hystcan-demo/inverse+pi.csv --kind comparison --table latex"}},
      {"completion", {"hystcan completion bash > ~/.local/share/bash-completion/completions/hystcan"}},
  };
  for (const ControlCommand& row : protocol::commands)
    lines.try_emplace(fmt::format("ctl {}", row.ctl_word()), 1, example_of(row));
  return lines;
}

void add_examples_below(CLI::App& command, const std::string& words) {
  static const Examples lines = examples();
  if (const auto found = lines.find(words); found != lines.end())
    command.footer(fmt::format("Example:\n  {}\n\n{}", fmt::join(found->second, "\n  "), exit_status));
  for (CLI::App* below : command.get_subcommands({}))
    add_examples_below(*below, words.empty() ? below->get_name() : words + " " + below->get_name());
}

/// Makes an empty value of any option an error. In a script, --option "$X" with an unset variable X gives an
/// empty value, which must not be used silently.
void refuse_empty_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options())
    option->check(CLI::Validator(
        [](const std::string& text) { return text.empty() ? "is empty, expected a value" : std::string(); },
        ""));
  for (CLI::App* below : command.get_subcommands({})) refuse_empty_values(*below);
}

}  // namespace

std::string usage_error(const CLI::App& cli, const CLI::ParseError& error) {
  const auto commands = named_commands(cli);
  return Error(name_of(commands), reason_of(commands, error)).what();
}

void add_examples(CLI::App& cli) {
  cli.footer(std::string(exit_status));
  add_examples_below(cli, "");
}

void add_commands(CLI::App& cli, int& status) {
  for (const AddCommand add :
       {add_demo, add_init,     add_controller, add_twin,   add_excite, add_identify, add_validate,
        add_tune, add_simulate, add_check,      add_doctor, add_ctl,    add_status,   add_node,
        add_page, add_monitor,  add_decode,     add_runs,   add_plot,   add_export,   add_completion})
    add(cli, status);
  refuse_empty_values(cli);
  add_examples(cli);
}

}  // namespace hystcan::app
