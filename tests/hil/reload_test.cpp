// The configuration file of a running controller, changed: taken over between two cycles without a jump on
// the wire, or not at all and with the reason.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/live_stage.h"
#include "tests/support/drive_step.h"

namespace hystcan::reload_test {
namespace {

using hil::between;
using hil::json;
using hil::LiveStage;
using hil::milliseconds;
using hil::now_s;
using hil::OnWire;
using hil::series;

struct Reload : testing::Test {
  LiveStage stage;
  std::string edited = "piezo.toml";

  /// Replaces the first occurrence in the file, which is that of x. As most editors do, it puts another file
  /// in the place of the old one.
  void replace(const std::string& what, const std::string& with) const {
    const std::filesystem::path file = stage.files / edited.c_str();
    const std::filesystem::path draft = file.string() + ".new";
    std::filesystem::copy_file(file, draft);
    stage.files.edit((edited + ".new").c_str(), what, with);
    std::filesystem::rename(draft, file);
  }
  void rewrite_in_place(const std::string& what, const std::string& with) const {
    stage.files.edit(edited.c_str(), what, with);
  }
  /// Waits until the log has the text this often.
  bool comes_to_log(const std::string& text, std::size_t times) const {
    return hil::eventually([&] { return count_in_log(text) >= times; });
  }
  /// How often the log has the text.
  std::size_t count_in_log(const std::string& text) const {
    const std::string log = stage.bench.controller->err();
    std::size_t times = 0;
    for (auto at = log.find(text); at != std::string::npos; at = log.find(text, at + 1)) ++times;
    return times;
  }
};

TEST_F(Reload, GainsStructureLimitsAndSetpointChangeWithoutAJumpAndAreLoggedAsADiff) {
  stage.start();
  const double tracking_s = now_s();
  std::this_thread::sleep_for(milliseconds(2600));  // one pass of the reference
  struct Step {
    const char* what;
    const char* with;
    const char* diff;
    bool in_place;
  };
  const std::vector<Step> steps{
      {"= 0.0          # um per um", "= 0.08", "axis[0].control.kp: 0 -> 0.08", false},
      {"\"inverse+pi\"", "\"average+pi\"", "axis[0].control.structure: 'inverse+pi' -> 'average+pi'", true},
      {"high_um      = 27.0", "high_um = 21.0", "axis[0].control.setpoint[0].high_um: 27 -> 21", false}};
  std::vector<double> changed_s;
  for (const Step& step : steps) {
    step.in_place ? rewrite_in_place(step.what, step.with) : replace(step.what, step.with);
    EXPECT_TRUE(stage.bench.controller->says(step.diff)) << step.diff << "\n"
                                                         << stage.bench.controller->err();
    changed_s.push_back(now_s());
    std::this_thread::sleep_for(milliseconds(250));
  }
  std::this_thread::sleep_for(milliseconds(800));
  EXPECT_LT(std::abs(stage.axis_status(0).at("error_um").get<double>()), 0.5);
  EXPECT_EQ(count_in_log("configuration: "), steps.size())
      << "and nothing else: " << stage.bench.controller->err();

  // At whatever phase of the reference each was taken over: tests/closed_loop/reload_test.cpp tries all.
  const json log = stage.bench.decoded_with_series();
  const std::vector<OnWire> commands = series(log, "X", "AmpCommand");
  const double usual_V = hil::largest_step(between(commands, tracking_s, changed_s.front() - 0.2));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double step_V = hil::largest_step(between(commands, changed_s[i] - 0.2, changed_s[i] + 0.2));
    std::printf("%s: largest step of the drive %.3f V, before any change %.3f V\n", steps[i].diff, step_V,
                usual_V);
    EXPECT_GT(step_V, 0.0);
    EXPECT_LT(step_V, support::fair_share_of_own_step * usual_V) << steps[i].diff;
  }
  EXPECT_EQ(log.at("axis_states").at("X").back(), "tracking") << log.at("axis_states");
  EXPECT_TRUE(log.at("first_fault").is_null());
}

// Links to files are followed; a folder in which another link leads elsewhere is not seen.
TEST_F(Reload, SighupTakesOverWhatIsChangedWhereNobodyWatches) {
  const std::filesystem::path folder = stage.folder(), present = folder / "present", next = folder / "next";
  std::filesystem::create_directory_symlink(folder, present);
  stage.bench.start("controller", {}, (present / "piezo.toml").string());
  ASSERT_TRUE(stage.bench.tracks()) << stage.bench.controller->err();
  std::filesystem::copy(HYSTCAN_SOURCE_DIR "/config", next);
  std::filesystem::copy_file(folder / "piezo.toml", next / "piezo.toml",
                             std::filesystem::copy_options::overwrite_existing);
  stage.files.edit("next/piezo.toml", "kp                 = 0.0 ", "kp                 = 0.04 ");
  std::filesystem::create_directory_symlink(next, folder / "led");
  std::filesystem::rename(folder / "led", present);
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_EQ(count_in_log("configuration: "), 0u) << stage.bench.controller->err();
  stage.bench.controller->send(SIGHUP);
  EXPECT_TRUE(stage.bench.controller->says("axis[0].control.kp: 0 -> 0.04")) << stage.bench.controller->err();
  EXPECT_EQ(stage.axis_status(0).at("state"), "tracking");
}

}  // namespace
}  // namespace hystcan::reload_test
