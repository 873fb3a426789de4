#include "app/report/identification_findings.h"

#include <fmt/format.h>

#include <cmath>

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
      look_for_trends(i);
    }
    if (identified_.parameters.symmetry == model::Symmetry::even)
      say("the output hardly changes with the input's sign: the model is even, folded to |input|");
    tell_steps();
    tell_memories();
    tell_orders();
    tell_k();
    tell_thresholds();
    if (identified_.stopped) say("stopped before the search was over: the best so far");
    return std::move(findings_);
  }

 private:
  template <class... Parts>
  void say(fmt::format_string<Parts...> format, Parts&&... parts) {
    findings_.push_back(fmt::format(format, std::forward<Parts>(parts)...));
  }
  std::string of_record(std::size_t i) const {
    return datasets_.size() > 1 ? fmt::format("record {}: ", i + 1) : std::string();
  }
  const std::string& unit() const { return identified_.parameters.input_unit; }

  void describe(std::size_t i) {
    const Characterisation& is = identified_.datasets[i];
    say("{}{} samples over {:.4g} s, {} cycles, {:.0f} % of the samples on minor loops; {} sampling at "
        "{:.4g} Hz",
        of_record(i), is.samples, is.duration_s, is.cycles, 100.0 * is.minor_fraction,
        is.uniform ? "uniform" : "uneven", 1.0 / is.sample_time_s);
    if (is.uniform && is.samples > 100)
      say("{}noise from sample to sample about {:.2g} % of the output span{}", of_record(i),
          is.noise * percent_,
          is.repeatability
              ? fmt::format("; repeated cycles differ by {:.2g} % RMS", *is.repeatability * percent_)
              : "; no cycle is repeated, so that repeatability can't be told");
    if (is.rate_spread > 3.0)
      say("{}the input is {:.0f} times faster in some half cycles than in others: the model knows no rate",
          of_record(i), is.rate_spread);
    if (is.cycles < 2) say("{}not one whole cycle: only part of a loop is seen", of_record(i));
  }

  void look_for_trends(std::size_t i) {
    const Dataset seen =
        identified_.parameters.symmetry == model::Symmetry::even ? folded(datasets_[i]) : datasets_[i];
    const model::Hysteresis model(identified_.parameters);
    std::vector<double> residual = predict(model, seen, identified_.delay_s, identified_.memories[i]);
    for (std::size_t j = 0; j < residual.size(); ++j) residual[j] = seen.output[j] - residual[j];
    const Trends trend = trends(seen, residual);
    if (std::abs(trend.drift) * percent_ > 0.05 && std::abs(trend.drift) > 3.0 * trend.drift_error)
      say("{}the output drifts by {:+.2g} % of its span over the record (or creeps, or the initial memory is "
          "not of the "
          "kind assumed)",
          of_record(i), trend.drift * percent_);
    if (std::abs(trend.rate) > identified_.misses[i].rms && std::abs(trend.rate) * percent_ > 0.1)
      say("{}what is left depends on the input's speed, {:+.2g} % of span between fastest rise and fastest "
          "fall: "
          "record more slowly for a quasi-static model",
          of_record(i), trend.rate * percent_);
  }

  void tell_steps() {
    for (const Step& step : identified_.search.steps)
      say("{} was needed: error {:.3g} -> {:.3g} % RMS{}", step.what, step.rms_before * percent_,
          step.rms_after * percent_,
          step.held_out_after ? fmt::format(", of held-out cycles {:.3g} -> {:.3g} %",
                                            *step.held_out_before * percent_, *step.held_out_after * percent_)
                              : std::string());
    if (identified_.delay_s > 0.0)
      say("the output follows {:.3g} s behind the input; kept beside the model as delay_s",
          identified_.delay_s);
  }

  void tell_memories() {
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      const InitialMemory& memory = identified_.memories[i];
      switch (memory.kind) {
        case InitialMemory::Kind::virgin:
          say("{}it begins on the ascending reference curve, nothing remembered", of_record(i));
          break;
        case InitialMemory::Kind::from_lower:
          say("{}it begins as if come straight from the lower threshold", of_record(i));
          break;
        case InitialMemory::Kind::from_upper:
          say("{}it begins as if come straight from the upper threshold", of_record(i));
          break;
        case InitialMemory::Kind::nested:
          say("{}it begins after an unknown past, estimated as a decaying oscillation of bias {:+.2g} (0: "
              "demagnetised, above: come more from below)",
              of_record(i), memory.bias);
      }
    }
  }

  void tell_orders() {
    if (identified_.search.orders.empty()) return;
    const bool held_out = identified_.search.orders.front().held_out.has_value();
    say("order {} is the lowest that {} content with", identified_.search.order,
        held_out ? "held-out cycles are" : "the error is (too few cycles to hold any out)");
  }

  void tell_k() {
    if (identified_.search.one_k) say("one k serves rising and falling branches: two would fit no better");
    const auto tell = [&](const char* name, double k, const PaceRange& range) {
      if (range.is_fixed)
        say("{} = {:.5g} 1/{}; {:.5g} to {:.5g} would do as well (within 5 % of the error)", name, k, unit(),
            range.lo, range.hi);
      else
        say("{} = {:.5g} 1/{}, but the record hardly fixes it: {:.3g} to {:.3g} would do as well; minor "
            "loops that turn "
            "inside the range would fix it",
            name, k, unit(), range.lo, range.hi);
    };
    tell("k_ascending", identified_.parameters.k_ascending, identified_.pace_ascending);
    tell("k_descending", identified_.parameters.k_descending, identified_.pace_descending);
  }

  void tell_thresholds() {
    const model::Interval& range = identified_.parameters.input_range();
    if (range.lo == identified_.observed.lo && range.hi == identified_.observed.hi) return;
    say("thresholds {:.5g} and {:.5g} {} lie beyond the inputs seen, {:.5g} to {:.5g}: outside those the "
        "curves are extrapolated, to {:.5g} and {:.5g} {}. A controller can reach its thresholds only if the "
        "drive may go there; else identify with --thresholds observed",
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
