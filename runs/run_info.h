// The description of a recorded run, stored as `run.json` in the run's folder:
//
//   DIR/run_20261123T092000.123Z/
//     run.json            time, host, command; axes and units; settings in force; results of each axis
//     config/             copies of the configuration and of all files that it names
//     cycles_0001.csv     every cycle of every axis; the next part after rotation is 0002
//     bus_0001.log        the bus log (candump format), if enabled
//     changes.csv         settings that changed during the run
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace hystcan::runs {

inline constexpr const char* run_prefix = "run_";
inline constexpr const char* info_name = "run.json";

/// A fault of an axis during a run: its cause and its time.
struct RunFault {
  std::string cause;
  double time_s = 0.0;
};

/// An axis of a run, with the tracking errors of the rows in which the axis tracked. NaN is stored as null in
/// run.json.
struct RunAxis {
  std::string name;
  std::string drive_unit{};
  double stroke_um = 0.0;  ///< stroke that the axis's model can reach; 0: unknown
  /// Mean delay from a drive to the position sample that shows the effect of this drive, s; NaN: unknown.
  double delay_s = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t tracked_rows = 0;
  double rms_um = std::numeric_limits<double>::quiet_NaN();  ///< RMS tracking error; NaN: never tracked
  double max_um = std::numeric_limits<double>::quiet_NaN();  ///< largest magnitude of the tracking error
  std::vector<RunFault> faults{};
};

struct RunInfo {
  std::string version;  ///< version of hystcan
  std::string host;
  std::string command;  ///< command of hystcan that recorded the run, for example "controller"
  std::string config;   ///< file name of the configuration
  std::string interface;
  double rate_Hz = 0.0;
  std::string started{};               ///< start time (ISO 8601, UTC)
  std::string ended{};                 ///< end time; empty: the run is in progress or was killed
  std::string failure{};               ///< reason why the recording failed; empty: the recording did not fail
  double first_s = 0.0, last_s = 0.0;  ///< time_s of the first and the last row
  std::uint64_t rows = 0;
  std::uint64_t rows_lost = 0;
  std::vector<RunAxis> axes{};
  std::vector<std::pair<std::string, std::string>>
      settings{};  ///< configuration keys at the start of the run, with their values as TOML

  std::vector<std::string> axis_names() const;
};

nlohmann::json to_json(const RunInfo& info);
/// Reads RUN/run.json. Throws Error with the file name if the file is invalid.
RunInfo read_run_info(const std::filesystem::path& run);
/// Returns true if RUN/run.json has a list of faults for each axis and all these lists are empty.
bool ended_without_fault(const std::filesystem::path& run);
/// Writes RUN/run.json, and replaces an existing file atomically. Throws RunError if writing fails.
void write_run_info(const std::filesystem::path& run, const RunInfo& info);

}  // namespace hystcan::runs
