// What an identified mode, a loop and a fragment of a configuration look like in words, TOML and JSON: what
// `dynamics` and `tune` share.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "identification/dynamics/tuning.h"

namespace hystcan::app {

double decibel(double gain);

/// `name`, padded, and `value`.
std::string line(const std::string& name, const std::string& value);
/// Lines: natural frequency, damping ratio, delay, gain, residual.
std::string describe(const identification::SecondOrderFit& fit, const std::string& input_unit,
                     const std::string& output_unit);
std::string describe(const identification::Margins& margins);
/// Lines: the rule that the gains are chosen by.
std::string describe(const identification::PiRule& rule);

/// The preview of the reference counts an amplifier's lag 1 / (2 pi bandwidth): the bandwidth that stands for
/// the delay found, five digits. Empty where no delay can be told from none.
std::optional<double> bandwidth_Hz_for(const identification::Estimate& delay_s);

/// A number that TOML reads as a float.
std::string toml_number(double value);
/// Five significant digits.
double rounded(double value);
/// Each line behind `# `.
std::string as_comment(const std::string& text);

nlohmann::json to_json(const identification::Margins& margins);
/// The fit's estimates, each under its name, and its residual.
nlohmann::json to_json(const identification::SecondOrderFit& fit);

}  // namespace hystcan::app
