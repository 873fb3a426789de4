#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "app/stage/dynamics_text.h"
#include "app/stage/pictures.h"
#include "app/stage/tuning_report.h"
#include "base/error.h"
#include "base/output_file.h"
#include "controller/analysis/linear_loop.h"
#include "identification/dynamics/empirical_response.h"

namespace hystcan::app {
namespace {

using Complex = std::complex<double>;

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// Returns the phase of `value` in degrees without jumps of 360 degrees. `phase`: the phase in radians at the
/// next lower frequency; the function replaces it by the phase of `value`.
double next_degrees(double& phase, const Complex& value) {
  phase += std::arg(value / std::polar(1.0, phase));
  return degrees(phase);
}

controller::Delays without_commands(controller::Delays delays) {
  delays.command_delay = {};
  return delays;
}

double angle(double frequency_Hz, double cycle_s) { return 2.0 * std::numbers::pi * frequency_Hz * cycle_s; }

/// Returns the loop of a candidate with the identified plant, to compute its frequency response. The delays
/// of the candidate belong to its feed-forward, and may differ from the plant.
controller::LoopConfig loop_of(const TuningReport& report, const Candidate& of) {
  controller::LoopConfig loop = of.loop;
  loop.delays = report.plant.delays;
  return loop;
}

/// Computes the frequency responses of the identified plant (at the rate of the record) and of the present
/// and the proposed loop (at the cycle rate). Must be called with increasing frequencies, because it stores
/// the phases of the previous frequency.
class Curves {
 public:
  explicit Curves(const TuningReport& of)
      : of_(of),
        model_(controller::held_plant(without_commands(of.plant.delays), of.plant.cycle_s)),
        before_(loop_of(of, of.present())),
        after_(loop_of(of, of.proposed())) {}

  struct Values {
    Complex model, before, after;
    double model_deg, before_deg, after_deg;
  };
  Values at(double frequency_Hz) {
    const double theta = angle(frequency_Hz, after_.config().cycle_s);
    Values v{.model = controller::response_of(model_, angle(frequency_Hz, of_.plant.cycle_s)),
             .before = before_(of_.present().loop.pi, theta),
             .after = after_(of_.proposed().loop.pi, theta),
             .model_deg = 0.0,
             .before_deg = 0.0,
             .after_deg = 0.0};
    v.model_deg = next_degrees(model_phase_, v.model);
    v.before_deg = next_degrees(before_phase_, v.before);
    v.after_deg = next_degrees(after_phase_, v.after);
    return v;
  }

 private:
  const TuningReport& of_;
  controller::PlantRecursion::Config model_;
  controller::LinearLoop before_, after_;
  double model_phase_ = 0.0, before_phase_ = 0.0, after_phase_ = 0.0;
};

double sensitivity(const Complex& loop) { return 1.0 / std::abs(1.0 + loop); }

/// Returns the phase of a measured response in degrees. It is within 180 degrees of the model's phase.
double phase_deg(const Complex& measured, const Curves::Values& v) {
  return v.model_deg + degrees(std::arg(measured / v.model));
}

/// Returns the last columns of a row: the computed responses at one frequency.
std::string fields_of(const Curves::Values& v) {
  return fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n", std::abs(v.model),
                     v.model_deg, std::abs(v.before), v.before_deg, std::abs(v.after), v.after_deg,
                     sensitivity(v.before), sensitivity(v.after));
}

/// Returns rows at frequencies at which nothing was measured; their columns for measured values are empty.
std::string curves_of(const TuningReport& report) {
  std::string rows;
  Curves curves(report);
  const controller::LoopConfig loop = loop_of(report, report.proposed());
  for (const double theta : controller::frequencies_for(loop, 0.3)) {
    const double frequency_Hz = theta / angle(1.0, loop.cycle_s);
    rows += fmt::format("{:.7g},,,,", frequency_Hz) + fields_of(curves.at(frequency_Hz));
  }
  return rows;
}

}  // namespace

std::string response_table(const TuningReport& report, const identification::Dataset& record) {
  std::string rows =
      "frequency_Hz,measured_gain,measured_phase_deg,coherence,model_gain,model_phase_deg,before_gain,"
      "before_phase_deg,after_gain,after_phase_deg,before_sensitivity,after_sensitivity\n";
  Curves curves(report);
  for (const identification::ResponsePoint& point : identification::empirical_response(record)) {
    const Curves::Values v = curves.at(point.frequency_Hz);
    const Complex measured = point.response / report.plant.gain;
    rows += fmt::format("{:.7g},{:.6g},{:.6g},{:.4f},", point.frequency_Hz, std::abs(measured),
                        phase_deg(measured, v), point.coherence) +
            fields_of(v);
  }
  return rows;
}

void require_picture(const std::filesystem::path& picture) {
  if (picture.extension() != ".svg" && picture.extension() != ".png")
    throw Error(picture, "expected a name that ends with .svg or .png");
}

std::optional<std::string> draw_response(const TuningReport& report, const identification::Dataset& record,
                                         const std::filesystem::path& picture) {
  std::filesystem::path data = picture, list = picture;
  data.replace_extension(".data.csv");
  list.replace_extension(".json");
  write_file(data, response_table(report, record) + curves_of(report));
  return draw_pictures(list, {{.kind = "response",
                               .data = {data.filename().string()},
                               .to = {picture.filename().string()},
                               .size = {.width_mm = 190.0, .height_mm = 210.0},
                               .facts = {{"title", fmt::format("axis {} of {}: {}", report.axis,
                                                               report.config, report.proposed().name)}}}});
}

}  // namespace hystcan::app
