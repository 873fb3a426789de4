// The rehearsal of a stage that has just been made.
#include "app/stage/axis_completion.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "tests/support/shipped.h"

namespace hystcan::app::axis_completion_test {
namespace {

TEST(RehearsalOfAStage, ThatTracksNoSampleHasNoFigures) {
  const support::ShippedCopy shipped;
  config::Config config = config::load(shipped / "piezo.toml");
  config.axes.resize(1);
  config.axes[0].control.setpoint = {{.shape = controller::Hold{.level_um = 10.0, .duration_s = 0.05}}};
  config.axes[0].control.repeat = false;
  try {
    rehearsal_of(config, {TuningReport{}}, {"cautious"});
    ADD_FAILURE() << "figures of no sample";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("axis x tracked no sample"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace hystcan::app::axis_completion_test
