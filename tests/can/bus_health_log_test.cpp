#include "can/bus_health_log.h"
#include "tests/support/shows.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace hystcan::can::bus_health_log_test {
namespace {
using Lines = std::vector<std::string>;

TEST(RateLimit, AllowsTheFirstLineAndThenOnePerPeriodWithTheNumberOfEvents) {
  RateLimit limit(1.0);
  EXPECT_EQ(limit.add(1, 0.0), 1U);
  EXPECT_EQ(limit.add(1, 0.5), std::nullopt);
  EXPECT_EQ(limit.add(40, 0.75), std::nullopt);
  EXPECT_EQ(limit.add(1, 1.0), 42U);
  EXPECT_EQ(limit.add(1, 1.5), std::nullopt);
}

TEST(RateLimit, ReportsSuppressedEventsEvenWithoutNewEvents) {
  RateLimit limit(1.0);
  EXPECT_EQ(limit.add(0, 0.0), std::nullopt) << "nothing has happened";
  EXPECT_EQ(limit.add(1, 0.0), 1U);
  EXPECT_EQ(limit.add(7, 0.5), std::nullopt);
  EXPECT_EQ(limit.add(0, 1.5), 7U);
  EXPECT_EQ(limit.add(0, 3.0), std::nullopt);
}

struct FakeBus final : Bus {
  bool send(const Frame&) override { return true; }
  void on_frame(FrameHandler) override {}
  bool on_sent(FrameHandler) override { return false; }
  void on_state(StateHandler) override {}
  BusState state() const override { return now; }
  Refusal refusal() const override { return refused; }
  std::optional<ErrorCounters> error_counters() const override { return errors; }
  const BusCounters& counters() const override { return totals; }

  BusState now = BusState::active;
  Refusal refused = Refusal::none;
  std::optional<ErrorCounters> errors;
  BusCounters totals;
};

// All connections receive the same error frames, but each has its own sent and lost frames.
TEST(ReportOfSeveralConnections, AddsSentAndLostFramesAndCountsErrorFramesOnce) {
  FakeBus amplifier;
  amplifier.totals.sent = 10;
  amplifier.totals.receive_lost = 2;
  amplifier.totals.error_frames = 3;
  amplifier.errors = ErrorCounters{.transmit = 96, .receive = 0};
  FakeBus sensor;
  sensor.now = BusState::warning;
  sensor.totals.sent = 5;
  sensor.totals.receive_lost = 1;
  sensor.totals.send_refused = 4;
  sensor.totals.error_frames = 3;
  const BusReport both = report_of(std::vector<const Bus*>{&amplifier, &sensor}, 1.5);
  EXPECT_EQ(
      describe(both),
      "bus warning: 15 frames sent, 0 received, 4 not sent, 3 lost in the kernel, 3 error frames, error "
      "counters 96 transmit, 0 receive");
  EXPECT_EQ(both.time_s, 1.5);
}

struct BusLogging : testing::Test {
  Lines written_at(double time_s) {
    lines.clear();
    log.sample(report_of(bus, time_s));
    log.write();
    return lines;
  }
  Lines lines;
  std::vector<BusHealthLog::Level> levels;
  FakeBus bus;
  BusHealthLog log{"can0", [this](BusHealthLog::Level level, const std::string& line) {
                     levels.push_back(level);
                     lines.push_back(line);
                   }};
};

TEST_F(BusLogging, WritesNothingWhileTheBusIsHealthy) {
  bus.totals.sent = 1000;
  bus.totals.received = 1000;
  EXPECT_EQ(written_at(1.0), Lines{});
}

TEST_F(BusLogging, WritesEveryStateWithTheErrorCounters) {
  bus.now = BusState::passive;
  bus.errors = ErrorCounters{.transmit = 128, .receive = 3};
  EXPECT_EQ(written_at(0.5), Lines{"can0: bus passive at 0.500 s, error counters 128 transmit, 3 receive"});
  bus.now = BusState::bus_off;
  bus.errors.reset();
  EXPECT_EQ(written_at(0.6), Lines{"can0: bus bus-off at 0.600 s"});
  bus.now = BusState::active;
  bus.totals.restarts = 1;
  EXPECT_EQ(written_at(0.7),
            (Lines{"can0: bus active at 0.700 s", "can0: 1 restarts after bus-off (counted until 0.700 s)"}));
  EXPECT_EQ(levels, (std::vector{BusHealthLog::Level::warning, BusHealthLog::Level::error,
                                 BusHealthLog::Level::info, BusHealthLog::Level::warning}));
}

TEST_F(BusLogging, LogsWhyAnInterfaceThatIsUpAgainIsUnused) {
  bus.now = BusState::down;
  EXPECT_EQ(written_at(0.5), Lines{"can0: bus down at 0.500 s"});
  bus.refused = Refusal::listen_only;
  EXPECT_EQ(written_at(0.6), Lines{"can0: the interface is up again at 0.600 s, but is not used, "
                                   "because the interface is listen-only now"});
  EXPECT_EQ(written_at(0.7), Lines{});
}

TEST_F(BusLogging, WritesOneLinePerSecondForAStateThatAlternates) {
  shows("S-171");
  Lines all;
  for (int sample = 0; sample < 100; ++sample) {  // 1/64 s, exact in a double
    bus.now = sample % 2 == 0 ? BusState::warning : BusState::active;
    for (const std::string& line : written_at(sample / 64.0)) all.push_back(line);
  }
  EXPECT_EQ(all, (Lines{"can0: bus warning at 0.000 s", "can0: bus active at 0.016 s",
                        "can0: bus warning at 1.000 s (32 times since the last line)",
                        "can0: bus active at 1.016 s (32 times since the last line)"}));
}

TEST_F(BusLogging, WritesOneLinePerSecondForManyErrorsAndCountsThemAll) {
  shows("S-171");
  std::uint64_t reported = 0;
  int line_count = 0;
  for (int sample = 0; sample <= 300; ++sample) {  // 20 ms each: 6 s; the errors end after 4 s
    if (sample < 200) bus.totals.not_acknowledged += 3;
    for (const std::string& line : written_at(0.02 * sample)) {
      reported += std::stoull(line.substr(line.find(' ')));
      ++line_count;
    }
  }
  EXPECT_EQ(reported, 600U);
  EXPECT_LE(line_count, 6);
}

TEST(BusSummary, ListsTheTotalsAndOnlyTheProblemsThatOccurred) {
  BusReport report;
  report.counters.sent = 5210;
  report.counters.received = 8120;
  EXPECT_EQ(describe(report), "bus active: 5210 frames sent, 8120 received");
  report.state = BusState::warning;
  report.counters.send_refused = 3;
  report.counters.not_acknowledged = 4;
  report.counters.error_frames = 4;
  report.error_counters = ErrorCounters{.transmit = 96, .receive = 0};
  EXPECT_EQ(describe(report),
            "bus warning: 5210 frames sent, 8120 received, 3 not sent, 4 not acknowledged, 4 error frames, "
            "error counters 96 transmit, 0 receive");
}

}  // namespace
}  // namespace hystcan::can::bus_health_log_test
