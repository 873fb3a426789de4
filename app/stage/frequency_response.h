// The frequency response of an experiment, of the identified mode and of two loops, as a table and as a picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "identification/dynamics/empirical_response.h"

namespace hystcan::app {

struct FrequencyResponse {
  struct Loop {
    controller::LoopConfig config;
    controller::Pi::Config pi;
  };
  std::string title;
  std::vector<identification::ResponsePoint> measured;
  controller::Delays plant;  ///< its command delay does not count
  double gain = 1.0;         ///< of the plant at rest, output units per drive unit
  double cycle_s = 1e-3;     ///< of the record
  Loop before, after;
};

/// CSV, a row for each measured frequency. Gains of plant and model are 1 at rest; phases are in degrees, those of the
/// loops from -90 on without a leap.
std::string table_of(const FrequencyResponse& response);

/// Draws `picture` (.svg or .png) with gnuplot, whose script remains beside it as .gnuplot. Returns an empty text, or why
/// there is no picture.
std::string draw(const FrequencyResponse& response, const std::filesystem::path& picture);

/// Throws Error unless the name ends with .svg or .png.
void require_picture(const std::filesystem::path& picture);

}  // namespace hystcan::app
