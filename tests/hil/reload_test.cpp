// Changes the configuration file of a running controller and checks the log.
// tests/closed_loop/reload_test.cpp checks that the change causes no jump.
#include <gtest/gtest.h>

#include "tests/hil/live_stage.h"

namespace hystcan::reload_test {
namespace {

using hil::QuickStage;

std::size_t count_in(const std::string& log, const std::string& text) {
  std::size_t times = 0;
  for (auto at = log.find(text); at != std::string::npos; at = log.find(text, at + 1)) ++times;
  return times;
}

TEST(Reload, IsLoggedAsADiff) {
  QuickStage stage;
  stage.start();
  struct Step {
    const char* what;
    const char* with;
    const char* diff;
  };
  const std::vector<Step> steps{
      {"= 0.0          # um per um", "= 0.08", "axis[0].control.kp: 0 -> 0.08"},
      {"\"inverse+pi\"", "\"average+pi\"", "axis[0].control.structure: 'inverse+pi' -> 'average+pi'"},
      {"high_um      = 27.0", "high_um = 21.0", "axis[0].control.setpoint[0].high_um: 27 -> 21"}};
  for (const Step& step : steps) {
    stage.files.edit("piezo.toml", step.what, step.with);
    EXPECT_TRUE(stage.bench.controller->says(step.diff)) << stage.bench.controller->err();
  }
  EXPECT_EQ(count_in(stage.bench.controller->err(), "configuration: "), steps.size())
      << "and nothing else: " << stage.bench.controller->err();
}

}  // namespace
}  // namespace hystcan::reload_test
