#include "runs/export.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "storage/hdf5.h"
#include "tests/runs/scratch_runs.h"

namespace hystcan::runs::export_test {
namespace {

class Export : public ScratchRuns {
 protected:
  std::filesystem::path record(std::uint64_t cycles) {
    Recorder recorder = make();
    const auto run = recorder.start();
    for (std::uint64_t cycle = 1; cycle <= cycles; ++cycle)
      for (const std::size_t axis : {0U, 1U}) recorder.add(tracked(cycle, axis));
    recorder.finish();
    return run;
  }
  static std::string csv(const std::filesystem::path& run, const Selection& selection) {
    std::string text;
    export_csv(RecordedRun(run), selection, [&](std::string_view part) { text += part; });
    return text;
  }
};

TEST_F(Export, WritesTheSelectedSignalsOfAnAxisWithTheirUnits) {
  const std::string text =
      csv(record(3), {.axis = "y", .signals = {"drive", "state"}, .span = {.from_s = 0.002}});
  EXPECT_NE(
      text.find("# time_s_unit = \"s\"\n# drive_unit = \"V\"\ntime_s,drive,state\n0.002,0.5,tracking\n0.003,"
                "0.75,tracking\n"),
      std::string::npos)
      << text;
}

TEST_F(Export, WritesAllSignalsByDefault) {
  const std::string text = csv(record(1), {.axis = "x", .signals = {}, .span = {}});
  EXPECT_NE(text.find("\ntime_s,cycle,state,fault,"), std::string::npos) << text;
}

TEST_F(Export, RefusesAxesSignalsAndTimesMissingFromTheRun) {
  const auto run = record(3);
  EXPECT_THROW(csv(run, {.axis = {}, .signals = {}, .span = {}}), Error) << "of two axes, one is asked for";
  EXPECT_THROW(csv(run, {.axis = "z", .signals = {}, .span = {}}), Error);
  EXPECT_THROW(csv(run, {.axis = "x", .signals = {"speed"}, .span = {}}), Error);
  EXPECT_THROW(csv(run, {.axis = "x", .signals = {}, .span = {.from_s = 5.0}}), Error);
}

TEST_F(Export, RefusesAHeaderAlone) {
  const std::string cycles = text_of(record(1) / "cycles_0001.csv");
  const std::filesystem::path alone = record(1).parent_path() / "alone.csv";
  std::ofstream(alone) << cycles.substr(0, cycles.find('\n', cycles.find("time_s")) + 1);
  EXPECT_THROW(axes_of(RecordedRun(alone), {}), Error);
  EXPECT_THROW(axis_of(RecordedRun(alone), "x"), Error);
}

TEST_F(Export, RefusesAnInvalidHdf5GroupName) {
  config.axes[0].wire.name = "a/b";
  const auto run = record(3);
  storage::Hdf5Writer file("/dev/null");
  EXPECT_THROW(export_hdf5(RecordedRun(run), {}, file), Error);
}

TEST_F(Export, KeepsForeignTextInTheLineOfItsComment) {
  config.axes[0].wire.drive_unit = "V\n=1+1";
  const std::string text = csv(record(3), {.axis = "x", .signals = {"drive"}, .span = {}});
  EXPECT_NE(text.find("# drive_unit = \"V =1+1\"\ntime_s,drive\n"), std::string::npos) << text;
}

TEST_F(Export, RefusesARunWithoutAxes) {
  config.axes.clear();
  storage::Hdf5Writer file("/dev/null");
  EXPECT_THROW(export_hdf5(RecordedRun(record(0)), {}, file), Error);
}

}  // namespace
}  // namespace hystcan::runs::export_test
