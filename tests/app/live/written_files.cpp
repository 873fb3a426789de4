// written_files WHAT FILE [...]: writes the files of a live run as `controller` and `page` do, but in virtual
// time, in one thread and with a fixed date, so that each run makes the same calls. crash_test.py makes these
// calls fail.
//
//   run CONFIG [SECONDS]    saved states are removed and written, a run is recorded; the axes stop cleanly
//   fault CONFIG [SECONDS]  the twin loses its power: each axis writes a black box
//   save FILE KEY TEXT      the page's save; undo FILE takes it back
//   token FILE              the page's token
//
// SECONDS after the fixed date.
//
// Prints a digest of all commanded drives.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "app/live/saved_states.h"
#include "app/page/config_save.h"
#include "app/page/page_access.h"
#include "config/schema/settings.h"
#include "controller/black_box.h"
#include "rehearsal/rehearsal.h"
#include "runs/run_folder.h"
#include "runs/run_writer.h"

namespace hystcan::app {
namespace {

using std::chrono::milliseconds;

runs::UtcNow fixed_date(const std::vector<std::string>& words) {
  const std::chrono::seconds date(1'767'225'600 + (words.size() > 2 ? std::stoi(words[2]) : 0));
  return [date] { return std::chrono::system_clock::time_point(date); };
}

void warn(can::BusHealthLog::Level level, const std::string& line) {
  if (level == can::BusHealthLog::Level::warning) spdlog::warn(line);
}

/// FNV-1a over the bits of every drive.
struct Digest {
  std::uint64_t value = 0xcbf29ce484222325;
  void add(double drive) { value = (value ^ std::bit_cast<std::uint64_t>(drive)) * 0x100000001b3; }
};

void run(const std::filesystem::path& file, const runs::UtcNow& now) {
  const config::Config config = config::load(file);
  SavedStates states(config);
  const std::vector<config::Setting> settings = config::settings(file);
  runs::RunWriter writer(config, runs::describe(config, settings, "test"), warn, now);
  Digest drives;
  rehearsal::Rehearsal rehearsal(rehearsal_setup(config), [&](const controller::CycleRecord& record) {
    drives.add(record.report.drive);
    if (record.report.state >= controller::AxisState::initialising) states.forget(record.axis);
    writer.add(record);
  });
  rehearsal.start();
  rehearsal.run_for(milliseconds(3000));  // more than one part of 1 MB
  writer.add(config::Change{"axis[0].control.kp", "0.05", "0.06"});
  rehearsal.controller().request_stop();
  rehearsal.run_for(milliseconds(500));
  if (!rehearsal.controller().stopped()) throw std::runtime_error("the axes have not stopped");
  states.save(rehearsal.controller());
  writer.end();
  writer.write_until_the_end();
  fmt::print("{:016x}\n", drives.value);
}

void fault(const std::filesystem::path& file, const runs::UtcNow& now) {
  const config::Config config = config::load(file);
  std::vector<std::string> names;
  for (const config::AxisConfig& axis : config.axes) names.push_back(axis.wire.name);
  controller::BlackBox black_box(config.controller.black_box, names, warn, now);
  Digest drives;
  rehearsal::Rehearsal rehearsal(rehearsal_setup(config), [&](const controller::CycleRecord& record) {
    drives.add(record.report.drive);
    black_box.add(record);
  });
  rehearsal.start();
  rehearsal.run_for(milliseconds(600));
  rehearsal.kill_twin();
  rehearsal.run_for(milliseconds(300));
  black_box.finish();
  fmt::print("{:016x}\n", drives.value);
}

void act(const std::vector<std::string>& words) {
  const std::string& what = words.at(0);
  const std::filesystem::path file = words.at(1);
  if (what == "run") return run(file, fixed_date(words));
  if (what == "fault") return fault(file, fixed_date(words));
  if (what == "save") return write_save(file, save_of(file, {{words.at(2), "", words.at(3)}}));
  if (what == "undo") return write_save(file, undo_of(file));
  if (what == "token") return static_cast<void>(token_of(file));
  throw std::invalid_argument(what);
}

}  // namespace
}  // namespace hystcan::app

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_st("log"));
  try {
    hystcan::app::act({argv + 1, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "written_files: {}\n", error.what());
    return 1;
  }
}
