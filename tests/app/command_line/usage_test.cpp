// Invalid command lines: one line names the command, the option and the expected value.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::usage_test {
namespace {

using Words = std::vector<std::string>;

struct Ended {
  int status;
  std::string out;
  std::string err;
};

Ended run(const Words& words) {
  Words all{HYSTCAN_PROGRAM};
  all.insert(all.end(), words.begin(), words.end());
  Process program(all);
  const int status = program.wait();
  return {status, program.out(), program.err()};
}

std::string refusal_of(const Words& words) {
  const Ended ended = run(words);
  EXPECT_EQ(ended.status, bad_input) << ended.err;
  EXPECT_EQ(std::ranges::count(ended.err, '\n'), 1) << ended.err;
  EXPECT_EQ(ended.out, "");
  return ended.err;
}

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string joined(const Words& words) {
  std::string text = "hystcan";
  for (const std::string& word : words) text += " " + word;
  return text;
}

/// The subcommands that the help of this command lists.
std::vector<Words> below(const Words& command) {
  std::istringstream help(run(with(command, {"--help"})).out);
  std::vector<Words> found;
  bool listed = false;
  for (std::string line; std::getline(help, line) && !(listed && line.empty());
       listed = listed || line == "Subcommands:")
    if (std::smatch match; listed && std::regex_search(line, match, std::regex("^  ([a-z]+) ")))
      found.push_back(with(command, {match[1]}));
  return found;
}

std::vector<Words> all_commands() {
  std::vector<Words> commands = below({});
  for (const Words& inner : below({"ctl"})) commands.push_back(inner);
  return commands;
}

/// The options of a command whose type in the help is one of `types`.
Words options(const Words& command, const std::string& types) {
  const std::string help = run(with(command, {"--help"})).out;
  const std::regex option("\n  (--[a-z-]+) (" + types + ")");
  Words found;
  for (std::sregex_iterator at(help.begin(), help.end(), option), end; at != end; ++at)
    found.push_back((*at)[1]);
  return found;
}

TEST(Usage, SuggestsTheNearestCommand) {
  EXPECT_EQ(refusal_of({"identfy"}), "hystcan: unknown command 'identfy': did you mean 'identify'?\n");
  EXPECT_EQ(refusal_of({"ctl", "statsu"}), "hystcan ctl: unknown command 'statsu': did you mean 'status'?\n");
}

TEST(Usage, ListsAllCommandsForAnUnknownCommand) {
  EXPECT_TRUE(refusal_of({"frobnicate"})
                  .starts_with(
                      "hystcan: unknown command 'frobnicate': expected one of demo, init, controller, twin"));
}

TEST(Usage, SuggestsTheNearestOption) {
  EXPECT_EQ(refusal_of({"identify", "x.csv", "--outptu", "y.toml"}),
            "hystcan identify: unknown option '--outptu': did you mean '--output'?\n");
  EXPECT_EQ(refusal_of({"ctl", "wait", "x", "--interfce=vcan0"}),
            "hystcan ctl wait: unknown option '--interfce': did you mean '--interface'?\n");
}

TEST(Usage, EveryErrorOfTheParserIsOneLineWithItsPlace) {
  const std::vector<std::pair<Words, std::string>> rows{
      {{}, "hystcan: the command is missing, expected one of demo, "},
      {{"ctl"}, "hystcan ctl: the command is missing, expected one of status, "},
      {{"identify"}, "hystcan identify: DATA is required; see hystcan identify --help\n"},
      {{"identify", "a", "--output"}, "hystcan identify: --output: the value is missing\n"},
      {{"identify", "a", "--output", "b", "--output", "c"},
       "hystcan identify: --output: given 2 times, expected once\n"},
      {{"identify", "a", "--output", "b", "--order", "0"},
       "hystcan identify: --order: 0, expected auto or 1 to 20\n"},
      {{"excite", "a", "--output", "b", "--signal", "sine"},
       "hystcan excite: --signal: sine, expected one of hysteresis, step, chirp\n"},
      {{"validate", "a", "b", "--memory", "c", "--no-offset"},
       "hystcan validate: --memory excludes --no-offset\n"},
      {{"validate", "a", "b", "--memory", ""}, "hystcan validate: --memory: is empty, expected a value\n"},
      {{"decode", "a", "--dbc", "b\nc"}, "hystcan: b c: cannot be read: No such file or directory\n"},
      {{"export", std::string(300, 'a')},
       "hystcan: " + std::string(300, 'a') +
           ": is not a file, expected a run's folder or a CSV of control cycles "
           "(from hystcan controller --csv)\n"},
      {{"check"}, "hystcan check: CONFIG is required; see hystcan check --help\n"},
      {{"check", "a", "b"}, "hystcan check: unexpected argument 'b'; see hystcan check --help\n"},
      {{"check", "a\nb", "c\nd"}, "hystcan check: unexpected argument 'c d'; see hystcan check --help\n"}};
  for (const auto& [words, message] : rows) EXPECT_TRUE(refusal_of(words).starts_with(message)) << message;
}

TEST(Usage, EveryNumericOptionRefusesInfinitiesAndNan) {
  std::size_t tried = 0;
  for (const Words& command : all_commands())
    for (const std::string& option : options(command, "FLOAT|UINT|INT"))
      for (const std::string value : {"nan", "inf", "-inf", "1e999", "1x", ""}) {
        const std::string expected = joined(command) + ": " + option + ": " + value + ", expected ";
        const std::string message = refusal_of(with(command, {option, value}));
        EXPECT_TRUE(message.starts_with(expected)) << message << expected;
        ++tried;
      }
  EXPECT_GE(tried, 6 * 25U);
}

TEST(Usage, ANumericArgumentRefusesInfinitiesAndNan) {
  for (const std::string value : {"nan", "inf", "1x"})
    EXPECT_EQ(refusal_of({"ctl", "go", "x", value}),
              "hystcan ctl go: POSITION: " + value + ", expected a finite number\n");
}

TEST(Usage, EveryWholeNumberRefusesValuesOutOfRange) {
  std::size_t tried = 0;
  for (const Words& command : all_commands())
    for (const std::string& option : options(command, "UINT|INT"))
      for (const std::string value : {"-1", "2.5", "1e18", "99999999999999999999"}) {
        const std::string message = refusal_of(with(command, {option, value}));
        EXPECT_NE(message.find(option + ": " + value + ", expected a whole number from "), std::string::npos)
            << message;
        ++tried;
      }
  EXPECT_GE(tried, 4 * 4U);
}

TEST(Usage, EveryInterfaceOptionRefusesAnInvalidName) {
  std::size_t tried = 0;
  for (const Words& command : all_commands()) {
    const Words taken = options(command, "TEXT");
    if (std::ranges::find(taken, "--interface") == taken.end()) continue;
    for (const std::string name : {"abcdefghijklmnop", "a b", "a/b", "."}) {
      const std::string expected =
          joined(command) + ": --interface: " + name + ", expected the name of an interface: ";
      EXPECT_TRUE(refusal_of(with(command, {"--interface", name})).starts_with(expected)) << expected;
    }
    ++tried;
  }
  EXPECT_GE(tried, 8U);
}

class Limits : public Cli {};

TEST_F(Limits, RefuseAnIntervalThatEndsBeforeItBegins) {
  write("d.csv", "time_s,input,output\n0,1,1\n1,2,2\n");
  for (const Words& command : {Words{"validate", path("piezo.model.toml"), path("d.csv")},
                               {"identify", path("d.csv"), "--output", path("o")}})
    EXPECT_EQ(refusal_of(with(command, {"--from", "3", "--to", "1"})),
              "hystcan: --from is 3, expected at most --to, 1\n");
}

TEST_F(Limits, RefuseAChirpThatFalls) {
  EXPECT_EQ(refusal_of({"excite", path("piezo.toml"), "--rehearse", "--output", path("o.csv"), "--signal",
                        "chirp", "--frequency-from", "50", "--frequency-to", "5"}),
            "hystcan: --frequency-from is 50 Hz, expected at most --frequency-to, 5 Hz\n");
}

TEST_F(Limits, RefuseADelayLongerThanTheDataset) {
  write("d.csv", "time_s,input,output\n0,1,1\n1,2,2\n");
  const std::string message =
      refusal_of({"validate", path("piezo.model.toml"), path("d.csv"), "--delay", "1.5", "--from", "0"});
  EXPECT_NE(message.find("--delay is 1.5 s, expected at most the length of " + path("d.csv") + ", 1 s"),
            std::string::npos)
      << message;
}

TEST_F(Limits, RefuseALogWithoutFrames) {
  write("empty.log", "");
  write("comment.log", "# nothing was received\n");
  for (const char* log : {"empty.log", "comment.log"}) {
    const std::string message = "hystcan: " + path(log) + ": no frames, expected a log of candump -L\n";
    EXPECT_EQ(refusal_of({"decode", path(log), "--dbc", path("hystcan.dbc")}), message);
  }
}

TEST_F(Limits, RefuseDecreasingTimesInASimulation) {
  write("back.csv", "time_s,input\n0,1\n2,2\n1,3\n");
  EXPECT_EQ(refusal_of({"simulate", path("piezo.model.toml"), "--input", path("back.csv"), "--output",
                        path("o.csv")}),
            "hystcan: " + path("back.csv") + ":4: time_s is 1 after 2, expected an increasing time\n");
}

TEST_F(Limits, RefuseNumbersThatUnderflow) {
  EXPECT_EQ(refusal_of({"identify", "a", "--output", "b", "--creep", "1e-400"}),
            "hystcan identify: --creep: 1e-400, expected auto, none or 0 to 0.16\n");
  EXPECT_EQ(refusal_of({"init", path("st"), "--yes", "--drive-min", "0", "--drive-max", "100", "--resonance",
                        "300", "--stroke", "1e-308"}),
            "hystcan: --stroke: 1e-308, expected 1e-6 to 1e9\n");
  EXPECT_EQ(refusal_of({"init", path("st"), "--yes", "--drive-min", "0", "--drive-max", "1e-308", "--stroke",
                        "30", "--resonance", "300"}),
            "hystcan: --drive-max: 1e-308, expected at least 1e-6 above the lowest drive, 0\n");
}

TEST_F(Limits, RefuseAnOutputThatIsAnInput) {
  write("d.csv", "time_s,input,output\n0,1,1\n1,2,2\n");
  const Words stage{"piezo.toml", "piezo.model.toml", "piezo.plant.toml", "hystcan.dbc"};
  const Words tune{"tune", path("piezo.toml"), "--output", path("tuning.toml")};
  const Words of_record{"tune", path("piezo.toml"), "--record", path("d.csv")};
  const std::vector<std::pair<Words, Words>> rows{
      {{"validate", path("piezo.model.toml"), path("d.csv"), "--output"}, {"piezo.model.toml", "d.csv"}},
      {{"simulate", path("piezo.model.toml"), "--input", path("d.csv"), "--overwrite", "--output"},
       {"piezo.model.toml", "d.csv"}},
      {{"excite", path("piezo.toml"), "--rehearse", "--overwrite", "--output"}, stage},
      {{"tune", path("piezo.toml"), "--rehearse", "--output"}, stage},
      {with(tune, {"--rehearse", "--write"}), stage},
      {with(tune, {"--record", path("d.csv"), "--write"}), {"d.csv"}},
      {with(of_record, {"--response"}), {"d.csv"}},
      {with(of_record, {"--output"}), {"d.csv"}}};
  for (const auto& [words, inputs] : rows)
    for (const std::string& input : inputs) {
      const std::string before = read(input.c_str());
      const std::string message = refusal_of(with(words, {path(input.c_str())}));
      EXPECT_NE(message.find(input + ": is also an input, expected another file"), std::string::npos)
          << message;
      EXPECT_EQ(read(input.c_str()), before) << input;
    }
}

TEST_F(Limits, NameAFolderThatCannotBeCreated) {
  EXPECT_EQ(refusal_of({"demo", "--config", path("piezo.toml"), "--output", path("piezo.toml")}),
            "hystcan: " + path("piezo.toml") + ": is not a folder, expected one for the output\n");
  const Ended ended = run({"demo", "--config", path("piezo.toml"), "--output", "/proc/none"});
  EXPECT_EQ(ended.status, failed);
  EXPECT_EQ(ended.err, "hystcan: /proc/none: cannot be created: No such file or directory\n");
}

}  // namespace
}  // namespace hystcan::usage_test
