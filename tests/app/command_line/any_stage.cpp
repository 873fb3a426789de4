#include "tests/app/command_line/any_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/long_run.h"

namespace hystcan::any_stage_test {
namespace {

/// Prints all digits with a decimal point, as TOML requires for floats: a curve rounded to 1e-6 may cross the
/// other one.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

constexpr double lowest_V = -20.0, range_V = 140.0, stroke_um = 100.0;

std::string list(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) text += number(value) + ", ";
  return text + "]\n";
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

std::string model_of(const char* kind, const std::string& keys) {
  return std::string("format = 1\n\n[hysteresis]\nkind = \"") + kind +
         "\"\ninput_unit = \"V\"\noutput_unit = \"um\"\ninput_min = -20.0\ninput_max = 120.0\n" + keys;
}

/// The density decreases with the coercive drive and is tilted over the middle drive; each relay is up to 10
/// % off.
std::string preisach(Draw& draw) {
  constexpr int levels = 28;
  constexpr double side = range_V / levels;
  const double coercive = draw.between(12.0, 55.0), tilt = draw.between(-0.5, 0.5),
               reversible = draw.between(0.2, 0.6);
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = 0; i < levels; ++i)
    for (int j = 0; j <= i; ++j) {
      const double c = 0.5 * side * (i - j) / coercive, m = (i + j + 1.0) / levels - 1.0;
      const double cell = i == j ? 0.5 : 1.0;
      weights.push_back(cell * std::exp(-c * c) * (1.0 + tilt * m) * draw.between(0.9, 1.1));
      sum += weights.back();
    }
  return model_of("preisach",
                  "offset = 0.0\ngain = " + number(stroke_um * reversible / range_V) +
                      "\nweights = " + list(scaled(weights, stroke_um * (1.0 - reversible) / sum)));
}

std::string prandtl_ishlinskii(Draw& draw) {
  const auto plays = static_cast<std::size_t>(draw.between(8.0, 25.0));
  const double fall = draw.between(15.0, 60.0), reversible = draw.between(0.3, 0.6);
  std::vector<double> thresholds, weights;
  double sum = 0.0;
  for (std::size_t i = 0; i < plays; ++i) {
    const double r = 0.5 * range_V * (static_cast<double>(i) + 0.5) / static_cast<double>(plays);
    thresholds.push_back(r);
    weights.push_back(std::exp(-r / fall) * draw.between(0.3, 1.7));
    sum += weights.back() * (range_V - 2.0 * r);
  }
  weights = scaled(weights, stroke_um * (1.0 - reversible) / sum);
  const double gain = stroke_um * reversible / range_V;
  double lowest = gain * lowest_V;  // reached from above
  for (std::size_t i = 0; i < plays; ++i) lowest += weights[i] * (lowest_V + thresholds[i]);
  return model_of("prandtl-ishlinskii", "offset = " + number(-lowest) + "\ngain = " + number(gain) +
                                            "\nthresholds = " + list(thresholds) +
                                            "weights = " + list(weights));
}

/// Parabolas of the drive from 0 to 1, a s^2 + b s + c, with a third-order bump.
std::string recursive_memory(Draw& draw) {
  const auto chebyshev = [](double a, double b, double c, double bump) {
    return std::vector<double>{c + b / 2.0 + 3.0 * a / 8.0, b / 2.0 + a / 2.0, a / 8.0, bump};
  };
  const double bend = draw.between(0.0, 0.3), wide = draw.between(0.15, 0.45), open = draw.between(0.0, 0.06),
               k = draw.between(2.0, 6.0) / range_V, bump = draw.between(-0.6, 0.6);
  const auto curve = [&](double width, double opening) {
    return chebyshev(stroke_um * (bend - width), stroke_um * (1.0 - bend + width - opening),
                     stroke_um * opening, bump);
  };
  return model_of("recursive-memory",
                  "basis = \"chebyshev\"\nascending = " + list(curve(0.0, 0.0)) +
                      "descending = " + list(curve(wide, open)) + "k_ascending = " + number(k) +
                      "\nk_descending = " + number(k * draw.between(0.8, 1.2)) + "\nsymmetry = \"none\"\n");
}

}  // namespace

std::string hysteresis(unsigned kind, Draw& draw) {
  if (kind % 3 == 0) return preisach(draw);
  return kind % 3 == 1 ? prandtl_ishlinskii(draw) : recursive_memory(draw);
}

std::string Stage::text() const {
  char line[200];
  std::snprintf(line, sizeof line,
                "%4.0f Hz, mode %.2f of it, damping %.3f, amplifier %4.0f Hz, sensor %3.0f us", rate_Hz,
                mode_Hz / rate_Hz, damping_ratio, amplifier_Hz, sensor_delay_us);
  return line;
}

Stage drawn(Draw& draw) {
  Stage stage{};
  stage.rate_Hz = 500.0 * std::floor(1.0 + 3.0 * draw.part());
  stage.mode_Hz = stage.rate_Hz * 0.1 * std::pow(25.0, draw.part());
  stage.damping_ratio = 0.01 * std::pow(10.0, draw.part());
  stage.amplifier_Hz = 300.0 * std::pow(10.0, draw.part());
  stage.sensor_delay_us = std::max(0.0, std::round(600.0 * (2.0 * draw.part() - 1.0)));
  stage.noise_um = 0.0005 * std::pow(10.0, draw.part());
  stage.creep_per_decade = 0.03 * draw.part();
  return stage;
}

std::string configured(config::TomlEdit edit, const Stage& stage, Draw& draw) {
  const double resonance_Hz = stage.mode_Hz * draw.off(), damping_ratio = stage.damping_ratio * draw.off();
  const std::string control = "axis[0].control.", delays = control + "delays.", twin = "axis[0].twin.";
  edit.comment_out(control + "notch");
  edit.set("controller.rate_Hz", number(stage.rate_Hz));
  edit.set(control + "ki_per_s",
           number(std::min(3.14159 * damping_ratio * resonance_Hz, 0.1 * stage.rate_Hz)));
  edit.set(delays + "second_order", "false");
  edit.set(delays + "command_delay_us", number(std::round(1e6 / stage.rate_Hz)));
  edit.set(delays + "amplifier_bandwidth_Hz", number(stage.amplifier_Hz * draw.off()));
  edit.set(delays + "resonance_Hz", number(resonance_Hz));
  edit.set(delays + "damping_ratio", number(damping_ratio));
  edit.set(twin + "resonance_Hz", number(stage.mode_Hz));
  edit.set(twin + "damping_ratio", number(stage.damping_ratio));
  edit.set(twin + "bandwidth_Hz", number(stage.amplifier_Hz));
  edit.set(twin + "noise_um_rms", number(stage.noise_um));
  edit.set(twin + "sensor.delay_us", number(stage.sensor_delay_us));
  edit.set(twin + "creep.per_decade", number(stage.creep_per_decade));
  edit.set(twin + "creep.from_s", "0.1");
  edit.set(twin + "creep.to_s", "100.0");
  return edit.text();
}

Seeds seeds(unsigned usual) {
  if (const char* alone = std::getenv("HYSTCAN_STAGE")) {
    const auto seed = static_cast<unsigned>(std::stoul(alone));
    return {seed, seed};
  }
  return {1, support::long_run() ? 200 : usual};
}

Errors errors_of(const config::Config& config, twin::Config stage, double resonance) {
  stage.axes[0].axis.plant.mode.natural_frequency_Hz *= resonance;
  const rehearsal::Outcome outcome = rehearsal::run_once(app::rehearsal_setup(config, stage), app::settle_s,
                                                         [](const controller::CycleRecord&) {});
  const controller::AxisOutcome& axis = outcome.axes[0];
  return {axis.statistics.total().rms_um(), outcome.true_errors[0].total().rms_um(), axis.stroke_um,
          axis.fault.cause != controller::Cause::none};
}

bool faults(const config::Config& config, const twin::Config& stage) {
  return errors_of(config, stage, 0.9).faulted || errors_of(config, stage).faulted ||
         errors_of(config, stage, 1.1).faulted;
}

void print_shares(const char* what, std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("%-40s median %.3f, 90 %% %.3f, worst %.3f\n", what, at(0.5), at(0.9), at(1.0));
}

}  // namespace hystcan::any_stage_test
