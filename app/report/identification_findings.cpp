#include "app/report/identification_findings.h"

#include <fmt/format.h>

#include <cmath>

#include "can/counted.h"

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
      say("the output hardly changes with the input's sign: the model is even, folded to |input|");
    report_steps();
    report_memories();
    report_order();
    report_k();
    report_thresholds();
    if (identified_.stopped) say("the search was stopped early: this is the best model so far");
    return std::move(findings_);
  }

 private:
  template <class... Parts>
  void say(fmt::format_string<Parts...> format, Parts&&... parts) {
    findings_.push_back(fmt::format(format, std::forward<Parts>(parts)...));
  }
  std::string of_dataset(std::size_t i) const {
    return datasets_.size() > 1 ? fmt::format("dataset {}: ", i + 1) : std::string();
  }
  const std::string& unit() const { return identified_.parameters.input_unit; }

  void describe(std::size_t i) {
    const Characterisation& is = identified_.datasets[i];
    say("{}{} over {:.4g} s, {}, {:.0f} % of the samples on minor loops; {} sampling at "
        "{:.4g} Hz",
        of_dataset(i), can::counted(is.samples, "sample"), is.duration_s, can::counted(is.cycles, "cycle"),
        100.0 * is.minor_fraction, is.uniform ? "uniform" : "uneven", 1.0 / is.sample_time_s);
    if (is.uniform && is.samples > 100)
      say("{}noise from sample to sample about {:.2g} % of the output span{}", of_dataset(i),
          is.noise * percent_,
          is.repeatability
              ? fmt::format("; repeated cycles differ by {:.2g} % RMS", *is.repeatability * percent_)
              : "; no cycle is repeated, so that the repeatability is unknown");
    if (is.rate_spread > 3.0)
      say("{}the input is {:.0f} times faster in some half cycles than in others: the model ignores the rate",
          of_dataset(i), is.rate_spread);
    if (is.cycles < 2)
      say("{}there is no whole cycle: the dataset shows only a part of a loop", of_dataset(i));
  }

  void report_trends(std::size_t i) {
    const Dataset seen =
        identified_.parameters.symmetry == model::Symmetry::even ? folded(datasets_[i]) : datasets_[i];
    const model::Hysteresis model(identified_.parameters);
    std::vector<double> residual = predict(model, seen, identified_.delay_s, identified_.memories[i]);
    for (std::size_t j = 0; j < residual.size(); ++j) residual[j] = seen.output[j] - residual[j];
    const Trends trend = trends(seen, residual);
    if (std::abs(trend.drift) * percent_ > 0.05 && std::abs(trend.drift) > 3.0 * trend.drift_error)
      say("{}the output drifts by {:+.2g} % of its span over the dataset (or creeps, or the initial memory "
          "is not of the assumed kind)",
          of_dataset(i), trend.drift * percent_);
    if (std::abs(trend.rate) > identified_.misses[i].rms && std::abs(trend.rate) * percent_ > 0.1)
      say("{}the residual depends on the input's speed, {:+.2g} % of span between fastest rise and fastest "
          "fall: measure more slowly for a quasi-static model",
          of_dataset(i), trend.rate * percent_);
  }

  void report_steps() {
    for (const Step& step : identified_.search.steps)
      say("{} was needed: error {:.3g} -> {:.3g} % RMS{}", step.what, step.rms_before * percent_,
          step.rms_after * percent_,
          step.held_out_after ? fmt::format(", of held-out cycles {:.3g} -> {:.3g} %",
                                            *step.held_out_before * percent_, *step.held_out_after * percent_)
                              : std::string());
    if (identified_.delay_s > 0.0)
      say("the output follows {:.3g} s after the input; the model file has this as delay_s",
          identified_.delay_s);
  }

  void report_memories() {
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      const InitialMemory& memory = identified_.memories[i];
      switch (memory.kind) {
        case InitialMemory::Kind::virgin:
          say("{}it begins on the ascending reference curve with an empty memory", of_dataset(i));
          break;
        case InitialMemory::Kind::from_lower:
          say("{}it begins as if the input came directly from the lower threshold", of_dataset(i));
          break;
        case InitialMemory::Kind::from_upper:
          say("{}it begins as if the input came directly from the upper threshold", of_dataset(i));
          break;
        case InitialMemory::Kind::nested:
          say("{}it begins after an unknown past, estimated as a decaying oscillation of bias {:+.2g} (0: "
              "demagnetised, above 0: more from below)",
              of_dataset(i), memory.bias);
      }
    }
  }

  void report_order() {
    if (identified_.search.orders.empty()) return;
    const bool held_out = identified_.search.orders.front().held_out.has_value();
    say("order {} is the lowest that {} accepts", identified_.search.order,
        held_out ? "the error of held-out cycles" : "the error (there are too few cycles to hold any out)");
  }

  void report_k() {
    if (identified_.search.one_k)
      say("rising and falling branches have the same k: two values would not fit better");
    const auto report = [&](const char* name, double k, const PaceRange& range) {
      if (range.is_fixed)
        say("{} = {:.5g} 1/{}; {:.5g} to {:.5g} would do as well (within 5 % of the error)", name, k, unit(),
            range.lo, range.hi);
      else
        say("{} = {:.5g} 1/{}, but the dataset hardly determines it: {:.3g} to {:.3g} would do as well; "
            "minor loops that turn inside the range would determine it",
            name, k, unit(), range.lo, range.hi);
    };
    report("k_ascending", identified_.parameters.k_ascending, identified_.pace_ascending);
    report("k_descending", identified_.parameters.k_descending, identified_.pace_descending);
  }

  void report_thresholds() {
    const model::Interval& range = identified_.parameters.input_range();
    if (range.lo == identified_.observed.lo && range.hi == identified_.observed.hi) return;
    say("thresholds {:.5g} and {:.5g} {} lie beyond the measured inputs, {:.5g} to {:.5g}: outside those the "
        "curves are extrapolated, to {:.5g} and {:.5g} {}. A controller can reach its thresholds only if the "
        "drive may go there; otherwise identify with --thresholds observed",
        range.lo, range.hi, unit(), identified_.observed.lo, identified_.observed.hi,
        identified_.parameters.ascending.value(range.lo), identified_.parameters.ascending.value(range.hi),
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
