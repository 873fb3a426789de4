// What a lab engineer tunes: one TOML file for controller and twin, the model files and the DBC that it
// names.
//
// Every room has its own configuration structs; here they are read, checked against each other, and shown.
// docs/configuration.md lists the keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "can/dbc.h"
#include "controller/controller.h"
#include "model/hysteresis.h"
#include "twin/twin.h"

namespace hystcan::config {

/// What the user wrote can't be used. what() is `FILE:LINE:COLUMN: what, expected what`.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct BusConfig {
  std::string interface = "vcan0";
  std::uint32_t bitrate_bit_per_s = 1'000'000;
  std::filesystem::path dbc;
};

struct AxisConfig {
  can::AxisWire wire;
  std::string drive_unit;
  std::filesystem::path control_model;
  controller::AxisConfig control;
  std::filesystem::path twin_model;
  twin::AxisConfig twin;
};

struct Config {
  std::filesystem::path file;
  BusConfig bus;
  controller::Config controller;  ///< its axes filled from `axes`
  twin::Config twin;              ///< its axes filled from `axes`
  std::vector<AxisConfig> axes;
  can::Database database;
};

/// Reads and checks everything that `file` names. Throws Error, or can::DbcError.
Config load(const std::filesystem::path& file);

/// The configuration in force, as TOML, each value that the file leaves out marked as a default. Throws
/// Error.
std::string echo(const std::filesystem::path& file);

/// Reads a model file ([hysteresis], see docs/configuration.md) and checks the model. Throws Error.
model::HysteresisParameters load_model(const std::filesystem::path& file);

}  // namespace hystcan::config
