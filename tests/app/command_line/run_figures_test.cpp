#include "app/command_line/run_figures.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "runs/run_info.h"
#include "tests/runs/scratch_runs.h"
#include "tests/support/refusal.h"

namespace hystcan::app::run_figures_test {
namespace {

TEST(PlotRows, KeepsEveryRowOfAShortSignal) {
  PlotRows rows;
  for (int i = 0; i < 9000; ++i) rows.add({1e-3 * i, 0.0, 0.0, static_cast<double>(i % 7), 0.0});
  EXPECT_EQ(rows.rows().size(), 9000U);
}

TEST(PlotRows, KeepsThePeaksOfALongSignalInOrder) {
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

class FiguresOfARun : public runs::ScratchRuns {
 protected:
  /// The figures of a run whose drive rises by 0.25 per cycle.
  RunFigures figures() {
    runs::Recorder recorder = make();
    const std::filesystem::path run = recorder.start();
    for (std::uint64_t cycle = 1; cycle <= 50; ++cycle) recorder.add(tracked(cycle));
    recorder.finish();
    return figures_of(runs::RecordedRun(run), 0, {});
  }
};

TEST_F(FiguresOfARun, ShiftTheDriveByTheConfiguredDelays) {
  const double delay_s = config.axes[0].control.delays.to_sample_s(1e-3);
  const RunFigures of = figures();
  EXPECT_EQ(of.drive_delay_s, delay_s);
  EXPECT_NEAR(of.drive_delay_s, 1.64e-3, 0.01e-3);  // two cycles would be 0.36 ms too long
  const std::vector<PlotRow> rows = of.rows.rows();
  for (std::size_t i = 4; i < rows.size(); ++i)
    EXPECT_NEAR(rows[i].drive, 250.0 * (rows[i].time_s - delay_s), 1e-9);
}

TEST_F(FiguresOfARun, NameASettingThatIsNotANumber) {
  runs::Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  recorder.add(tracked(1));
  recorder.finish();
  runs::RunInfo info = runs::read_run_info(run);
  for (auto& [key, value] : info.settings)
    if (key == "axis[0].control.in_position.tolerance_um") value = "1e999";
  runs::write_run_info(run, info);
  EXPECT_EQ(support::refusal_of([&] { figures_of(runs::RecordedRun(run), 0, {}); }),
            run.string() + ": axis[0].control.in_position.tolerance_um is '1e999', expected a number");
}

TEST_F(FiguresOfARun, HaveTheStepResponseOfTheController) {
  runs::Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 50; ++cycle) {
    controller::CycleRecord record = tracked(cycle);
    record.report.point.shape_time_s = record.time_s;
    record.report.reference_um = cycle < 20 ? 5.0 : 15.0;
    record.report.position_um = record.report.reference_um + (cycle == 25 ? 3.0 : 0.0);
    record.report.sample_missing = cycle == 25;
    recorder.add(record);
  }
  recorder.finish();
  const RunFigures of = figures_of(runs::RecordedRun(run), 0, {});
  ASSERT_TRUE(of.step);
  EXPECT_EQ(of.step->band_um, config.axes[0].control.in_position->tolerance_um);
  EXPECT_EQ(of.step->overshoot(), 0.0) << "without the sample that was bridged";
  EXPECT_EQ(of.step->settling_s(), 0.0);
}

/// The controller restarts its count of the levels of a segment after the transition to the segment.
TEST_F(FiguresOfARun, ExcludeTransitionsFromTheStepResponse) {
  runs::Recorder recorder = make();
  const std::filesystem::path run = recorder.start();
  for (std::uint64_t cycle = 1; cycle <= 80; ++cycle) {
    controller::CycleRecord record = tracked(cycle);
    record.report.reference_um = cycle < 20 ? 1.0 : cycle < 40 ? 20.0 : cycle < 60 ? 21.0 : 20.0;
    record.report.position_um = record.report.reference_um;
    record.report.point.shape_time_s = cycle < 20 ? 0.0 : 1e-3 * static_cast<double>(cycle - 19);
    recorder.add(record);
  }
  recorder.finish();
  const RunFigures of = figures_of(runs::RecordedRun(run), 0, {});
  ASSERT_TRUE(of.step);
  EXPECT_EQ(of.step->from_um, 20.0);
  EXPECT_EQ(of.step->to_um, 21.0) << "the first of two equal ones";
}

RunFigures figures() {
  RunFigures run{.run = "run_1",
                 .axis = "x",
                 .drive_unit = "V",
                 .stroke_um = 20.0,
                 .error = {.samples = 100, .sum_of_squares = 100 * 0.02 * 0.02, .max_um = 0.1},
                 .faults = 1,
                 .rows = {},
                 .spectrum = metrics::Spectrum(1000.0),
                 .step = {},
                 .step_rows = {}};
  return run;
}

TEST(RunTable, HasErrorsInPercentOfTheStroke) {
  EXPECT_NE(run_table({figures()}, "csv").find("\nrun_1,x,100,0.0200,0.1000,0.100,0.500,1,,,\n"),
            std::string::npos);
}

TEST(RunTable, LeavesUnknownValuesEmpty) {
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

/// A foreign run folder has names that no configuration accepts.
TEST_F(FiguresOfARun, PutNamesAsPlainTextIntoEveryTable) {
  RunFigures run = figures();
  const auto row = [&](const char* axis, const char* format) {
    run.run = "pi";
    run.axis = axis;
    const std::string table = run_table({run}, format);
    const std::size_t at = table.find("pi");
    return table.substr(at, table.find('\n', at) - at);
  };
  EXPECT_TRUE(row("\\input{a}^~", "latex")
                  .starts_with("pi & \\textbackslash{}input\\{a\\}\\textasciicircum{}\\textasciitilde{} & "));
  EXPECT_TRUE(row("<img src=a onerror=b>|[c](d)", "markdown")
                  .starts_with("pi | &lt;img src=a onerror=b>\\|\\[c\\](d) | "));
  EXPECT_TRUE(row("=1+1", "csv").starts_with("pi,'=1+1,"));
  EXPECT_TRUE(row("a\"b,c\nd", "csv").starts_with("pi,\"a\"\"b,c d\","));
}

}  // namespace
}  // namespace hystcan::app::run_figures_test
