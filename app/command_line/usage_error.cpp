#include "app/command_line/usage_error.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "config/document/closest.h"

namespace hystcan::app {
namespace {

/// The program and the subcommands that the command line names, the innermost last.
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

/// `--name` of every option that the innermost command takes. A subcommand of ctl takes those of ctl too.
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
  if (const auto meant = config::meant_by(name, candidates)) return fmt::format("did you mean '{}'?", *meant);
  return fmt::format("expected one of {}", fmt::join(candidates, ", "));
}

/// What the command line has and nothing takes: an option first, because the rest may be its value.
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
  return fmt::format("'{}' is one argument too many; see {} --help", text, name_of(commands));
}

/// The parser names the option first and then says what is wrong with it in its own words.
std::string refuse_values(const std::vector<const CLI::App*>& commands, const std::string& text) {
  for (const CLI::App* command : commands)
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 1 && option->get_items_expected_max() == 1)
        return fmt::format("{}: is given {} times, expected once", option->get_name(), option->count());
      if (text.starts_with(option->get_name() + ":") && text.ends_with("missing"))
        return fmt::format("{}: its value is missing", option->get_name());
    }
  return text;
}

std::string reason_of(const std::vector<const CLI::App*>& commands, const CLI::ParseError& error) {
  const bool lacks = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  if (lacks || dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
    if (const auto text = left_over(commands)) return refuse_left_over(commands, *text);
  if (lacks) {
    if (const auto inner = subcommands_of(*commands.back()); !inner.empty())
      return fmt::format("a command is missing, expected one of {}", fmt::join(inner, ", "));
    return fmt::format("{}; see {} --help", error.what(), name_of(commands));
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr)
    return refuse_values(commands, error.what());
  return error.what();
}

}  // namespace

std::string usage_error(const CLI::App& cli, const CLI::ParseError& error) {
  const auto commands = named_commands(cli);
  return Error(fmt::format("{}: {}", name_of(commands), reason_of(commands, error))).what();
}

}  // namespace hystcan::app
