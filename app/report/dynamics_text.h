// An identified mode, a loop and a fragment of a configuration as text, TOML and JSON, for `dynamics` and
// `tune`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "identification/dynamics/tuning.h"

namespace hystcan::app {

double decibel(double gain);

/// A line with `name`, padded, and `value`.
std::string line(const std::string& name, const std::string& value);
/// Lines: natural frequency, damping ratio, delay, gain, residual.
std::string describe(const identification::SecondOrderFit& fit, const std::string& input_unit,
                     const std::string& output_unit);
std::string describe(const identification::Margins& margins);
/// Lines: the rule that chooses the gains.
std::string describe(const identification::PiRule& rule);

/// The amplifier bandwidth that represents the identified delay in the preview of the reference, to five
/// digits:
///   bandwidth_Hz = 1 / (2 pi delay_s)
/// Empty if the delay cannot be distinguished from zero.
std::optional<double> bandwidth_Hz_for(const identification::Estimate& delay_s);

/// The value in a form that TOML reads as a float.
std::string toml_number(double value);
/// The value to five significant digits.
double rounded(double value);
/// Puts `# ` before each line.
std::string as_comment(const std::string& text);

nlohmann::json to_json(const identification::Margins& margins);
/// The estimates of the fit by name, and its residual.
nlohmann::json to_json(const identification::SecondOrderFit& fit);

}  // namespace hystcan::app
