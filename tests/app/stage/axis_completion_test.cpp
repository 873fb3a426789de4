// The rehearsal of a newly created stage.
#include "app/stage/axis_completion.h"

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::app::axis_completion_test {
namespace {

TEST(RehearsalOfAStage, FailsIfNoSampleIsTracked) {
  const support::ShippedCopy shipped;
  config::Config config = config::load(shipped / "piezo.toml");
  config.axes.resize(1);
  config.axes[0].control.setpoint = {{.shape = controller::Hold{.level_um = 10.0, .duration_s = 0.05}}};
  config.axes[0].control.repeat = false;
  const std::string refusal =
      support::refusal_of<RunError>([&] { rehearsal_of(config, {TuningReport{}}, {"cautious"}); });
  EXPECT_NE(refusal.find("axis x tracked, but no sample arrived"), std::string::npos) << refusal;
}

}  // namespace
}  // namespace hystcan::app::axis_completion_test
