#include "app/page/axis_curves.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "app/stage/dynamics_text.h"
#include "controller/analysis/linear_loop.h"

namespace hystcan::app {
namespace {

constexpr int points_of_a_curve = 400;
constexpr int points_of_a_reference = 101;
constexpr double lowest_Hz = 0.1;

}  // namespace

nlohmann::json reference_curves_of(const config::AxisConfig& axis, double cycle_s) {
  const model::HysteresisParameters& model = axis.control.law.model;
  const model::Interval& range = model.input_range();
  nlohmann::json curves{{"delay_s", axis.control.delays.to_sample_s(cycle_s)}};
  for (int i = 0; i < points_of_a_reference; ++i) {
    const double drive = range.lo + (range.hi - range.lo) * i / (points_of_a_reference - 1);
    curves["drive"].push_back(drive);
    curves["ascending_um"].push_back(model.output(model.ascending.value(drive)));
    curves["descending_um"].push_back(model.output(model.descending.value(drive)));
  }
  return curves;
}

nlohmann::json bode_of(const config::AxisConfig& axis, double cycle_s) {
  const controller::LinearLoop loop(
      controller::loop_config_of(axis.control.law, axis.control.delays, cycle_s));
  const controller::PiGains& pi = axis.control.law.pi;
  nlohmann::json curves;
  const double highest_Hz = 0.5 / cycle_s;
  double last_deg = -90.0;
  for (int i = 0; i < points_of_a_curve; ++i) {
    const double frequency_Hz =
        lowest_Hz * std::pow(highest_Hz / lowest_Hz, static_cast<double>(i) / (points_of_a_curve - 1));
    const std::complex<double> open = loop(pi, 2.0 * std::numbers::pi * frequency_Hz * cycle_s);
    double phase_deg = std::arg(open) * 180.0 / std::numbers::pi;
    phase_deg -= 360.0 * std::round((phase_deg - last_deg) / 360.0);
    last_deg = phase_deg;
    curves["frequency_Hz"].push_back(frequency_Hz);
    curves["loop_dB"].push_back(decibel(std::abs(open)));
    curves["loop_deg"].push_back(phase_deg);
    curves["sensitivity_dB"].push_back(-decibel(std::abs(1.0 + open)));
    curves["closed_dB"].push_back(decibel(std::abs(open / (1.0 + open))));
  }
  const controller::Margins margins = controller::margins_of(loop, pi);
  const auto number = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
  };
  curves["stable"] = margins.stable;
  curves["gain_margin_dB"] = number(decibel(margins.gain_margin));
  curves["phase_margin_deg"] = number(margins.phase_margin_deg);
  curves["crossover_Hz"] = margins.crossover_Hz > 0.0 ? number(margins.crossover_Hz) : nlohmann::json();
  curves["peak_sensitivity"] = number(margins.peak_sensitivity);
  return curves;
}

}  // namespace hystcan::app
