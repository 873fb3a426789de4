// Formats identified dynamics, loops and gain rules as text, TOML and JSON, for `hystcan tune`.
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

/// Returns one line of a report: `name`, padded to a fixed width, and `value`.
std::string line(const std::string& name, const std::string& value);
/// Describes identified dynamics in lines: natural frequency, damping ratio, delay, gain, residual, and the
/// chain of amplifier, mode and sensor. If the record shows no mode, the lines give the reason and the
/// consequence. A line warns if the resonance is far from the stated one.
std::string describe(const IdentifiedPlant& plant, const controller::Delays& stated,
                     const std::string& input_unit, const std::string& output_unit);
std::string describe(const controller::Margins& margins);
/// Returns a text such as ", 2 cycles left out"; an empty text if the record has no gaps.
std::string left_out_text(const IdentifiedPlant& plant);
/// Returns frequency, depth and width of a notch filter, for example "220 Hz, 0.1, 0.35".
std::string describe(const controller::Notch::Config& notch);
/// Describe the rule with which the gains are chosen, in lines.
std::string describe(const controller::SensitivityRule& rule);
std::string describe(const controller::CautiousRule& rule);

/// Returns the estimate of a delay after `s` seconds were added to its value and its interval.
identification::Estimate later(identification::Estimate delay_s, double s);

double microseconds(std::chrono::nanoseconds duration);

/// Rounds `value` to this number of significant digits.
double rounded(double value, int digits = 5);

nlohmann::json to_json(const controller::Margins& margins);
nlohmann::json to_json(const std::optional<controller::Notch::Config>& notch);
/// Returns the identified values and the residual as JSON. If the record shows no mode, the values of the
/// mode are null.
nlohmann::json to_json(const IdentifiedPlant& plant);

}  // namespace hystcan::app
