// Writes the shell completion script. It is generated from the parser's commands, so that no second list of
// arguments exists.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/command_line/commands.h"
#include "app/stage/option_check.h"
#include "base/standard_streams.h"

namespace hystcan::app {
namespace {

/// Shell tables by name. The table "commands" maps each command to its subcommands. The table "options" maps
/// each command to its options. The table "values" maps each option to its possible values: a list of words,
/// `@interface` for the names of the CAN interfaces, or `@file` for file names. It is empty for an option
/// without value (a flag).
using Tables = std::map<std::string, std::string>;

std::string words_taken(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return "";
  if (option.check_lname("interface")) return "@interface";
  const std::string type = option.get_type_name();
  const auto begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return "@file";
  std::string words = type.substr(begin + 1, end - begin - 1);
  std::ranges::replace(words, ',', ' ');
  return words;
}

/// Adds the tables of a command and its subcommands. A subcommand also accepts the options of its parent:
/// `hystcan ctl --json status` equals `hystcan ctl status --json`.
void add_tables(const CLI::App& command, const std::string& path, const std::string& inherited,
                Tables& tables) {
  std::string commands, options = inherited;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional() && words_taken(*option).find('@') == std::string::npos)
      commands += words_taken(*option) + " ";
    for (const std::string& name : option->get_lnames()) {
      options += "--" + name + " ";
      tables["values"] += fmt::format("  ['{} --{}']='{}'\n", path, name, words_taken(*option));
    }
  }
  for (const CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; }))
    commands += below->get_name() + " ";
  tables["commands"] += fmt::format("  ['{}']='{}'\n", path, commands);
  tables["options"] += fmt::format("  ['{}']='{}'\n", path, options);
  for (const CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; }))
    add_tables(*below, path + " " + below->get_name(), path == "hystcan" ? "" : options, tables);
}

constexpr std::string_view bash_function = R"sh(_hystcan() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} path=hystcan word taken
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ " ${_hystcan_commands[$path]} " != *" $word "* ]] || path+=" $word"
  done
  taken=${_hystcan_values["$path $previous"]-${_hystcan_values["${path% *} $previous"]-}}
  case $taken in
    @file) COMPREPLY=() ;;  # bash completes names of files
    @interface) mapfile -t COMPREPLY < <(compgen -W "$(ls /sys/class/net 2>/dev/null)" -- "$current") ;;
    ?*) mapfile -t COMPREPLY < <(compgen -W "$taken" -- "$current") ;;
    *)
      word=${_hystcan_commands[$path]}
      [[ $current != -* ]] || word=${_hystcan_options[$path]}
      mapfile -t COMPREPLY < <(compgen -W "$word" -- "$current")
      ;;
  esac
}
complete -o default -F _hystcan hystcan
)sh";

constexpr std::string_view zsh_function = R"sh(_hystcan() {
  local current=$words[CURRENT] previous=$words[CURRENT-1] level=hystcan word taken
  for word in $words[2,CURRENT-1]; do
    [[ " $_hystcan_commands[$level] " != *" $word "* ]] || level+=" $word"
  done
  taken=${_hystcan_values[$level $previous]-$_hystcan_values[${level% *} $previous]}
  case $taken in
    @file) _files ;;
    @interface) compadd -- ${(f)"$(ls /sys/class/net 2>/dev/null)"} ;;
    ?*) compadd -- ${=taken} ;;
    *)
      if [[ $current == -* ]]; then compadd -- ${=_hystcan_options[$level]}
      elif [[ -n $_hystcan_commands[$level] ]]; then compadd -- ${=_hystcan_commands[$level]}
      else _files
      fi
      ;;
  esac
}
[[ $funcstack[1] != _hystcan ]] || _hystcan "$@"
)sh";

std::string script(const CLI::App& root, const std::string& shell) {
  Tables tables;
  add_tables(root, "hystcan", "", tables);
  const bool is_bash = shell == "bash";
  std::string text = is_bash ? "# bash completion of hystcan, made by `hystcan completion bash`\n"
                             : "#compdef hystcan\n# made by `hystcan completion zsh`\n";
  // Writes 'KEY' 'VALUE' for zsh instead of ['KEY']='VALUE', because zsh would treat the quotes in ['KEY'] as
  // a part of the key.
  for (const auto& [name, rows] : tables) {
    std::string table = rows;
    if (!is_bash) {
      for (std::size_t at; (at = table.find("['")) != std::string::npos;) table.replace(at, 2, "'");
      for (std::size_t at; (at = table.find("']='")) != std::string::npos;) table.replace(at, 4, "' '");
    }
    text += fmt::format("{} -gA _hystcan_{}\n_hystcan_{}=(\n{})\n", is_bash ? "declare" : "typeset", name,
                        name, table);
  }
  return text + std::string(is_bash ? bash_function : zsh_function);
}

}  // namespace

void add_completion(CLI::App& cli, int& status) {
  auto shell = std::make_shared<std::string>();
  CLI::App* command = cli.add_subcommand("completion", "Print the completion script of a shell");
  command->add_option("SHELL", *shell, "bash or zsh")->required()->check(one_of({"bash", "zsh"}));
  command->callback([&cli, shell, &status] {
    status = print_for_reader([&] {
      print(script(cli, *shell));
      return done;
    });
  });
}

}  // namespace hystcan::app
