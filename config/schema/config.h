// The configuration of controller and twin: one TOML file, and the model files and the DBC that it names.
//
// Each part of the program has its own configuration structs. This folder reads them, checks them against
// each other and prints them. docs/configuration.md lists the keys.
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

inline constexpr double rate_max_Hz = 10'000.0;  ///< maximum of `controller.rate_Hz`

inline constexpr std::string_view control_key = "control";    ///< key of the table [axis.control]
inline constexpr std::string_view setpoint_key = "setpoint";  ///< key of the list of segments in it

struct BusConfig {
  std::string interface = "vcan0";
  std::uint32_t bitrate_bit_per_s = 1'000'000;
  std::uint32_t data_bitrate_bit_per_s = 0;  ///< bit rate of the data phase of CAN FD; 0: no bit-rate switch
  std::filesystem::path dbc;
  /// Sum of two times: from receiving a SYNC to queueing the sample (sensor), and from receiving the sample
  /// to queueing the command (controller).
  can::Duration turnaround{std::chrono::microseconds(50)};

  unsigned background_slots = 0;  ///< slots for heartbeats and statuses (can::is_in_slot); 0: none

  can::BitRates rates() const { return {bitrate_bit_per_s, data_bitrate_bit_per_s}; }
};

/// One axis: its control, and its simulated or analogue devices.
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

/// [record]: runs on disk (runs/recorder.h).
struct RecordConfig {
  std::filesystem::path folder = "hystcan-runs";  ///< folder of the runs; relative to the working directory
  bool at_start = false;                          ///< false: recording starts by command
  bool bus_log = false;
  double part_MB = 256.0;                          ///< size of a CSV at which the next part begins
  can::Duration part_time{std::chrono::hours(1)};  ///< age of a CSV at which the next part begins
  double limit_GB = 20.0;                          ///< maximum size of the folder
};

struct Config {
  std::filesystem::path file;
  BusConfig bus;
  controller::CommonConfig controller;
  RecordConfig record;
  twin::CommonConfig twin;
  std::vector<AxisConfig> axes;
  std::vector<controller::RestingAxis> resting{};  ///< axes of the file that are not controlled
  can::Database database;
};

std::vector<std::string> axis_names(const Config& config);

/// Returns the part of the configuration for the controller.
controller::Config controller_config(const Config& config);
/// Returns the part of the configuration for the twin.
twin::Config twin_config(const Config& config);
/// Returns the axes with [axis.analogue]. The node accepts the drives of [axis.control].
std::vector<node::WiredAnalogueAxis> analogue_axes(const Config& config);

/// Reads and checks `file` and all files that it names; files in the cache `files` are read only if they
/// changed. The overrides replace values of `file`. Throws Error.
Config load(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
            const ReadFiles& files = {});

/// Like load(), with this text as the content of `file`, which need not exist.
Config load_text(const std::filesystem::path& file, std::string_view text);

/// Like load(), for a stage that is not measured yet: a straight line through the drives and positions of an
/// axis replaces its model (or that of its twin) if the file is missing or not named.
Config load_unmeasured(const std::filesystem::path& file);

/// Reads the configuration with the values in the file, its models and the messages of its DBC; resolves no
/// paths and checks nothing between the keys.
Config load_as_written(const std::filesystem::path& file, const std::vector<Setting>& overrides = {},
                       const ReadFiles& files = {});

/// Updates the values derived from model, delays and reference after an axis was changed in memory: the
/// limits of its transitions, and the turnarounds. Does not redesign the filters.
void derive(Config& config, std::size_t axis);

/// Returns the configuration in force as TOML, with a mark at each default value. Throws Error.
std::string echo(const std::filesystem::path& file, const std::vector<Setting>& overrides = {});

}  // namespace hystcan::config
