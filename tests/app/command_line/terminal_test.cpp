// Help, completion and man pages, generated from the tree of commands.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::terminal_test {
namespace {

using Words = std::vector<std::string>;

std::string output_of(Words words) {
  words.insert(words.begin(), HYSTCAN_PROGRAM);
  Process program(words);
  EXPECT_EQ(program.wait(), done) << program.err();
  return program.out();
}

std::string help_of(Words command) {
  command.emplace_back("--help");
  return output_of(command);
}

std::set<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    found.insert((*match)[1]);
  return found;
}

/// All commands of `hystcan` and of `hystcan ctl`.
std::vector<Words> all_commands() {
  std::vector<Words> commands;
  const auto names_in = [](const std::string& help) {
    const auto at = help.find("Subcommands:");
    return at == std::string::npos
               ? std::set<std::string>()
               : matches(help.substr(at, help.find("\n\n", at) - at), std::regex("\n  ([a-z]+) "));
  };
  for (const std::string& name : names_in(help_of({}))) {
    commands.push_back({name});
    for (const std::string& below : names_in(help_of({name}))) commands.push_back({name, below});
  }
  return commands;
}

const std::regex long_option("(--[a-z][a-z0-9-]*)");

TEST(Terminal, EveryHelpHasAnExampleWithOptionsThatExist) {
  const std::vector<Words> commands = all_commands();
  EXPECT_GT(commands.size(), 30U);
  for (const Words& command : commands) {
    std::string name = "hystcan";
    for (const std::string& word : command) name += " " + word;
    const std::string help = help_of(command);
    const auto at = help.find("\nExample:\n  hystcan " + command.front());
    ASSERT_NE(at, std::string::npos) << name << " has no example";
    std::set<std::string> known = matches(help.substr(0, at), long_option);
    if (command.size() > 1) known.merge(matches(help_of({command.front()}), long_option));
    for (const std::string& option : matches(help.substr(at), long_option))
      EXPECT_TRUE(known.contains(option)) << name << ": " << option;
  }
}

/// Returns the completions of bash after these words.
std::string completed(const std::string& words) {
  const std::string script = "source <(" HYSTCAN_PROGRAM " completion bash); COMP_WORDS=(" + words +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _hystcan; echo \"${COMPREPLY[*]}\"";
  Process shell({"bash", "-c", script});
  EXPECT_EQ(shell.wait(), 0) << shell.err();
  EXPECT_EQ(shell.err(), "");
  return shell.out();
}

TEST(Terminal, BashCompletesCommandsOptionsAndWords) {
  EXPECT_EQ(completed("hystcan simu"), "simulate\n");
  EXPECT_EQ(completed("hystcan simulate --inv"), "--inverse\n");
  EXPECT_EQ(completed("hystcan ctl --json st"), "status stop\n");
  EXPECT_EQ(completed("hystcan ctl go --js"), "--json\n");
  EXPECT_EQ(completed("hystcan identify --symmetry ''"), "auto none even butterfly\n");
  EXPECT_EQ(completed("hystcan completion z"), "zsh\n");
  EXPECT_EQ(completed("hystcan ctl inject wrong_c"), "wrong_crc\n");
  EXPECT_EQ(completed("hystcan plot run --format p"), "png pdf\n");
  EXPECT_NE(completed("hystcan monitor --interface ''").find("lo"), std::string::npos);
  EXPECT_EQ(completed("hystcan simulate --input ''"), "\n") << "names of files are bash's";
}

TEST(Terminal, ZshCompletesTheSame) {
  const std::string script =
      "compadd() { shift; print -- $@ }; _files() { print files }; source <(" HYSTCAN_PROGRAM
      " completion zsh); t() { words=(\"$@\"); CURRENT=$#; _hystcan }; t hystcan simulate --in; "
      "t hystcan identify --symmetry ''; t hystcan simulate ''";
  Process shell({"zsh", "-f", "-c", script});
  EXPECT_EQ(shell.wait(), 0) << shell.err();
  EXPECT_NE(shell.out().find("--inverse"), std::string::npos) << shell.out();
  EXPECT_NE(shell.out().find("\nauto none even butterfly\nfiles\n"), std::string::npos) << shell.out();
}

TEST(Terminal, EveryCommandHasAManPageWithItsOptions) {
  for (const Words& command : all_commands()) {
    std::string name = "hystcan";
    for (const std::string& word : command) name += "-" + word;
    std::ifstream file(std::filesystem::path(HYSTCAN_PROGRAM).parent_path() / "terminal" / (name + ".1"));
    std::ostringstream page;
    page << file.rdbuf();
    std::string text = page.str();
    for (std::size_t at; (at = text.find("\\-")) != std::string::npos;) text.replace(at, 2, "-");
    EXPECT_TRUE(text.find(".SH NAME") != std::string::npos) << name << ".1";
    for (const std::string& option : matches(help_of(command), std::regex("\n  (--[a-z-]+)")))
      EXPECT_NE(text.find(option), std::string::npos) << name << ".1: " << option;
  }
}

}  // namespace
}  // namespace hystcan::terminal_test
