// An identified mode, a loop and a fragment of a configuration as text, TOML and JSON, for `tune`.
#pragma once

#include <chrono>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/stage/identified_plant.h"
#include "controller/analysis/loop_design.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

double decibel(double gain);

/// A line with `name`, padded, and `value`.
std::string line(const std::string& name, const std::string& value);
/// Lines: natural frequency, damping ratio, delay, gain, residual, chain; or why no mode is shown, and what
/// that means. A warning where the resonance is far from the stated one.
std::string describe(const IdentifiedPlant& plant, const controller::Delays& stated,
                     const std::string& input_unit, const std::string& output_unit);
std::string describe(const controller::Margins& margins);
/// ", 2 cycles left out", or nothing.
std::string left_out_text(const IdentifiedPlant& plant);
/// "220 Hz, 0.1, 0.35": frequency, depth, width.
std::string describe(const controller::Notch::Config& notch);
/// Lines: the rule that chooses the gains.
std::string describe(const controller::SensitivityRule& rule);
std::string describe(const controller::CautiousRule& rule);

/// The estimate, moved by `s`.
identification::Estimate later(identification::Estimate delay_s, double s);

double microseconds(std::chrono::nanoseconds duration);

/// The value to so many significant digits.
double rounded(double value, int digits = 5);

nlohmann::json to_json(const controller::Margins& margins);
nlohmann::json to_json(const std::optional<controller::Notch::Config>& notch);
/// The estimates by name, and the residual. Those of a mode that is not shown are null.
nlohmann::json to_json(const IdentifiedPlant& plant);

}  // namespace hystcan::app
