#include "app/command_line/run_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "app/command_line/run_table.h"
#include "app/command_line/step_response.h"
#include "tests/runs/scratch_runs.h"

namespace hystcan::app::run_figures_test {
namespace {

TEST(PlotRows, KeepsEveryRowOfAShortSignal) {
  PlotRows rows;
  for (int i = 0; i < 9000; ++i) rows.add({1e-3 * i, 0.0, 0.0, static_cast<double>(i % 7), 0.0});
  EXPECT_EQ(rows.rows().size(), 9000U);
}

TEST(PlotRows, KeepsThePeaksOfALongOneInItsOrder) {
  PlotRows rows;
  constexpr int many = 1'000'000;
  for (int i = 0; i < many; ++i)
    rows.add({1e-3 * i, 0.0, 0.0, i == 777'777 ? 5.0 : i == 123'456 ? -5.0 : 0.1, 0.0});
  const std::vector<PlotRow> kept = rows.rows();
  EXPECT_LE(kept.size(), PlotRows::most);
  double least = 0.0, greatest = 0.0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    least = std::min(least, kept[i].error_um);
    greatest = std::max(greatest, kept[i].error_um);
    EXPECT_TRUE(i == 0 || kept[i].time_s > kept[i - 1].time_s);
  }
  EXPECT_EQ(least, -5.0);
  EXPECT_EQ(greatest, 5.0);
}

class DriveOfARow : public runs::ScratchRuns {
 protected:
  /// The figures of a run whose drive rises by 0.25 in each cycle.
  RunFigures figures() {
    runs::Recorder recorder = make();
    const std::filesystem::path run = recorder.start();
    for (std::uint64_t cycle = 1; cycle <= 50; ++cycle) recorder.add(tracked(cycle));
    recorder.finish();
    return figures_of(runs::RecordedRun(run), 0, {});
  }
};

TEST_F(DriveOfARow, IsEarlierByTheKnownDelayOfTheChain) {
  const double delay_s = config.axes[0].control.delays.to_sample_s(1e-3);
  const RunFigures of = figures();
  EXPECT_EQ(of.drive_delay_s, delay_s);
  EXPECT_NEAR(of.drive_delay_s, 1.64e-3, 0.01e-3);  // two cycles would be 0.36 ms too much
  const std::vector<PlotRow> rows = of.rows.rows();
  for (std::size_t i = 4; i < rows.size(); ++i)
    EXPECT_NEAR(rows[i].drive, 250.0 * (rows[i].time_s - delay_s), 1e-9);
}

/// Second-order response to a step from 2 to 12 at 0.1 s: damping 0.5, 10 Hz.
TEST(StepResponse, FindsRiseOvershootAndSettling) {
  std::vector<double> time_s, reference, position;
  const double omega = 62.83, damping = 0.5, damped = omega * std::sqrt(1.0 - damping * damping);
  for (int i = 0; i < 1100; ++i) {
    const double t = 1e-3 * i, since = t - 0.1;
    time_s.push_back(t);
    reference.push_back(since < 0.0 ? 2.0 : 12.0);
    position.push_back(since < 0.0 ? 2.0
                                   : 12.0 - 10.0 * std::exp(-damping * omega * since) *
                                                (std::cos(damped * since) +
                                                 damping * omega / damped * std::sin(damped * since)));
  }
  const auto step = step_response(time_s, reference, position);
  ASSERT_TRUE(step);
  EXPECT_EQ(step->from, 2.0);
  EXPECT_EQ(step->to, 12.0);
  EXPECT_NEAR(step->overshoot_percent, 16.3, 0.1);
  ASSERT_TRUE(step->rise_s && step->settled_s);
  EXPECT_NEAR(*step->rise_s, 1.64 / omega, 1.1e-3);
  EXPECT_NEAR(*step->settled_s, 8.08 / omega, 2e-3);
}

TEST(StepResponse, IsNotFoundInATriangle) {
  std::vector<double> time_s, reference;
  for (int i = 0; i < 1000; ++i) time_s.push_back(1e-3 * i), reference.push_back(std::abs(i % 200 - 100));
  EXPECT_FALSE(step_response(time_s, reference, reference));
}

RunFigures figures() {
  RunFigures run{.run = "run_1",
                 .axis = "x",
                 .drive_unit = "V",
                 .stroke_um = 20.0,
                 .cycles = 100,
                 .rms_um = 0.02,
                 .max_um = 0.1,
                 .faults = 1,
                 .rows = {},
                 .spectrum = Spectrum(1000.0),
                 .step = {},
                 .step_rows = {}};
  return run;
}

TEST(RunTable, HasErrorsInPercentOfTheStroke) {
  EXPECT_NE(run_table({figures()}, "csv").find("\nrun_1,x,100,0.0200,0.1000,0.100,0.500,1,,,\n"),
            std::string::npos);
}

TEST(RunTable, LeavesWhatIsUnknownEmpty) {
  RunFigures run = figures();
  run.stroke_um = 0.0;
  EXPECT_NE(run_table({run}, "csv").find(",0.0200,0.1000,,,1,,,\n"), std::string::npos);
}

TEST(RunTable, IsMarkdownOrLatex) {
  EXPECT_TRUE(run_table({figures()}, "markdown").starts_with("| run | axis |"));
  const std::string latex = run_table({figures()}, "latex");
  EXPECT_TRUE(latex.starts_with("\\begin{tabular}"));
  EXPECT_NE(latex.find("run\\_1 & x & 100"), std::string::npos) << latex;
}

}  // namespace
}  // namespace hystcan::app::run_figures_test
