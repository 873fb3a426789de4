// A clean stop saves the memory of an axis.
#include "app/live/saved_states.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <fstream>
#include <functional>

#include "config/files/memory_file.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/refusal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shipped.h"

namespace hystcan::app::saved_states_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;

/// The shipped stage after a clean stop of axis x; `record` receives every cycle record of the run.
class StoppedStage {
 public:
  explicit StoppedStage(const char* start_up = "wipe") {
    const std::string folder = "state_dir = \"" + files.folder().string() + "\"\n";
    files.edit("piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 1000.0\n" + folder);
    // The twin starts with another memory each time; for this mismatch, the shipped loop would be too fast.
    files.edit("piezo.toml", "ki_per_s           = 409.0", "ki_per_s           = 120.0");
    files.edit("piezo.toml", "wipe_slew_V_per_s", "start_up = \"wipe\"\nwipe_slew_V_per_s");
    set_start_up(start_up);
  }
  /// Start-up of axis x; y is wiped.
  void set_start_up(const std::string& start_up) const {
    files.edit("piezo.toml", "start_up = \"wipe\"", "start_up = \"" + start_up + "\"");
  }
  /// Power-on, 0.9 s of the reference, a clean stop, then the given action.
  void run(const std::function<void(SavedStates&, const controller::Controller&)>& then) {
    const config::Config config = load();
    SavedStates states(config);
    highest_initial_drive = 0.0;
    rehearsal::Rehearsal rehearsal(support::setup_of(config), [this](const controller::CycleRecord& record) {
      if (record.axis == 0 && record.report.state == AxisState::initialising)
        highest_initial_drive = std::max(highest_initial_drive, record.report.drive);
    });
    states.restore(rehearsal.controller());
    rehearsal.start();
    rehearsal.run_for(milliseconds(2000));
    ASSERT_EQ(rehearsal.controller().axis(0).state(), AxisState::tracking)
        << to_string(rehearsal.controller().axis(0).fault().cause);
    rehearsal.controller().request_stop();
    rehearsal.run_for(milliseconds(500));
    ASSERT_TRUE(rehearsal.controller().stopped());
    then(states, rehearsal.controller());
  }
  void run_and_save() {
    run([](SavedStates& states, const controller::Controller& controller) { states.save(controller); });
  }
  config::Config load() const { return config::load(files / "piezo.toml"); }
  std::filesystem::path state() const { return files / "x.state.toml"; }

  support::ShippedCopy files;
  double highest_initial_drive = 0.0;
};

std::string memory_text(const model::Hysteresis& model, const model::HysteresisState& memory) {
  std::vector<char> buffer(model::Hysteresis::saved_size());
  return std::string(model.save(memory, buffer));
}

void expect_refused(const StoppedStage& stage, std::string_view reason) {
  const std::string refusal = support::refusal_of([&] { const SavedStates states(stage.load()); });
  EXPECT_NE(std::string_view(refusal).find(reason), std::string_view::npos) << refusal;
}

TEST(SavedStates, AreReadBackExactly) {
  StoppedStage stage;
  stage.run([&](SavedStates& states, const controller::Controller& controller) {
    states.save(controller);
    const controller::ControlLaw* law = controller.axis(0).law_to_save();
    ASSERT_NE(law, nullptr);
    const config::SavedState saved = config::load_state(stage.state(), law->model());
    EXPECT_EQ(saved.memory.input, law->memory().input);
    EXPECT_EQ(saved.memory.output, law->memory().output);
    EXPECT_EQ(memory_text(law->model(), saved.memory), memory_text(law->model(), law->memory()));
  });
}

TEST(SavedStates, AreRestoredWithoutADriveToTheThresholds) {
  StoppedStage stage;
  stage.run_and_save();
  EXPECT_EQ(stage.highest_initial_drive, 100.0) << "wiped";
  stage.set_start_up("restore");
  stage.run_and_save();
  EXPECT_LT(stage.highest_initial_drive, 1.0);
}

TEST(SavedStates, AreRemovedAsSoonAsTheAxisIsDriven) {
  StoppedStage stage;
  stage.run_and_save();
  ASSERT_TRUE(std::filesystem::exists(stage.state()));
  SavedStates states(stage.load());
  states.forget(0);
  EXPECT_FALSE(std::filesystem::exists(stage.state()));
  EXPECT_TRUE(std::filesystem::exists(stage.files / "y.state.toml"));
  stage.set_start_up("restore");
  expect_refused(stage, "the file is missing, so the last stop was not clean");
}

TEST(SavedStates, WarnIfTheyCannotBeRemoved) {
  StoppedStage stage;
  stage.run_and_save();
  SavedStates states(stage.load());
  std::filesystem::remove(stage.state());
  std::filesystem::create_directories(stage.state() / "in the way");
  std::ostringstream log;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::ostream_sink_st>(log)));
  states.forget(0);
  spdlog::set_default_logger(before);
  EXPECT_NE(log.str().find("x.state.toml: cannot be removed: Directory not empty; do not use start_up"),
            std::string::npos)
      << log.str();
}

TEST(SavedStates, AreNotWrittenForAFaultedAxis) {
  StoppedStage stage;
  const config::Config config = stage.load();
  const SavedStates states(config);
  rehearsal::Rehearsal rehearsal(support::setup_of(config), [](const controller::CycleRecord&) {});
  rehearsal.start();
  rehearsal.run_for(milliseconds(2000));
  rehearsal.kill_twin();
  rehearsal.run_for(milliseconds(500));
  ASSERT_EQ(rehearsal.controller().axis(0).state(), AxisState::faulted);
  states.save(rehearsal.controller());
  EXPECT_FALSE(std::filesystem::exists(stage.state()));
}

TEST(SavedStates, OfAnotherModelAreRefusedOnlyForARestore) {
  StoppedStage stage;
  stage.run_and_save();
  stage.files.edit("piezo.model.toml", "k_ascending  = 0.035", "k_ascending  = 0.034");
  EXPECT_NO_THROW(SavedStates(stage.load())) << "start_up = \"wipe\" needs none";
  stage.set_start_up("restore");
  expect_refused(stage, "model");
}

TEST(SavedStates, AreRefusedIfIncomplete) {
  StoppedStage stage;
  stage.run_and_save();
  const std::string whole = support::read_file(stage.state());
  stage.set_start_up("restore");
  ASSERT_NO_THROW(SavedStates(stage.load()));
  const config::Config config = stage.load();
  // Without the last newline the file is still complete.
  for (std::size_t size = 0; size + 1 < whole.size(); size += 1 + whole.size() / 40) {
    std::ofstream(stage.state(), std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(SavedStates{config}, Error) << whole.substr(0, size);
  }
}

TEST(SavedStates, DoNotFollowALink) {
  StoppedStage stage;
  const std::filesystem::path other = stage.files / "other.txt";
  std::ofstream(other) << "of another user";
  for (const char* end : {"", ".new"}) std::filesystem::create_symlink(other, stage.state().string() + end);
  stage.run_and_save();
  EXPECT_EQ(support::read_file(other), "of another user");
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(stage.state())));
}

TEST(SavedStates, NeedAFolderForARestore) {
  StoppedStage stage("restore");
  stage.files.edit("piezo.toml", "state_dir = ", "# ");
  expect_refused(stage, "expected state_dir in [controller]");
}

}  // namespace
}  // namespace hystcan::app::saved_states_test
