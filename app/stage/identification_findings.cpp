#include "app/stage/identification_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "identification/ascending_choice.h"

namespace hystcan::app {
namespace {

using namespace identification;

class Findings {
 public:
  Findings(const std::vector<Dataset>& datasets, const Identified& identified)
      : datasets_(datasets), identified_(identified), percent_(100.0 / identified.output_span) {}

  std::vector<std::string> all() {
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      describe(i);
      report_trends(i);
    }
    if (identified_.parameters.symmetry == model::Symmetry::even)
      add_finding(
          "the output hardly changes with the input's sign: the model is even and depends on |input| only");
    if (identified_.parameters.output_map)
      add_finding(
          "the output has a valley on each side of zero input: "
          "the model is a butterfly with an output map; a controller uses only outputs above the valleys, "
          "from {:.5g} {} upwards",
          identified_.parameters.output_range().lo, datasets_.front().output_unit);
    report_zeros();
    report_steps();
    report_creep();
    report_delay();
    report_left_out();
    report_dynamics();
    report_memories();
    report_order();
    report_k();
    report_thresholds();
    if (identified_.stopped) add_finding("the search was stopped early: this is the best model so far");
    return std::move(findings_);
  }

 private:
  template <class... Parts>
  void add_finding(fmt::format_string<Parts...> format, Parts&&... parts) {
    findings_.push_back(fmt::format(format, std::forward<Parts>(parts)...));
  }
  std::string of_dataset(std::size_t i) const {
    return datasets_.size() > 1 ? fmt::format("dataset {}: ", i + 1) : std::string();
  }
  const std::string& unit() const { return identified_.parameters.input_unit; }
  const char* held_out() const {
    return identified_.left_out.empty() ? "held-out cycles" : "held-out records";
  }

  void describe(std::size_t i) {
    const Characterisation& is = identified_.datasets[i];
    add_finding("{}{} over {:.4g} s, {}, {:.0f} % of the samples on minor loops; {} sampling at {:.4g} Hz",
                of_dataset(i), counted(is.samples, "sample"), is.duration_s, counted(is.cycles, "cycle"),
                100.0 * is.minor_fraction, is.uniform ? "uniform" : "uneven", 1.0 / is.sample_time_s);
    if (is.uniform && is.samples > 100)
      add_finding("{}the noise from sample to sample is about {:.2g} % of the output span{}", of_dataset(i),
                  is.noise * percent_,
                  is.repeatability
                      ? fmt::format("; repeated cycles differ by {:.2g} % RMS", *is.repeatability * percent_)
                      : "; no cycle is repeated, so the repeatability is unknown");
    if (is.rate_spread > 3.0)
      add_finding("{}the input is {:.0f} times faster in some half cycles than in others{}", of_dataset(i),
                  is.rate_spread,
                  identified_.creep || identified_.dynamics ? "" : ": the model ignores the rate");
    if (is.cycles < 2)
      add_finding("{}the dataset has no complete cycle: it shows only part of a loop", of_dataset(i));
  }

  void report_trends(std::size_t i) {
    const Dataset seen =
        identified_.parameters.symmetry == model::Symmetry::even ? folded(datasets_[i]) : datasets_[i];
    const Trends trend = trends(seen, predict(identified_, datasets_, i));
    if (datasets_.size() > 1 && std::abs(trend.gain) * percent_ > 0.1)
      add_finding(
          "{}the output range differs from the range of the model by {:+.2g} % of the span: "
          "the remaining error is a gain error",
          of_dataset(i), trend.gain * percent_);
    if (std::abs(trend.drift) * percent_ > 0.05 && std::abs(trend.drift) > 3.0 * trend.drift_error)
      add_finding(
          "{}the output drifts by {:+.2g} % of its span over the dataset "
          "(possible causes: a drift of the sensor, creep, or a wrong initial memory)",
          of_dataset(i), trend.drift * percent_);
    if (std::abs(trend.rate) > identified_.errors[i].rms && std::abs(trend.rate) * percent_ > 0.1)
      add_finding(
          "{}the residual changes by {:+.2g} % of the span from the fastest fall of the input "
          "to its fastest rise: measure more slowly for a quasi-static model",
          of_dataset(i), trend.rate * percent_);
  }

  void report_steps() {
    for (const Step& step : identified_.search.steps)
      add_finding("{} was needed: the error fell from {:.3g} to {:.3g} % RMS{}", to_string(step.quantity),
                  step.rms_before * percent_, step.rms_after * percent_,
                  step.held_out_after
                      ? fmt::format(", {} {:.3g} -> {:.3g} %", held_out(), *step.held_out_before * percent_,
                                    *step.held_out_after * percent_)
                      : std::string());
  }

  void report_zeros() {
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      if (identified_.offsets[i] != 0.0)
        add_finding(
            "{}the zero differs by {:+.4g} {} from dataset 1: each dataset has its own zero "
            "(--common-zero: one zero for all datasets)",
            of_dataset(i), identified_.offsets[i], datasets_.front().output_unit);
      if (identified_.gains[i] != 1.0)
        add_finding(
            "{}the output moves {:.4g} times as far as in dataset 1: "
            "the gain of amplifier or sensor differs; "
            "the model has the gain of dataset 1 (--common-gain fits one gain to all datasets)",
            of_dataset(i), identified_.gains[i]);
      if (identified_.drifts[i] != 0.0)
        add_finding("{}the zero drifts by {:+.3g} {} from start to end", of_dataset(i), identified_.drifts[i],
                    datasets_.front().output_unit);
    }
  }

  void report_creep() {
    if (identified_.creep) {
      const model::OutputCreep::Config& creep = *identified_.creep;
      const model::OutputCreep response(creep);
      add_finding(
          "the output creeps by {:.2g} % of its travel per decade of time, from {:.3g} to {:.3g} s{}: "
          "at 0.1 Hz the output moves {:.2g} % more than at 10 Hz; stored as [creep] in the model file",
          100.0 * creep.per_decade, creep.from_s, creep.to_s,
          identified_.creep_range
              ? fmt::format(" ({:.2g} to {:.2g} % fit nearly as well)", 100.0 * identified_.creep_range->lo,
                            100.0 * identified_.creep_range->hi)
              : std::string(),
          100.0 * (response.amplitude_at(0.1) / response.amplitude_at(10.0) - 1.0));
    }
    report_gains_instead();
    if (!identified_.alternative || identified_.alternative->trial.creep_per_decade == 0.0) return;
    const SearchResult& alternative = *identified_.alternative;
    const auto error = [&](const SearchResult& result) {
      return percent_ * result.held_out.value_or(result.rms);
    };
    add_finding(
        "with a creep of {:.2g} % per decade of time and a delay of {:.3g} s instead of {:.3g} s, "
        "the error of {} is {:.3g} % instead of {:.3g} %{}",
        100.0 * alternative.trial.creep_per_decade, alternative.trial.delay_s, identified_.delay_s,
        held_out(), error(alternative), error(identified_.search),
        datasets_.size() > 1
            ? std::string()
            : ": a record at a single rate hardly distinguishes creep from a delay and a wider loop; "
              "add a record at another rate, or set --creep");
  }

  void report_gains_instead() {
    if (!identified_.gains_instead) return;
    const GainsInstead& instead = *identified_.gains_instead;
    std::string gains;
    for (std::size_t i = 1; i < datasets_.size(); ++i)
      gains += fmt::format("{}{:.5g} for dataset {}", i > 1 ? ", " : "", instead.gains[i], i + 1);
    add_finding(
        "the creep of the model may be a difference in gain between the sessions (amplifier, sensor): "
        "a model without creep and with a gain of {} fits as well, with an error of {:.3g} % RMS "
        "instead of {:.3g} %; "
        "record all rates in one session, or set --creep",
        gains, instead.rms * percent_, instead.rms_with_creep * percent_);
  }

  void report_left_out() {
    for (std::size_t i = 0; i < identified_.left_out.size(); ++i) {
      const LeftOut& part = identified_.left_out[i];
      if (part.samples == 0.0) continue;
      const double more = 100.0 * (part.gain - 1.0);
      add_finding("{}the other records predict this record with an error of {:.3g} % RMS{}", of_dataset(i),
                  part.rms() * percent_,
                  std::abs(more) > 0.2 ? fmt::format("; the output moves {:.2g} % {} than predicted",
                                                     std::abs(more), more > 0.0 ? "more" : "less")
                                       : std::string());
    }
  }

  void report_delay() {
    if (identified_.delay_s > 0.0)
      add_finding("the output follows the input after {:.3g} s; stored as delay_s in the model file",
                  identified_.delay_s);
    if (!identified_.delay_range) return;
    const DelayRange& range = *identified_.delay_range;
    if (range.hi_s <= 0.0) return;
    const double twice = range.at_twice_the_rate * percent_, five = range.at_five_times_the_rate * percent_;
    add_finding(
        "delays from {:.3g} to {:.3g} s fit nearly as well, "
        "but their predictions differ by {:.2g} % of the span "
        "for inputs twice as fast as the measured inputs, "
        "and by {:.2g} % for inputs five times as fast{}",
        range.lo_s, range.hi_s, twice, five,
        datasets_.size() == 1 && five > 2.0 * identified_.overall.rms * percent_
            ? ": a record at a single rate hardly distinguishes a delay from a wider loop; "
              "add a record at another rate, or set --delay"
            : "");
  }

  void report_dynamics() {
    if (!identified_.dynamics) return;
    const model::Dynamics& dynamics = *identified_.dynamics;
    add_finding(
        "the hysteresis is followed by a mode at {:.5g} Hz with a damping ratio of {:.3g}, "
        "and by a delay of {:.4g} s; stored as [dynamics] in the model file",
        dynamics.mode.natural_frequency_Hz, dynamics.mode.damping_ratio, dynamics.delay_s);
  }

  void report_memories() {
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      const InitialMemory& memory = identified_.memories[i];
      switch (memory.kind) {
        case InitialMemory::Kind::virgin:
          add_finding("{}the dataset starts on the ascending reference curve with an empty memory",
                      of_dataset(i));
          break;
        case InitialMemory::Kind::from_lower:
          add_finding("{}the dataset starts as if the input had come directly from the lower threshold",
                      of_dataset(i));
          break;
        case InitialMemory::Kind::from_upper:
          add_finding("{}the dataset starts as if the input had come directly from the upper threshold",
                      of_dataset(i));
          break;
        case InitialMemory::Kind::nested:
          add_finding(
              "{}the dataset starts after an unknown history, "
              "estimated as a decaying oscillation with bias {:+.2g} "
              "(0: demagnetised, above 0: the input came rather from the lower threshold)",
              of_dataset(i), memory.bias);
      }
    }
    if (shows_ascending_curve(identified_.memories)) return;
    if (begins_at_lower_point(identified_.parameters))
      add_finding(
          "no row shows a first rise with an empty memory, "
          "so the ascending reference curve is chosen, not measured: "
          "it is the branch that rises from the lower end of the major loop");
    else
      add_finding(
          "no row shows a first rise with an empty memory: "
          "the ascending reference curve is not measured near {:g} {}",
          identified_.parameters.input_range().lo, unit());
  }

  void report_order() {
    const auto& shapes = identified_.search.shapes;
    if (shapes.empty()) return;
    const CurveShape& chosen = identified_.search.shape;
    const std::string judge = shapes.front().held_out ? fmt::format("the error of {}", held_out())
                                                      : "the error (too few cycles to hold out a cycle)";
    if (!chosen.is_spline()) {
      add_finding("order {} is the lowest order that is at most 1 % worse than the best order, judged by {}",
                  chosen.order, judge);
      return;
    }
    const auto error = [](const ShapeScore& tried) { return tried.held_out.value_or(tried.rms); };
    double polynomial = std::numeric_limits<double>::infinity();
    for (const ShapeScore& tried : shapes)
      if (!tried.shape.is_spline()) polynomial = std::min(polynomial, error(tried));
    add_finding(
        "the curves are splines of {} pieces instead of the best polynomial, "
        "which has an error of {:.3g} %, judged by {}",
        chosen.knots.size() - 1, polynomial * percent_, judge);
  }

  void report_k() {
    if (identified_.search.one_k)
      add_finding("rising and falling branches have the same k: two values do not fit better");
    const auto report = [&](const char* name, double k, model::Interval range) {
      if (identified_.stopped)
        add_finding("{} = {:.5g} 1/{}", name, k, unit());
      else if (is_determined(range))
        add_finding("{} = {:.5g} 1/{}; {:.5g} to {:.5g} fit as well (error at most 5 % larger)", name, k,
                    unit(), range.lo, range.hi);
      else
        add_finding(
            "{} = {:.5g} 1/{}, but the dataset hardly determines this value: {:.3g} to {:.3g} fit as well; "
            "record minor loops that turn inside the range",
            name, k, unit(), range.lo, range.hi);
    };
    report("k_ascending", identified_.parameters.k_ascending, identified_.pace_ascending);
    report("k_descending", identified_.parameters.k_descending, identified_.pace_descending);
  }

  void report_thresholds() {
    const model::Interval& range = identified_.parameters.input_range();
    if (range.lo == identified_.observed.lo && range.hi == identified_.observed.hi) return;
    add_finding(
        "thresholds {:.5g} and {:.5g} {} are beyond the measured inputs, {:.5g} to {:.5g}; "
        "there the curves are extrapolated, to {:.5g} and {:.5g} {}. "
        "A controller must reach the upper threshold, which erases the memory of the actuator; "
        "--thresholds observed sets both thresholds to the ends of the measured inputs",
        range.lo, range.hi, unit(), identified_.observed.lo, identified_.observed.hi,
        identified_.parameters.output(identified_.parameters.ascending.value(range.lo)),
        identified_.parameters.output(identified_.parameters.ascending.value(range.hi)),
        datasets_.front().output_unit);
  }

  const std::vector<Dataset>& datasets_;
  const Identified& identified_;
  double percent_;
  std::vector<std::string> findings_;
};

}  // namespace

std::vector<std::string> findings(const std::vector<Dataset>& datasets, const Identified& identified) {
  return Findings(datasets, identified).all();
}

}  // namespace hystcan::app
