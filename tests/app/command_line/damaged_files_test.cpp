// Damage of a byte, a line or a number in any file that a command reads: the command works, or it exits with
// status 2, one line with the reason and no file left behind. Under a sanitizer, this also checks the memory
// accesses.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/app/command_line/cli.h"

namespace hystcan::damaged_files_test {
namespace {

using Path = std::filesystem::path;
using Words = std::vector<std::string>;

struct Command {
  Words words;
  Words files;                       ///< one of these is damaged
  std::set<int> unrefused = {done};  ///< exit statuses if nothing is refused
};

/// The commands read the files of stage() and write beside them. The interface hystcan-none does not exist:
/// status 1, as for a rehearsal that ends with a fault.
const std::vector<Command> commands{
    {{"check", "piezo.toml"}, {"piezo.toml", "piezo.model.toml", "piezo.plant.toml", "hystcan.dbc"}},
    {{"check", "galfenol.toml"}, {"galfenol.toml", "galfenol.model.toml", "galfenol.dbc"}},
    {{"check", "lab_amplifier.toml"}, {"lab_amplifier.toml", "lab_amplifier.dbc"}},
    {{"check", "raster.toml"}, {"raster.toml"}},
    {{"check", "soft_stage.plant.toml"}, {"soft_stage.plant.toml"}},
    {{"simulate", "piezo.model.toml", "--input", "drive.csv", "--output", "out.csv", "--memory",
      "memory.toml", "--save-memory", "after.toml"},
     {"piezo.model.toml", "drive.csv", "memory.toml"}},
    {{"simulate", "galfenol.model.toml", "--inverse", "--input", "loops.csv", "--output", "out.csv"},
     {"galfenol.model.toml", "loops.csv"}},
    {{"identify", "loops.csv", "--output", "out.toml", "--order", "2", "--curves", "polynomial"},
     {"loops.csv"}},
    {{"validate", "piezo.model.toml", "loops.csv", "--output", "out.csv"}, {"piezo.model.toml", "loops.csv"}},
    {{"validate", "piezo.model.toml", "cycles.csv"}, {"cycles.csv"}},
    {{"tune", "piezo.toml", "--record", "step.csv", "--output", "out.toml", "--write", "new.toml",
      "--cautious"},
     {"step.csv"},
     {done, failed}},
    {{"decode", "bus.log", "--dbc", "hystcan.dbc", "--csv"}, {"bus.log", "hystcan.dbc"}},
    {{"decode", "bus.log", "--dbc", "lab_amplifier.dbc", "--json"}, {"bus.log", "lab_amplifier.dbc"}},
    {{"export", "run_1", "--axis", "x"}, {"run_1/run.json", "run_1/cycles_0001.csv"}},
    {{"plot", "run_1", "--output", "plots", "--format", "svg", "--kind", "error"},
     {"run_1/run.json", "run_1/cycles_0001.csv"}},
    {{"runs", "."}, {"run_1/run.json", "run_1/cycles_0001.csv"}},
    {{"excite", "piezo.toml", "--output", "out.csv", "--signal", "step", "--cycles", "1", "--rehearse"},
     {"piezo.toml", "piezo.plant.toml", "hystcan.dbc"},
     {done, failed}},
    {{"monitor", "piezo.toml", "--interface", "hystcan-none"}, {"piezo.toml", "hystcan.dbc"}, {failed}},
    {{"controller", "piezo.toml", "--interface", "hystcan-none"},
     {"piezo.toml", "piezo.model.toml"},
     {failed}},
    {{"twin", "piezo.toml", "--interface", "hystcan-none"}, {"piezo.toml", "piezo.plant.toml"}, {failed}},
};

void write(const Path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

int run_in(const Path& folder, const Words& words, std::string* said = nullptr) {
  Words line{"/usr/bin/env", "--chdir=" + folder.string(), "timeout", "300", HYSTCAN_PROGRAM};
  line.insert(line.end(), words.begin(), words.end());
  Process process(line);
  const int status = process.wait();
  if (said != nullptr) *said = process.err();
  return status;
}

/// The shipped configurations, and a small file of each other kind.
const Path& stage() {
  static const support::ShippedCopy made;
  static const bool is_whole = [] {
    const Path folder = made.folder();
    std::string drive = "time_s,input\n";
    for (int i = 0; i < 240; ++i)
      drive +=
          std::to_string(0.001 * i) + "," + std::to_string(50 + (i % 80 - 40) * (i < 160 ? 1 : 0.5)) + "\n";
    write(folder / "drive.csv", drive);
    const Words simulated{"simulate", "piezo.model.toml", "--input",       "drive.csv",
                          "--output", "loops.csv",        "--save-memory", "memory.toml"};
    const Words stepped{"excite",   "piezo.toml", "--output", "step.csv", "--signal",  "step",
                        "--cycles", "1",          "--period", "0.2",      "--rehearse"};
    write(folder / "bus.log",
          "(1700000000.000000) vcan0 181#0011223344556677\n(1700000000.000100) vcan0 080#\n"
          "(1700000000.001000) vcan0 201#00000000\n(1700000000.001100) vcan0 701#05 R\n");
    std::filesystem::create_directory(folder / "run_1");
    write(folder / "run_1" / "run.json",
          R"({"hystcan_run": 1, "version": "0.1.0", "host": "bench", "command": "controller",
 "config": "piezo.toml", "interface": "can0", "rate_Hz": 1000.0, "started": "2026-11-24T08:00:00.000Z",
 "ended": "", "failure": "", "first_s": 0.001, "last_s": 0.002, "rows": 3, "rows_lost": 0,
 "axes": [{"name": "x", "drive_unit": "V", "stroke_um": 30.3, "tracked_rows": 1, "error_rms_um": 0.5,
           "error_max_um": 0.5, "faults": [{"cause": "following error", "time_s": 0.002}]}],
 "settings": [["axis[0].control.kp", "0.1"]]})");
    write(folder / "run_1" / "cycles_0001.csv",
          "cycle,time_s,axis,state,fault,reference_um,position_um,error_um,drive\n"
          "1,0.001,x,tracking,none,1.5,1.25,0.25,10\n2,0.002,x,tracking,none,1.75,1.5,0.25,11\n"
          "3,0.003,x,faulted,following error,2,1,1,0\n");
    std::string cycles = "cycle,time_s,axis,state,position_um,drive,sample_missing\n";
    for (int i = 0; i < 40; ++i)
      cycles += std::to_string(i) + "," + std::to_string(1e-3 * i) + ",x,tracking," +
                std::to_string(i * (40 - i) / 20) + "," + std::to_string(i * (40 - i) / 5) + ",0\n";
    write(folder / "cycles.csv", cycles);
    return run_in(folder, simulated) == done && run_in(folder, stepped) == done;
  }();
  EXPECT_TRUE(is_whole);
  return made.folder();
}

struct CopiedStage : support::ScratchFolder {
  CopiedStage() { std::filesystem::copy(stage(), path(), std::filesystem::copy_options::recursive); }
};

std::size_t place_in(const std::string& text) { return *rc::gen::inRange<std::size_t>(0, text.size()); }

std::string with_another_byte(std::string text) {
  const std::size_t at = place_in(text);
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      text[at] = *rc::gen::arbitrary<char>();
      break;
    case 1:
      text.insert(
          at, 1,
          *rc::gen::element('\0', '\n', '\r', '"', '\'', ',', '[', '{', '#', '=', '-', '\x1b', '\xff'));
      break;
    case 2:
      text.erase(at, 1);
      break;
    default:
      text.resize(at);
  }
  return text;
}

std::string with_another_line(const std::string& text) {
  std::size_t begin = text.rfind('\n', place_in(text));
  begin = begin == std::string::npos ? 0 : begin + 1;
  const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
  const std::string line = text.substr(begin, end - begin);
  if (*rc::gen::arbitrary<bool>()) return text.substr(0, begin) + text.substr(end);
  return text.substr(0, end) + line + text.substr(end);
}

/// Returns an empty text if the text contains no number.
std::string with_another_number(const std::string& text) {
  const auto is_part = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_';
  };
  const std::size_t from = place_in(text);
  std::size_t begin = text.find_first_of("0123456789", from);
  if (begin == std::string::npos) return text;
  std::size_t end = begin;
  while (end < text.size() && is_part(text[end])) ++end;
  while (begin > from && (is_part(text[begin - 1]) || text[begin - 1] == '-')) --begin;
  const std::string number = *rc::gen::element<std::string>(
      "0", "-0.0", "-1", "1", "2", "0.5", "1e-320", "1e-9", "1e9", "1e15", "1e160", "-1e160", "1e308",
      "-1e308", "1e999", "nan", "inf", "-inf", "9223372036854775807", "-9223372036854775808",
      "18446744073709551616", "0x7f", "1e", "", "true", "\"1\"", "[1]", "{}");
  return text.substr(0, begin) + number + text.substr(end);
}

std::string damaged(const std::string& text) {
  switch (*rc::gen::inRange(0, 3)) {
    case 0:
      return with_another_byte(text);
    case 1:
      return with_another_line(text);
    default:
      return with_another_number(text);
  }
}

std::set<std::string> files_in(const Path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    names.insert(entry.path().string());
  return names;
}

std::ptrdiff_t count_of_lines(std::string_view text) { return std::ranges::count(text, '\n'); }

bool is_printable(std::string_view text) {
  return std::ranges::none_of(
      text, [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F; });
}

void holds_for_one(const Command& command) {
  const CopiedStage folder;
  const std::string name = *rc::gen::elementOf(command.files);
  const std::string text = damaged(support::read_file(folder / name));
  write(folder / name, text);
  const auto before = files_in(folder.path());
  std::string said;
  const int status = run_in(folder.path(), command.words, &said);
  RC_LOG() << command.words.front() << " with a damaged " << name << ": status " << status << ", " << said
           << "\n"
           << text;
  RC_ASSERT(is_printable(said));
  RC_ASSERT(status == bad_input || command.unrefused.contains(status));
  if (status == done) return;
  const std::size_t reason = said.rfind("hystcan: ");
  RC_ASSERT(reason != std::string::npos && count_of_lines(said.substr(reason)) == 1);
  RC_ASSERT(files_in(folder.path()) == before);
}

TEST(DamagedFile, IsUsedOrRefusedInOneLineAndLeavesNoFiles) {
  for (const Command& command : commands) {
    std::string said;
    const CopiedStage folder;
    ASSERT_EQ(run_in(folder.path(), command.words, &said), *command.unrefused.begin()) << said;
  }
  EXPECT_TRUE(rc::check([] { holds_for_one(*rc::gen::elementOf(commands)); }));
}

}  // namespace
}  // namespace hystcan::damaged_files_test
