// An identified mode, a loop and a fragment of a configuration as text, TOML and JSON, for `dynamics` and
// `tune`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "controller/analysis/loop_design.h"
#include "identification/dynamics/second_order_fit.h"

namespace hystcan::app {

double decibel(double gain);

/// A line with `name`, padded, and `value`.
std::string line(const std::string& name, const std::string& value);
/// Lines: natural frequency, damping ratio, delay, gain, residual.
std::string describe(const identification::SecondOrderFit& fit, const std::string& input_unit,
                     const std::string& output_unit);
std::string describe(const controller::Margins& margins);
/// Lines: the chain that a loop is designed for, and a warning where its resonance is far from the stated one.
std::string describe(const controller::Delays& found, const controller::Delays& stated);
/// ", 2 cycles left out", or nothing.
std::string left_out_text(const identification::SecondOrderFit& fit);
/// "220 Hz, 0.1, 0.35": frequency, depth, width.
std::string describe(const controller::Notch::Config& notch);
/// Lines: the rule that chooses the gains.
std::string describe(const controller::SensitivityRule& rule);
std::string describe(const controller::CautiousRule& rule);

/// The estimate, moved by `s`.
identification::Estimate later(identification::Estimate delay_s, double s);

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

nlohmann::json to_json(const controller::Margins& margins);
nlohmann::json to_json(const std::optional<controller::Notch::Config>& notch);
/// The estimates of the fit by name, and its residual.
nlohmann::json to_json(const identification::SecondOrderFit& fit);

}  // namespace hystcan::app
