// The reports of the page besides rows: the difference to the file, the bus, metrics.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>
#include <set>
#include <sstream>

#include "app/live/control_protocol.h"
#include "app/page/axis_curves.h"
#include "app/page/bus_counters.h"
#include "app/page/config_save.h"
#include "app/page/open_metrics.h"
#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::app::page_reports_test {
namespace {

using nlohmann::json;

TEST(LineDiff, ShowsChangesWithTwoLinesOfContext) {
  EXPECT_EQ(line_diff("a\nb\nc\nd\ne\nf\n", "a\nb\nc\nD\ne\nf\n"), "  b\n  c\n- d\n+ D\n  e\n  f\n");
  EXPECT_EQ(line_diff("1\n2\n3\n4\n5\n6\n7\n8\n9\n", "1\n2\n3\n4\n5\n6\n7\n8\n9\n"), "");
  EXPECT_EQ(line_diff("1\n2\n3\n4\n5\n6\n7\n8\n9\n", "0\n2\n3\n4\n5\n6\n7\n8\n0\n"),
            "- 1\n+ 0\n  2\n  3\n  ...\n  7\n  8\n- 9\n+ 0\n");
  EXPECT_EQ(line_diff("a\n", "a\nb\n"), "  a\n+ b\n");
}

TEST(ConfigSave, KeepsCommentsAndListsItsChanges) {
  const support::ShippedCopy files;
  const std::vector<config::Change> unsaved{{"axis[0].control.kp", "0", "0.25"},
                                            {"axis[0].control.notch.frequency_Hz", "", "480.0"},
                                            {"axis[0].control.notch.depth", "", "0.1"},
                                            {"axis[0].control.notch.width", "", "0.5"},
                                            {"axis[0].control.wipe_dwell_s", "0.1", ""}};
  const ConfigSave save = save_of(files / "piezo.toml", unsaved);
  EXPECT_NE(save.text.find("kp                 = 0.25"), std::string::npos);
  EXPECT_NE(save.diff.find("+ # wipe_dwell_s       = 0.1"), std::string::npos) << save.diff;
  EXPECT_NE(save.diff.find("+ frequency_Hz = 480.0"), std::string::npos) << save.diff;
  EXPECT_EQ(support::read_file(files / "piezo.toml").find("0.25"), std::string::npos)
      << "nothing is written yet";
  EXPECT_NE(save_of(files / "piezo.toml", {}).digest, save.digest);
}

const metrics::Histogram no_times({});
const BusReport no_bus{};

std::vector<config::Change> segment_changes(
    std::size_t index, std::initializer_list<std::pair<const char*, const char*>> values) {
  std::vector<config::Change> changes;
  for (const auto& [key, value] : values)
    changes.push_back({"axis[0].control.setpoint[" + std::to_string(index) + "]." + key, "", value});
  return changes;
}

/// The configuration, with the shipped file replaced by this text.
config::Config loaded(const support::ShippedCopy& files, const std::string& text) {
  std::ofstream(files / "piezo.toml") << text;
  return config::load(files / "piezo.toml");
}

TEST(ConfigSave, AppendsANewSegmentAfterTheLastOneOfItsAxis) {
  const support::ShippedCopy files;
  const std::vector<config::Change> unsaved = segment_changes(2, {{"kind", "'sine'"},
                                                                  {"low_um", "5"},
                                                                  {"high_um", "20"},
                                                                  {"frequency_Hz", "5"},
                                                                  {"cycles", "5"},
                                                                  {"transition_s", "0.2"}});
  const ConfigSave save = save_of(files / "piezo.toml", unsaved);
  EXPECT_NE(save.diff.find("+ [[axis.control.setpoint]]\n+ kind = 'sine'\n"), std::string::npos) << save.diff;
  const config::Config config = loaded(files, save.text);
  ASSERT_EQ(config.axes[0].control.setpoint.size(), 3u);
  EXPECT_EQ(config.axes[1].control.setpoint.size(), 2u);
}

TEST(ConfigSave, PutsTheLinesOfARemovedSegmentIntoComments) {
  const support::ShippedCopy files;
  const std::vector<config::Change> unsaved = segment_changes(
      1, {{"kind", ""}, {"levels_um", ""}, {"rise_s", ""}, {"dwell_s", ""}, {"transition_s", ""}});
  const ConfigSave save = save_of(files / "piezo.toml", unsaved);
  EXPECT_NE(save.diff.find("+ # [[axis.control.setpoint]]"), std::string::npos) << save.diff;
  EXPECT_EQ(loaded(files, save.text).axes[0].control.setpoint.size(), 1u);
}

/// piezo.toml with all setpoints of axis x in one line.
void write_inline_setpoints(const support::ShippedCopy& files) {
  std::string text = support::read_file(files / "piezo.toml");
  const auto first = text.find("[[axis.control.setpoint]]"), end = text.find("[axis.twin]");
  text.erase(first, end - first);
  const auto in_position = text.find("[axis.control.in_position]");
  const auto repeat = text.rfind("repeat             = true\n", in_position);
  text.insert(repeat,
              "setpoint = [{kind = 'hold', level_um = 10.0, duration_s = 1.0, transition_s = 0.2}, "
              "{ kind = 'hold', level_um = 20.000, duration_s = 1.0, transition_s = 0.2 }]  # two\n");
  std::ofstream(files / "piezo.toml") << text;
}

TEST(ConfigSave, RemovesAndAddsSegmentsOfASetpointInOneLine) {
  const support::ShippedCopy files;
  write_inline_setpoints(files);
  const ConfigSave removed =
      save_of(files / "piezo.toml",
              segment_changes(1, {{"kind", ""}, {"level_um", ""}, {"duration_s", ""}, {"transition_s", ""}}));
  EXPECT_NE(removed.text.find("setpoint = [{kind = 'hold', level_um = 10.0, duration_s = 1.0, transition_s = "
                              "0.2}]"),
            std::string::npos)
      << removed.diff;
  const ConfigSave added = save_of(
      files / "piezo.toml",
      segment_changes(
          2, {{"kind", "'hold'"}, {"level_um", "5.0"}, {"duration_s", "1.0"}, {"transition_s", "0.2"}}));
  const config::Config config = loaded(files, added.text);
  ASSERT_EQ(config.axes[0].control.setpoint.size(), 3u);
  EXPECT_EQ(std::get<controller::Hold>(config.axes[0].control.setpoint[2].shape).level_um, 5.0);
  EXPECT_NE(added.text.find("level_um = 20.000"), std::string::npos) << "the others keep their text";
}

TEST(ConfigSave, RefusesToMakeAFileUnreadable) {
  const support::ShippedCopy files;
  const std::string text = support::refusal_of([&] {
    (void)save_of(files / "piezo.toml", {{"axis[0].control.ki_per_s", "409", ""}});
  });
  EXPECT_TRUE(text.starts_with("nothing is saved, because the file can no longer be read: ")) << text;
  EXPECT_NE(text.find("ki_per_s"), std::string::npos) << text;
}

class FakeInterface : public testing::Test {
 protected:
  void count(std::uint64_t frames, std::uint64_t bytes) const {
    std::filesystem::create_directories(network_ / "can0/statistics");
    for (const auto& [name, number] : {std::pair("tx_packets", frames), std::pair("tx_bytes", bytes)})
      std::ofstream(network_ / "can0/statistics" / name) << number << "\n";
    std::ofstream(network_ / "can0/flags") << "0x40081\n";
  }
  support::ShippedCopy folder_;
  std::filesystem::path network_ = folder_ / "net";
};

TEST_F(FakeInterface, HasTheRateAndTheLoadOfItsCounters) {
  BusCounters bus("can0", {.bitrate_bit_per_s = 1e6}, network_);
  const BusCounters::Clock::time_point start;
  count(1000, 8000);
  EXPECT_TRUE(std::isnan(bus.report(start).frames_per_s));
  count(3000, 24'000);
  const BusReport report = bus.report(start + std::chrono::seconds(1));
  EXPECT_EQ(report.state, "up");
  EXPECT_DOUBLE_EQ(report.frames_per_s, 2000.0);
  EXPECT_NEAR(report.load_percent, 100.0 * 2000 * 111 * 1.1 / 1e6, 1e-9);
}

// A command and a sample of 20 bytes in each cycle, 230 of their bits at 5 Mbit/s, beside a SYNC.
TEST_F(FakeInterface, HasTheLoadOfFdFramesWithBothBitRates) {
  config::Config config = config::load(folder_ / "lab_amplifier.toml");
  config.bus.data_bitrate_bit_per_s = 5'000'000;
  for (can::Message& message : config.database.messages)
    if (message.name == "AmpSet" || message.name == "SensPos") {
      message.length = 18;
      message.bit_rate_switch = true;
    }
  const AverageFrames average = average_frames(config);
  EXPECT_DOUBLE_EQ(average.fd_bytes, 20.0);
  EXPECT_GT(average.fd_time_s, 48e-6 + 198 / 5e6) << "29 bits of identifier, without stuff bits";
  EXPECT_LT(average.fd_time_s, 55e-6 + 238 / 5e6) << "with the most";
  BusCounters bus("can0", average, network_);
  const BusCounters::Clock::time_point start;
  count(0, 0);
  bus.report(start);
  count(3000, 2000 * 20 + 1000);
  const double sync_s = 1.1 * (47 + 8) / 1e6;
  EXPECT_NEAR(bus.report(start + std::chrono::seconds(1)).load_percent,
              100.0 * (2000 * average.fd_time_s + 1000 * sync_s), 0.5);
}

TEST_F(FakeInterface, ReportsThatItIsMissingOrSimulated) {
  EXPECT_EQ(BusCounters("can9", {}, network_).report().state, "missing");
  EXPECT_EQ(BusCounters("", {}, network_).report().state, "simulated");
}

// https://prometheus.io/docs/specs/om/open_metrics_spec: a family before its samples, counters end in _total,
// the end.
TEST(OpenMetrics, NamesTheFamilyOfEachSampleAndEnds) {
  metrics::Histogram times({50.0});
  for (const double time_us : {0.5, 30.0, 1e9}) times.add(time_us);
  const StatusAnswer status{
      .counters = {.cycles = 12},
      .axes = {{.name = "a\"b", .state = controller::AxisState::tracking, .position_um = 1.5}}};
  const std::string text = metrics_text(true, status, 0.1, {.interface = "can0", .frames_per_s = 3.5}, times,
                                        times, {.clients = 2});
  std::istringstream lines(text);
  std::string family, last;
  std::set<std::string> families;
  for (std::string line; std::getline(lines, line); last = line) {
    if (line.starts_with("# TYPE ")) {
      family = line.substr(7, line.find(' ', 7) - 7);
      EXPECT_TRUE(families.insert(family).second) << family << " comes twice";
    }
    if (!line.starts_with("#")) {
      EXPECT_TRUE(line.starts_with(family)) << line << " is not of " << family;
    }
  }
  EXPECT_EQ(last, "# EOF");
  for (const char* line : {"hystcan_up 1\n", "hystcan_cycles_total 12\n",
                           "hystcan_axis_state{axis=\"a\\\"b\",hystcan_axis_state=\"tracking\"} 1\n",
                           "hystcan_turnaround_seconds_bucket{le=\"0.000050\"} 2\n",
                           "hystcan_turnaround_seconds_bucket{le=\"+Inf\"} 3\n", "hystcan_page_clients 2\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(Metrics, UseOnlyFeaturesOfTheOlderFormat) {
  EXPECT_FALSE(accepts_open_metrics("*/*"));
  EXPECT_TRUE(accepts_open_metrics("application/openmetrics-text;version=1.0.0;q=0.5,text/plain;q=0.2"));
  const StatusAnswer status{.counters = {.cycles = 12}};
  const std::string text = metrics_text(false, status, 0.1, no_bus, no_times, no_times, {});
  for (const char* unknown : {"stateset", " info\n", "# UNIT", "# EOF"})
    EXPECT_EQ(text.find(unknown), std::string::npos) << unknown;
  EXPECT_NE(text.find("# TYPE hystcan_cycles_total counter\n"), std::string::npos);
}

// Prometheus's own promtool tests the rules themselves (scripts/check alerts).
TEST(Metrics, ContainAllNamesOfTheAlertsAndTheDashboard) {
  const StatusAnswer status{.axes = {{.name = "x"}}};
  const std::string text = metrics_text(false, status, 0.1, no_bus, no_times, no_times, {});
  const std::regex name("hystcan_[a-z_]+");
  for (const char* file : {"/share/prometheus/hystcan.rules.yml", "/share/grafana/hystcan.json"}) {
    const std::string shipped = support::read_file(HYSTCAN_SOURCE_DIR + std::string(file));
    std::set<std::string> named;
    for (auto at = std::sregex_iterator(shipped.begin(), shipped.end(), name); at != std::sregex_iterator();
         ++at)
      named.insert(at->str());
    EXPECT_GT(named.size(), 4U) << file;
    for (const std::string& metric : named)
      EXPECT_TRUE(text.find(metric + "{") != std::string::npos ||
                  text.find(metric + " ") != std::string::npos)
          << file << ": " << metric << "\n"
          << text;
  }
}

TEST(OpenMetrics, ReportAMissingControllerAndTheAgeOfItsStatus) {
  const std::string text = metrics_text(true, {}, 7.5, no_bus, no_times, no_times, {});
  EXPECT_NE(text.find("hystcan_up 0\n"), std::string::npos);
  EXPECT_NE(text.find("hystcan_status_age_seconds 7.5\n"), std::string::npos);
  EXPECT_EQ(text.find("hystcan_cycles"), std::string::npos);
}

TEST(ReferenceCurves, MeetAtTheUpperThresholdAndIncrease) {
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  const json curves = reference_curves_of(config.axes[0], 1e-3);
  const std::vector<double> up = curves.at("ascending_um"), down = curves.at("descending_um");
  EXPECT_TRUE(std::ranges::is_sorted(up) && std::ranges::is_sorted(down));
  EXPECT_NEAR(up.back(), down.back(), 1e-6);
  EXPECT_GT(down[50] - up[50], 1.0) << "um: hysteresis";
}

TEST(ReferenceCurves, ReportTheDelayFromDriveToSample) {
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  // One cycle until the command acts, half a cycle of the held drive, the amplifier (1500 Hz), the mode (500
  // Hz, 0.05).
  const double expected_s =
      1e-3 + 0.5e-3 + 1.0 / (2.0 * std::numbers::pi * 1500.0) + 2.0 * 0.05 / (2.0 * std::numbers::pi * 500.0);
  EXPECT_NEAR(reference_curves_of(config.axes[0], 1e-3).at("delay_s"), expected_s, 1e-9);
}

TEST(Bode, HasTheMarginsOfTheLoopThatCheckPrints) {
  const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  const json curves = bode_of(config.axes[0], 1e-3);
  const std::size_t points = curves.at("frequency_Hz").size();
  for (const char* name : {"loop_dB", "loop_deg", "sensitivity_dB", "closed_dB"})
    EXPECT_EQ(curves.at(name).size(), points) << name;
  EXPECT_DOUBLE_EQ(curves.at("frequency_Hz").back(), 500.0);
  double peak_dB = 0.0;
  for (const double sensitivity_dB : curves.at("sensitivity_dB")) peak_dB = std::max(peak_dB, sensitivity_dB);
  EXPECT_NEAR(std::pow(10.0, peak_dB / 20.0), curves.at("peak_sensitivity"), 0.02);
  EXPECT_TRUE(curves.at("stable"));
}

}  // namespace
}  // namespace hystcan::app::page_reports_test
