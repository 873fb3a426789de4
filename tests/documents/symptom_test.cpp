// The pages of docs/troubleshooting/: the commands under "With the twin" run as they stand, the log has the
// lines that the page quotes, and the picture, which scripts/symptoms draws from the same runs, shows what
// the page says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "can/bus_health_log.h"
#include "controller/control/fault.h"
#include "tests/support/process.h"

namespace hystcan::documents::symptom_test {
namespace {

namespace fs = std::filesystem;

const fs::path documents = HYSTCAN_SOURCE_DIR "/docs";

std::string page_of(const std::string& name) {
  return support::read_file(documents / "troubleshooting" / (name + ".md"));
}

/// The first block under a heading, or nothing.
std::string block_under(const std::string& page, const std::string& heading) {
  const auto section = page.find("\n## " + heading + "\n");
  if (section == std::string::npos) return {};
  const std::string text = page.substr(section + 1, page.find("\n## ", section + 1) - section);
  const auto fence = text.find("\n```");
  if (fence == std::string::npos) return {};
  const auto begin = text.find('\n', fence + 1) + 1;
  return text.substr(begin, text.find("\n```", begin) + 1 - begin);
}

constexpr std::array<std::string_view, 6> drawn{"time_s",   "reference_um", "position_um",
                                                "error_um", "drive",        "amplifier_output"};

/// The rows of axis x, a column for each signal that is drawn.
struct Cycles {
  std::vector<std::string> state;
  std::map<std::string, std::vector<double>> columns;

  const std::vector<double>& operator[](const std::string& column) const { return columns.at(column); }
  std::size_t size() const { return state.size(); }
  /// The index of the first row at or after this time.
  std::size_t at(double time_s) const {
    const std::vector<double>& time = columns.at("time_s");
    return static_cast<std::size_t>(std::ranges::lower_bound(time, time_s) - time.begin());
  }
  /// A part of a column.
  std::vector<double> part(const std::string& column, double from_s, double to_s) const {
    const std::vector<double>& all = columns.at(column);
    return {all.begin() + static_cast<std::ptrdiff_t>(at(from_s)),
            all.begin() + static_cast<std::ptrdiff_t>(at(to_s))};
  }
  /// A column while the axis tracks.
  std::vector<double> tracked(const std::string& column) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < size(); ++i)
      if (state[i] == "tracking" && !std::isnan(columns.at(column)[i]))
        values.push_back(columns.at(column)[i]);
    return values;
  }
  double faulted_s() const {
    const auto found = std::ranges::find(state, "faulted");
    return found == state.end() ? std::numeric_limits<double>::quiet_NaN()
                                : columns.at("time_s")[static_cast<std::size_t>(found - state.begin())];
  }
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == ',')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

/// NaN where the cell is empty.
double number(const std::string& cell) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  return end == cell.c_str() ? std::numeric_limits<double>::quiet_NaN() : value;
}

Cycles read_cycles(const fs::path& file) {
  Cycles cycles;
  std::ifstream lines(file);
  std::string line;
  std::vector<std::string> names;
  while (std::getline(lines, line)) {
    if (names.empty() && line.starts_with("cycle,")) names = cells_of(line);
    if (names.empty() || line.find(",x,") == std::string::npos) continue;
    const std::vector<std::string> cells = cells_of(line);
    cycles.state.push_back(cells[3]);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (std::ranges::find(drawn, names[i]) != drawn.end())
        cycles.columns[names[i]].push_back(number(cells[i]));
  }
  return cycles;
}

struct PageRun {
  std::string printed;  ///< what the commands print on both streams
  Cycles good, bad;
};

/// Runs the commands of a page in a folder with the shipped configurations, once.
const PageRun& run_of(const std::string& name) {
  static std::map<std::string, PageRun> runs;
  if (const auto known = runs.find(name); known != runs.end()) return known->second;
  const support::ScratchFolder folder;
  for (const auto& entry : fs::directory_iterator(HYSTCAN_SOURCE_DIR "/config"))
    if (entry.path().extension() == ".toml" || entry.path().extension() == ".dbc")
      fs::copy_file(entry.path(), folder / entry.path().filename().string());
  const std::string program_folder = fs::path(HYSTCAN_PROGRAM).parent_path().string();
  support::Process bash({"bash", "-c",
                         fmt::format("cd '{}' && PATH='{}':$PATH && exec 2>&1\n{}", folder.path().string(),
                                     program_folder, block_under(page_of(name), "With the twin"))});
  bash.wait();  // a run with a fault ends with status 1
  PageRun run{.printed = bash.out() + bash.err(), .good = {}, .bad = {}};
  if (fs::exists(folder / "good.csv")) run.good = read_cycles(folder / "good.csv");
  if (fs::exists(folder / "bad.csv")) run.bad = read_cycles(folder / "bad.csv");
  return runs.emplace(name, std::move(run)).first->second;
}

double rms_of(const std::vector<double>& values) {
  return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                   static_cast<double>(values.size()));
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double greatest_of(const std::vector<double>& values) {
  double greatest = 0.0;
  for (const double value : values) greatest = std::max(greatest, std::abs(value));
  return greatest;
}

/// Periods per second of a swing, from its maxima.
double frequency_of(const std::vector<double>& values, double rate_Hz) {
  std::size_t first = 0, last = 0, count = 0;
  for (std::size_t i = 1; i + 1 < values.size(); ++i)
    if (values[i] > values[i - 1] && values[i] >= values[i + 1]) {
      if (count++ == 0) first = i;
      last = i;
    }
  return static_cast<double>(count - 1) * rate_Hz / static_cast<double>(last - first);
}

/// What is left of a swing when its slow part is taken away: half the second difference.
std::vector<double> swing_of(const std::vector<double>& values) {
  std::vector<double> swing;
  swing.reserve(values.size());
  for (std::size_t i = 1; i + 1 < values.size(); ++i)
    swing.push_back(values[i] - (values[i - 1] + values[i + 1]) / 2.0);
  return swing;
}

std::string without_breaks(const std::string& text) {
  return std::regex_replace(text, std::regex("\\s+"), " ");
}

std::vector<std::string> all_pages() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(documents / "troubleshooting"))
    names.push_back(entry.path().stem().string());
  std::ranges::sort(names);
  return names;
}

class Symptom : public testing::TestWithParam<std::string> {};

// A line of the log that is longer than the page goes on behind an indent.
TEST_P(Symptom, QuotesWhatItsRunPrintsInItsOrder) {
  const std::string page = page_of(GetParam());
  const std::string quoted =
      std::regex_replace(block_under(page, "What the log says"), std::regex("\n +"), " ");
  if (block_under(page, "With the twin").empty()) return;  // needs a bus, or a browser
  const std::string printed = without_breaks(run_of(GetParam()).printed);
  std::istringstream lines(quoted);
  std::string line;
  std::size_t from = 0;
  while (std::getline(lines, line)) {
    const auto at = printed.find(without_breaks(line), from);
    ASSERT_NE(at, std::string::npos) << line << "\nis not in\n" << run_of(GetParam()).printed;
    from = at;
  }
}

TEST_P(Symptom, IsInTheIndexAndHasItsPictureOnAPageOfAtMost120Lines) {
  const std::string page = page_of(GetParam());
  EXPECT_NE(
      support::read_file(documents / "troubleshooting.md").find("](troubleshooting/" + GetParam() + ".md)"),
      std::string::npos);
  EXPECT_LE(std::ranges::count(page, '\n'), 120);
  const bool has_picture = fs::exists(documents / "figures/symptoms" / (GetParam() + ".svg"));
  EXPECT_EQ(page.find("](../figures/symptoms/" + GetParam() + ".svg)") != std::string::npos, has_picture);
}

INSTANTIATE_TEST_SUITE_P(, Symptom, testing::ValuesIn(all_pages()), [](const auto& test) {
  return std::regex_replace(test.param, std::regex("-"), "_");
});

// Corners at 2.272 s and 2.522 s.
TEST(SymptomPicture, RingsAtTheModeAfterACornerAndDecays) {
  const PageRun& run = run_of("rings");
  const std::vector<double> after_corner = swing_of(run.bad.part("error_um", 2.275, 2.325));
  EXPECT_NEAR(frequency_of(after_corner, 1000.0), 220.0, 5.0);
  EXPECT_GT(rms_of(after_corner), 5.0 * rms_of(swing_of(run.bad.part("error_um", 2.47, 2.52))));
  EXPECT_GT(rms_of(after_corner), 5.0 * rms_of(swing_of(run.good.part("error_um", 2.275, 2.325))));
}

TEST(SymptomPicture, OscillatesMoreAndMoreUntilTheAxisFaults) {
  const PageRun& run = run_of("oscillates");
  EXPECT_NEAR(run.bad.faulted_s(), 1.614, 1e-9);
  double before_um = 0.05;  // what the loop leaves before the mode has moved
  EXPECT_LT(greatest_of(run.bad.part("error_um", 1.45, 1.5)), 2.0 * before_um);
  for (const double from_s : {1.50, 1.54, 1.58}) {
    const double now_um = greatest_of(run.bad.part("error_um", from_s, from_s + 0.03));
    EXPECT_GT(now_um, 1.2 * before_um) << from_s;
    before_um = now_um;
  }
  EXPECT_LT(greatest_of(run.good.part("error_um", 1.45, 1.65)), 0.1);
  EXPECT_GT(greatest_of(run.bad.part("position_um", 1.62, 1.63)),
            2.0 * greatest_of(run.bad.part("position_um", 1.65, 1.66)));
}

/// The time by which `position` is behind `reference`: the shift with the least RMS difference.
double lag_s(const std::vector<double>& time_s, const std::vector<double>& reference,
             const std::vector<double>& position) {
  const double cycle_s = time_s[1] - time_s[0];
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (std::size_t shift = 0; shift < 10; ++shift) {
    std::vector<double> difference;
    for (std::size_t i = shift; i < position.size(); ++i)
      difference.push_back(position[i] - reference[i - shift]);
    if (const double rms = rms_of(difference); rms < least) {
      least = rms;
      best = static_cast<double>(shift) * cycle_s;
    }
  }
  return best;
}

double lag_s(const Cycles& cycles, double from_s, double to_s) {
  return lag_s(cycles.part("time_s", from_s, to_s), cycles.part("reference_um", from_s, to_s),
               cycles.part("position_um", from_s, to_s));
}

// Up from 1.101 s to 1.151 s, then down.
TEST(SymptomPicture, LagsByTheSameTimeOnBothWaysSoThatTheErrorHasTheSignOfTheSpeed) {
  const PageRun& run = run_of("lags");
  EXPECT_EQ(lag_s(run.good, 1.101, 1.201), 0.0);
  for (const auto& [from_s, to_s, sign] : {std::tuple{1.106, 1.149, 1.0}, std::tuple{1.156, 1.199, -1.0}}) {
    EXPECT_NEAR(lag_s(run.bad, from_s, to_s), 0.0025, 0.0011) << "1 / ki, at the speed of 480 um/s";
    for (const double error_um : run.bad.part("error_um", from_s, to_s)) {
      EXPECT_GT(sign * error_um, 0.9);
      EXPECT_LT(sign * error_um, 1.9);
    }
  }
}

/// The position of the first cycle from `from_s` on in which the reference crosses this level.
double position_at(const Cycles& cycles, double level_um, double from_s) {
  for (std::size_t i = cycles.at(from_s) + 1; i < cycles.size(); ++i) {
    const double before = cycles["reference_um"][i - 1] - level_um,
                 now = cycles["reference_um"][i] - level_um;
    if (before * now <= 0.0)
      return std::lerp(cycles["position_um"][i - 1], cycles["position_um"][i], before / (before - now));
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TEST(SymptomPicture, BacklashIsAnotherPositionAtTheSameReferenceOnTheWayBack) {
  const PageRun& run = run_of("backlash");
  const auto apart_um = [](const Cycles& cycles) {
    return position_at(cycles, 15.0, 1.151) - position_at(cycles, 15.0, 1.101);
  };
  EXPECT_GT(apart_um(run.bad), 3.0) << "10 % of the stroke";
  EXPECT_LT(apart_um(run.bad), 4.5) << "15 % of the stroke";
  EXPECT_LT(std::abs(apart_um(run.good)), 0.05);
}

TEST(SymptomPicture, MovesTheWrongWayUntilTheAxisFaultsBefore5PercentOfTheRange) {
  const PageRun& run = run_of("moves-the-wrong-way");
  ASSERT_NEAR(run.bad.faulted_s(), 0.209, 1e-9);
  const auto before = [&](const char* column) {
    return run.bad[column][run.bad.at(run.bad.faulted_s()) - 1];
  };
  EXPECT_GT(before("drive"), 2.0);
  EXPECT_LT(before("drive"), 5.0) << "of 100 V";
  EXPECT_LT(before("position_um"), -0.3);
  EXPECT_GT(run.good["position_um"][run.good.at(0.209)], 0.3);
}

double greatest_step_um(const std::vector<double>& position_um) {
  double greatest = 0.0;
  for (std::size_t i = 1; i < position_um.size(); ++i)
    greatest = std::max(greatest, std::abs(position_um[i] - position_um[i - 1]));
  return greatest;
}

TEST(SymptomPicture, JumpsAtTheStartWhereTheRelayIsLateAndGoesOverTheWholeRangeInAnyCase) {
  const PageRun& run = run_of("jumps-at-the-start");
  EXPECT_GT(greatest_step_um(run.bad.part("position_um", 0.15, 0.8)), 3.0);
  EXPECT_LT(greatest_step_um(run.good.part("position_um", 0.15, 0.85)), 0.5);
  for (const Cycles* cycles : {&run.good, &run.bad})
    EXPECT_GT(greatest_of(cycles->part("position_um", 0.15, 0.8)), 29.0);
}

TEST(SymptomPicture, DriftsAtRestWithoutFeedbackOnly) {
  const PageRun& run = run_of("drifts");
  for (const Cycles* cycles : {&run.good, &run.bad})
    for (const double reference_um : cycles->part("reference_um", 2.5, 6.0)) EXPECT_EQ(reference_um, 20.0);
  double before_um = run.bad["error_um"][run.bad.at(3.0)];
  for (const double time_s : {3.5, 4.0, 4.5, 5.0, 5.5, 5.99}) {
    const double now_um = run.bad["error_um"][run.bad.at(time_s)];
    EXPECT_GT(now_um, before_um + 0.2) << time_s;
    before_um = now_um;
  }
  EXPECT_LT(greatest_of(run.good.part("error_um", 2.5, 6.0)), 0.01);
}

/// The longest time for which the error stays within the tolerance.
std::size_t longest_within(const std::vector<double>& error_um, double tolerance_um) {
  std::size_t longest = 0, now = 0;
  for (const double error : error_um)
    longest = std::max(longest, now = std::abs(error) <= tolerance_um ? now + 1 : 0);
  return longest;
}

// In position is within 0.05 um for 20 cycles.
TEST(SymptomPicture, IsNeverOnTargetWhereTheNoiseIsAsLargeAsTheTolerance) {
  const PageRun& run = run_of("never-on-target");
  EXPECT_LT(longest_within(run.bad.part("error_um", 2.7, 3.1), 0.05), 20U);
  EXPECT_EQ(longest_within(run.good.part("error_um", 2.9, 3.05), 0.05), 150U);
  EXPECT_LT(std::abs(mean_of(run.bad.part("error_um", 2.7, 3.1))), 0.01) << "it stands where it should";
}

TEST(SymptomPicture, FaultsAtOnceWhereTheErrorCrossesItsLimit) {
  const PageRun& run = run_of("faults-at-once");
  ASSERT_NEAR(run.bad.faulted_s(), 1.059, 1e-9);
  EXPECT_LT(greatest_of(run.bad.part("error_um", 0.802, 1.053)), 1.6);
  EXPECT_GT(greatest_of(run.bad.part("error_um", 1.053, 1.059)), 1.6);
  EXPECT_LT(greatest_of(run.good.tracked("error_um")), 0.15);
}

TEST(SymptomPicture, IsWorseThanYesterdayByTheSameErrorInEachPeriod) {
  const PageRun& run = run_of("worse-than-yesterday");
  const std::vector<double> yesterday = run.good.part("error_um", 1.5, 1.6),
                            today = run.bad.part("error_um", 1.5, 1.6),
                            next = run.bad.part("error_um", 1.6, 1.7);
  EXPECT_GT(rms_of(today), 3.0 * rms_of(yesterday));
  std::vector<double> difference;
  std::ranges::transform(today, next, std::back_inserter(difference), std::minus<>());
  EXPECT_LT(rms_of(difference), 0.1 * rms_of(today));
  EXPECT_TRUE(std::isnan(run.bad.faulted_s()));
}

TEST(SymptomPicture, DoesNotMoveWhileTheDriveStands) {
  const PageRun& run = run_of("does-not-move");
  ASSERT_NEAR(run.bad.faulted_s(), 0.721, 1e-9);
  EXPECT_NEAR(greatest_of(run.bad["drive"]), 9.5, 0.5);
  EXPECT_LT(greatest_of(run.bad["position_um"]), 0.01);
  EXPECT_EQ(greatest_of(run.bad["amplifier_output"]), 0.0);
  EXPECT_GT(greatest_of(run.good.part("position_um", 0.15, 0.8)), 29.0);
}

// No simulated bus makes the bus-off of this computer, so the lines come from those who write them.
TEST(SymptomPages, QuoteTheLinesOfABusOff) {
  std::string lines;
  can::BusHealthLog log("can0", [&](auto, const std::string& line) { lines += line + "\n"; });
  can::BusReport report;
  report.time_s = 0.5;
  report.state = can::BusState::passive;
  report.error_counters = can::ErrorCounters{.transmit = 128, .receive = 3};
  log.sample(report);
  log.sample(
      {.time_s = 0.6, .state = can::BusState::bus_off, .refusal = {}, .error_counters = {}, .counters = {}});
  log.write();
  lines += fmt::format("x: faulted at 0.600 s: {}; {}\n", to_string(controller::Cause::bus_off),
                       remedy(controller::Cause::bus_off));
  EXPECT_EQ(block_under(page_of("bus-off"), "What the log says"), lines);
}

TEST(SymptomPages, QuoteWhatTheBrowserShowsWithoutAController) {
  const fs::path web = HYSTCAN_SOURCE_DIR "/app/page/web";
  for (const auto& [words, file] : {std::pair{"connected, no controller", "main.js"},
                                    std::pair{"no answer of the controller", "status_view.js"}}) {
    EXPECT_NE(support::read_file(documents / "troubleshooting.md").find(words), std::string::npos) << words;
    EXPECT_NE(support::read_file(web / file).find(words), std::string::npos) << words;
  }
}

}  // namespace
}  // namespace hystcan::documents::symptom_test
