// The configuration of controller and twin: a TOML file, and the model files and the DBC file that it names.
//
// Each part of the program has its own configuration structs. The code in this folder reads the structs,
// checks that they agree, and prints them. docs/configuration.md lists the keys.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "can/dbc/database.h"
#include "can/frame_bits.h"
#include "config/document/setting.h"
#include "config/files/read_files.h"
#include "controller/controller.h"
#include "node/analogue/config.h"
#include "twin/twin.h"

namespace hystcan::config {

inline constexpr double rate_max_Hz = 10'000.0;  ///< maximum of the key `controller.rate_Hz`

inline constexpr std::string_view control_key = "control";    ///< name of the table [axis.control]
inline constexpr std::string_view setpoint_key = "setpoint";  ///< name of the list [[axis.control.setpoint]]

struct BusConfig {
  std::string interface = "vcan0";
  std::uint32_t bitrate_bit_per_s = 1'000'000;
  std::uint32_t data_bitrate_bit_per_s = 0;  ///< bit rate of the data phase of CAN FD; 0: no bit-rate switch
  std::filesystem::path dbc;
  /// Sum of two processing times: in the sensor, from receiving a SYNC to queueing the sample; in the
  /// controller, from receiving the sample to queueing the command.
  can::Duration turnaround{std::chrono::microseconds(50)};

  unsigned background_slots = 0;  ///< number of slots for heartbeats and statuses (can::is_in_slot); 0: none

  can::BitRates rates() const { return {bitrate_bit_per_s, data_bitrate_bit_per_s}; }
};

/// The configuration of one axis: its control, its simulated devices and, if present, its analogue devices.
struct AxisConfig {
  can::AxisWire wire;
  std::filesystem::path control_model;
  controller::AxisConfig control;
  bool live_setpoint = false;
  bool scan_marker = false;
  std::filesystem::path twin_model;
  twin::AxisConfig twin;
  std::optional<node::AnalogueConfig> analogue{};
};

/// The table [record] of the configuration: how the controller records runs on disk (runs/recorder.h).
struct RecordConfig {
  std::filesystem::path folder = "hystcan-runs";  ///< folder of the runs; relative to the working directory
  bool at_start = false;  ///< true: recording starts with the program; false: by command
  bool bus_log = false;
  double part_MB = 256.0;                          ///< size of a CSV at which the run's next CSV begins
  can::Duration part_time{std::chrono::hours(1)};  ///< age of a CSV at which the run's next CSV begins
  double limit_GB = 20.0;                          ///< maximum total size of the runs in the folder
};

struct Config {
  std::filesystem::path file;
  BusConfig bus;
  controller::CommonConfig controller;
  RecordConfig record;
  twin::CommonConfig twin;
  std::vector<AxisConfig> axes;
  std::vector<controller::RestingAxis> resting{};  ///< axes of the file that the controller does not control
  can::Database database;
};

std::vector<std::string> axis_names(const Config& config);

/// Returns the part of the configuration that the controller needs.
controller::Config controller_config(const Config& config);
/// Returns the part of the configuration that the twin needs.
twin::Config twin_config(const Config& config);
/// Returns the axes with the table [axis.analogue]. Their drive range is the drive range of [axis.control].
std::vector<node::WiredAnalogueAxis> analogue_axes(const Config& config);

/// Reads and checks a configuration, and all files that the configuration names. `overrides` replace values
/// of `file`. Files in the cache `files` are read only if they changed. Throws Error if a file is invalid.
Config load(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
            const ReadFiles& files = {});

/// Checks a configuration like load(), but its text is `text`. `file` is only the base of relative paths and
/// the name in messages; the file itself may be missing.
Config load_text(const std::filesystem::path& file, std::string_view text);

/// Loads a configuration like load(), but for a stage that is not measured yet. If a model file of an axis is
/// missing or not named, a straight line over the drives and positions of the axis replaces the model.
Config load_unmeasured(const std::filesystem::path& file);

/// Reads a configuration with the values as they are in the file, the models of the controller and the
/// messages of the DBC. Does not make relative paths absolute, and does not check that keys agree with each
/// other.
Config load_as_written(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
                       const ReadFiles& files = {});

/// Updates the derived values of an axis after its model, delays or reference changed in memory. These values
/// are the limits of velocity and acceleration for its transitions (smooth paths between two segments of the
/// reference), and the turnarounds (rounded corners) of its reference. Does not design the filters again.
void derive(Config& config, std::size_t axis);

/// Returns the configuration in force as TOML text. The comment "default" marks each value that the file does
/// not set. Throws Error if the configuration is invalid.
std::string echo(const std::filesystem::path& file, const std::vector<Setting>& overrides = {});

}  // namespace hystcan::config
