#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "app/stage/dynamics_text.h"
#include "app/stage/gnuplot.h"
#include "app/stage/tuning_report.h"
#include "base/error.h"
#include "controller/analysis/linear_loop.h"
#include "identification/dynamics/empirical_response.h"

namespace hystcan::app {
namespace {

using Complex = std::complex<double>;

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// Phase without leaps along ascending frequencies: `phase` is that of the frequency before.
double next_degrees(double& phase, const Complex& value) {
  phase += std::arg(value / std::polar(1.0, phase));
  return degrees(phase);
}

controller::Delays without_commands(controller::Delays delays) {
  delays.command_delay = {};
  return delays;
}

double angle(double frequency_Hz, double cycle_s) { return 2.0 * std::numbers::pi * frequency_Hz * cycle_s; }

/// With the plant that was found.
controller::LoopConfig loop_of(const TuningReport& report, const Candidate& of) {
  controller::LoopConfig loop = of.loop;
  loop.delays = report.plant.delays;
  return loop;
}

/// What belongs to a frequency, with its memory of the frequency before: the plant at the rate of the record,
/// and the loops present and proposed at theirs.
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

/// Of a measured response, near the model's.
double phase_deg(const Complex& measured, const Curves::Values& v) {
  return v.model_deg + degrees(std::arg(measured / v.model));
}

std::string curves_of(const TuningReport& report) {
  fmt::memory_buffer text;
  Curves curves(report);
  const controller::LoopConfig loop = loop_of(report, report.proposed());
  for (const double theta : controller::frequencies_for(loop, 0.3)) {
    const double frequency_Hz = theta / angle(1.0, loop.cycle_s);
    const Curves::Values v = curves.at(frequency_Hz);
    fmt::format_to(std::back_inserter(text), "{:.7g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g}\n",
                   frequency_Hz, decibel(std::abs(v.model)), v.model_deg, decibel(std::abs(v.before)),
                   decibel(std::abs(v.after)), decibel(sensitivity(v.before)), decibel(sensitivity(v.after)));
  }
  return fmt::to_string(text);
}

std::string points_of(const TuningReport& report, const identification::Dataset& record) {
  fmt::memory_buffer text;
  Curves curves(report);
  for (const identification::ResponsePoint& point : identification::empirical_response(record)) {
    const Complex measured = point.response / report.plant.gain;
    const Curves::Values v = curves.at(point.frequency_Hz);
    fmt::format_to(std::back_inserter(text), "{:.7g} {:.5g} {:.5g} {:.4f}\n", point.frequency_Hz,
                   decibel(std::abs(measured)), phase_deg(measured, v), point.coherence);
  }
  return fmt::to_string(text);
}

constexpr const char* panels = R"(
set multiplot layout 3,1 title title_text
set logscale x
set xrange [0.5:*]
set border 3 lw 0.6
set tics nomirror out scale 0.6
set grid lw 0.4 lc rgb '#dddddd'
set key outside right
set cbrange [0:1]
set palette defined (0 '#d0d0d0', 1 '#0072b2')
set cblabel 'coherence'
set ylabel 'plant, gain [dB]'
plot $measured using 1:2:4 with points pt 7 ps 0.4 palette title 'measured', $curves using 1:2 with lines lc rgb '#d55e00' title 'model'
set ylabel 'plant, phase [deg]'
plot $measured using 1:3:4 with points pt 7 ps 0.4 palette title 'measured', $curves using 1:3 with lines lc rgb '#d55e00' title 'model'
set ylabel 'loop, gain [dB]'
set xlabel 'frequency [Hz]'
plot $curves using 1:4 with lines lc rgb '#7f7f7f' title 'L before', $curves using 1:5 with lines lc rgb '#0072b2' title 'L after', $curves using 1:6 with lines dt 2 lc rgb '#7f7f7f' title '1/(1+L) before', $curves using 1:7 with lines dt 2 lc rgb '#0072b2' title '1/(1+L) after'
unset multiplot
)";

}  // namespace

std::string response_table(const TuningReport& report, const identification::Dataset& record) {
  fmt::memory_buffer text;
  fmt::format_to(
      std::back_inserter(text),
      "frequency_Hz,measured_gain,measured_phase_deg,coherence,model_gain,model_phase_deg,before_gain,"
      "before_phase_deg,after_gain,after_phase_deg,before_sensitivity,after_sensitivity\n");
  Curves curves(report);
  for (const identification::ResponsePoint& point : identification::empirical_response(record)) {
    const Curves::Values v = curves.at(point.frequency_Hz);
    const Complex measured = point.response / report.plant.gain;
    fmt::format_to(std::back_inserter(text),
                   "{:.7g},{:.6g},{:.6g},{:.4f},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n",
                   point.frequency_Hz, std::abs(measured), phase_deg(measured, v), point.coherence,
                   std::abs(v.model), v.model_deg, std::abs(v.before), v.before_deg, std::abs(v.after),
                   v.after_deg, sensitivity(v.before), sensitivity(v.after));
  }
  return fmt::to_string(text);
}

void require_picture(const std::filesystem::path& picture) {
  if (picture.extension() != ".svg" && picture.extension() != ".png")
    throw Error(fmt::format("{}: expected a name that ends with .svg or .png", picture.string()));
}

std::optional<std::string> draw_response(const TuningReport& report, const identification::Dataset& record,
                                         const std::filesystem::path& picture) {
  const bool is_png = picture.extension() == ".png";
  const std::string title =
      fmt::format("axis {} of {}: {}", report.axis, report.config, report.proposed().name);
  const std::string script =
      fmt::format(
          "set terminal {} size 900,1000\nset output {}\ntitle_text = {}\n$measured << EOD\n{}EOD\n$curves "
          "<< EOD\n{}EOD\n",
          is_png ? "pngcairo enhanced" : "svg enhanced", gnuplot_file(picture.filename().string()),
          gnuplot_text(title), points_of(report, record), curves_of(report)) +
      panels;
  const std::filesystem::path folder = picture.parent_path();
  std::filesystem::path name = picture.filename();
  return draw_with_gnuplot(folder.empty() ? "." : folder, name.replace_extension(".gnuplot").string(),
                           {is_png ? "png" : "svg"}, script);
}

}  // namespace hystcan::app
