// Formats an identified mode, a loop and a fragment of a configuration as text, TOML and JSON, for `tune`.
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

/// Returns a line with the padded `name` and the `value`.
std::string line(const std::string& name, const std::string& value);
/// Returns lines with natural frequency, damping ratio, delay, gain, residual and chain, or with the reason
/// why no mode is shown and its consequence. Warns if the resonance is far from the stated one.
std::string describe(const IdentifiedPlant& plant, const controller::Delays& stated,
                     const std::string& input_unit, const std::string& output_unit);
std::string describe(const controller::Margins& margins);
/// Returns a text such as ", 2 cycles left out", or an empty one.
std::string left_out_text(const IdentifiedPlant& plant);
/// Returns frequency, depth and width, for example "220 Hz, 0.1, 0.35".
std::string describe(const controller::Notch::Config& notch);
/// Returns lines that describe the rule for choosing the gains.
std::string describe(const controller::SensitivityRule& rule);
std::string describe(const controller::CautiousRule& rule);

/// Returns the estimate of a delay, with its interval, increased by `s` seconds.
identification::Estimate later(identification::Estimate delay_s, double s);

double microseconds(std::chrono::nanoseconds duration);

/// Rounds the value to `digits` significant digits.
double rounded(double value, int digits = 5);

nlohmann::json to_json(const controller::Margins& margins);
nlohmann::json to_json(const std::optional<controller::Notch::Config>& notch);
/// Returns the estimates by name, and the residual. The estimates of a mode that is not shown are null.
nlohmann::json to_json(const IdentifiedPlant& plant);

}  // namespace hystcan::app
