// The example that commands a running controller from Python.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/hil/live_stage.h"

namespace hystcan::python_test {
namespace {

namespace fs = std::filesystem;

TEST(RecordedRun, IsMadeByThePythonExampleThatCommandsATwin) {
  const fs::path source = fs::path(HYSTCAN_SOURCE_DIR) / "python";
  if (!fs::exists(HYSTCAN_PYTHON_MODULE)) GTEST_SKIP() << "there is no Python package";
  hil::QuickStage stage;
  stage.files.edit("piezo.toml", "[twin]\n", "[record]\ndir = \"" + stage.folder() + "/runs\"\n\n[twin]\n");
  stage.start({});
  const fs::path package = fs::path(stage.folder()) / "python" / "hystcan";
  fs::create_directories(package);
  for (const fs::path& file :
       {source / "hystcan/__init__.py", source / "hystcan/client.py", fs::path(HYSTCAN_PYTHON_MODULE)})
    fs::copy_file(file, package / file.filename());
  support::Process script({"env", "PYTHONPATH=" + package.parent_path().string(), "/usr/bin/python3",
                           (source / "examples/command_twin.py").string(), "--socket", stage.socket});
  EXPECT_EQ(script.wait(), 0) << script.err();
  EXPECT_NE(script.out().find(" um at "), std::string::npos) << script.out();
  EXPECT_NE(script.out().find("recorded in " + stage.folder() + "/runs/run_"), std::string::npos)
      << script.out();
  EXPECT_EQ(stage.axis_status(0).at("state"), "tracking") << "the stage goes on";
}

}  // namespace
}  // namespace hystcan::python_test
