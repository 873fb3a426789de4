// The description of a run: `run.json` in its folder.
//
//   DIR/run_20261123T092000.123Z/
//     run.json            time, host, command; axes and units; columns; settings in force; outcome
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

/// A fault of an axis.
struct RunFault {
  std::string cause;
  double time_s = 0.0;
};

/// An axis and its results while it tracked. NaN is null in run.json.
struct RunAxis {
  std::string name;
  std::string drive_unit{};
  double stroke_um = 0.0;  ///< stroke of its model, between the thresholds; 0: unknown
  /// Mean delay from a drive to the sample that shows its effect; NaN: unknown.
  double delay_s = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t tracked_rows = 0;
  double rms_um = std::numeric_limits<double>::quiet_NaN();  ///< RMS of the error; NaN: no row was tracked
  double max_um = std::numeric_limits<double>::quiet_NaN();  ///< largest magnitude of the error
  std::vector<RunFault> faults{};
};

struct RunInfo {
  std::string version;  ///< version of hystcan
  std::string host;
  std::string command;  ///< "controller"
  std::string config;   ///< file name of the configuration
  std::string interface;
  double rate_Hz = 0.0;
  std::string started{};               ///< ISO 8601, UTC
  std::string ended{};                 ///< empty: the run is in progress or was killed
  std::string failure{};               ///< reason if the recording ended before the run; else empty
  double first_s = 0.0, last_s = 0.0;  ///< time_s of the first and the last row
  std::uint64_t rows = 0;
  std::uint64_t rows_lost = 0;
  std::vector<RunAxis> axes{};
  std::vector<std::pair<std::string, std::string>>
      settings{};  ///< keys in force at the start, with their values as TOML

  std::vector<std::string> axis_names() const;
};

nlohmann::json to_json(const RunInfo& info);
/// Reads RUN/run.json. Throws Error with the file name if the file is invalid.
RunInfo read_run_info(const std::filesystem::path& run);
/// Returns true if RUN/run.json lists the faults of each axis and there are none.
bool ended_without_fault(const std::filesystem::path& run);
/// Replaces RUN/run.json atomically. Throws RunError.
void write_run_info(const std::filesystem::path& run, const RunInfo& info);

}  // namespace hystcan::runs
