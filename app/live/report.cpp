#include "app/live/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/text.h"

namespace hystcan::app {
namespace {

/// Returns the error statistics as JSON. Without samples, the errors are null.
nlohmann::json error_to_json(const controller::ErrorStatistics& error, double stroke_um) {
  const auto measured = [&](double value) { return error.samples > 0 ? nlohmann::json(value) : nullptr; };
  return {{"samples", error.samples},
          {"rms_um", measured(error.rms_um())},
          {"max_um", measured(error.max_um)},
          {"rms_percent", measured(100.0 * error.rms_um() / stroke_um)},
          {"max_percent", measured(100.0 * error.max_um / stroke_um)}};
}

/// Adds the error relative to the reference with sharp corners, if it differs from the error relative to the
/// actual reference. They differ if the controller rounds the corners of the reference.
void add_ideal(nlohmann::json& object, const controller::ErrorStatistics& error,
               const controller::ErrorStatistics& against_ideal, double stroke_um) {
  if (against_ideal.sum_of_squares != error.sum_of_squares)
    object["against_ideal"] = error_to_json(against_ideal, stroke_um);
}

/// Returns the figures of a segment with constant levels: settling time and overshoot of its steps, and the
/// noise at rest. Returns an empty object if the segment has no levels.
nlohmann::json levels_to_json(const controller::LevelStatistics& levels, double band_um) {
  nlohmann::json object = nlohmann::json::object();
  if (const metrics::StepResponse::Result steps = levels.steps.result(); steps.steps > 0) {
    object["steps"] = {{"count", steps.steps},
                       {"not_settled", steps.not_settled},
                       {"settling_s", nullptr},
                       {"overshoot_percent", 100.0 * steps.overshoot}};
    if (steps.not_settled < steps.steps) object["steps"]["settling_s"] = steps.settling_s;
    object["steps"][band_um > 0.0 ? "band_um" : "band_percent"] = band_um > 0.0 ? band_um : 1.0;
  }
  if (levels.hold.samples() > 0)
    object["hold"] = {{"samples", levels.hold.samples()}, {"noise_um_rms", levels.hold.rms_um()}};
  return object;
}

std::string describe_steps(const metrics::StepResponse::Result& steps, double band_um) {
  const std::string band = band_um > 0.0 ? fmt::format("{:g} um", band_um) : "1 % of the step";
  std::string text = fmt::format("; {}: ", counted(steps.steps, "step"));
  if (steps.not_settled < steps.steps)
    text += fmt::format("settled to {} within {:.4g} s, ", band, steps.settling_s);
  if (steps.not_settled > 0)
    text += fmt::format("{} did not settle to {}, ", counted(steps.not_settled, "step"), band);
  return text + fmt::format("overshoot {:.2f} % of the step", 100.0 * steps.overshoot);
}

std::string segment_kind(const controller::AxisOutcome& outcome, std::size_t segment) {
  return segment < outcome.segment_kinds.size() ? outcome.segment_kinds[segment] : "former setpoint";
}

}  // namespace

nlohmann::json to_json(const controller::TrackingStatistics& statistics, double stroke_um) {
  nlohmann::json object = error_to_json(statistics.total(), stroke_um);
  add_ideal(object, statistics.total(), statistics.total_against_ideal(), stroke_um);
  object["segments"] = nlohmann::json::array();
  for (std::size_t i = 0; i < statistics.segments().size(); ++i) {
    const controller::ErrorStatistics& error = statistics.segments()[i];
    nlohmann::json segment = error_to_json(error, stroke_um);
    add_ideal(segment, error, statistics.against_ideal()[i], stroke_um);
    object["segments"].push_back(std::move(segment));
  }
  return object;
}

nlohmann::json to_json(const controller::AxisOutcome& outcome) {
  nlohmann::json object = to_json(outcome.statistics, outcome.stroke_um);
  object["name"] = outcome.name;
  object["stroke_um"] = outcome.stroke_um;
  object["state"] = to_string(outcome.state);
  object["fault"] = to_string(outcome.fault.cause);
  const controller::TrackingStatistics& statistics = outcome.statistics;
  for (std::size_t i = 0; i < statistics.levels().size(); ++i) {
    object["segments"][i]["kind"] = segment_kind(outcome, i);
    object["segments"][i].update(levels_to_json(statistics.levels()[i], statistics.tolerance_um()));
  }
  return object;
}

nlohmann::json to_json(const can::BusReport& report) {
  nlohmann::json object{{"state", to_string(report.state)},
                        {"sent", report.counters.sent},
                        {"received", report.counters.received},
                        {"error_counters", nullptr}};
  for (const can::BusTrouble& trouble : can::bus_troubles())
    object[std::string(trouble.key)] = report.counters.*trouble.count;
  if (report.error_counters)
    object["error_counters"] = {{"transmit", report.error_counters->transmit},
                                {"receive", report.error_counters->receive}};
  return object;
}

nlohmann::json to_json(const can::RejectedFrames& rejected) {
  nlohmann::json object;
  for (std::size_t i = 0; i < can::rejection_count; ++i) {
    std::string key(to_string(static_cast<can::Rejection>(i)));
    std::ranges::replace(key, ' ', '_');
    object[key] = rejected.by_cause[i];
  }
  return object;
}

std::vector<std::string> describe(const BusClosing& closing) {
  std::vector<std::string> lines = closing.events;
  if (closing.events_truncated > 0)
    lines.push_back(fmt::format("{} events are not shown, because there were too many kinds of events",
                                closing.events_truncated));
  lines.push_back(describe(closing.bus));
  for (const can::RejectedFrames& rejected : closing.rejected)
    if (std::string line = describe(rejected); !line.empty()) lines.push_back(std::move(line));
  return lines;
}

nlohmann::json to_json(const BusClosing& closing) {
  nlohmann::json object = to_json(closing.bus);
  object["rejected"] = nlohmann::json::object();
  for (const can::RejectedFrames& rejected : closing.rejected)
    object["rejected"][rejected.message] = to_json(rejected);
  return object;
}

nlohmann::json to_json(const controller::CycleTiming& timing) {
  nlohmann::json object;
  for (const controller::NamedTime& time : controller::cycle_times()) {
    const controller::TimeSummary summary = (timing.*time.statistics).summary();
    object[std::string(time.key)] = {{"count", summary.count},
                                     {"mean_us", summary.mean_us},
                                     {"sd_us", summary.sd_us},
                                     {"p99_us", summary.p99_us},
                                     {"max_us", summary.max_us}};
  }
  return object;
}

std::vector<std::string> describe(const controller::CycleTiming& timing) {
  std::vector<std::string> lines;
  lines.reserve(controller::cycle_times().size());
  for (const controller::NamedTime& time : controller::cycle_times())
    lines.push_back(controller::describe(time.words, (timing.*time.statistics).summary()));
  return lines;
}

std::string describe(const controller::CycleCounters& counters) {
  return fmt::format("{}, {} missed, {} missing, {} late", counted(counters.cycles, "cycle"),
                     counters.missed_cycles, counted(counters.missing_samples, "sample"),
                     counted(counters.late_samples, "sample"));
}

std::string describe(const controller::AxisOutcome& outcome) {
  const controller::ErrorStatistics total = outcome.statistics.total();
  if (total.samples == 0)
    return outcome.name +
           ": no error to report, because no sample arrived after the settling time of a reference segment";
  std::string line = fmt::format("{}: error RMS {:.4f} um ({:.3f} % of {:g} um), max {:.4f} um over {}",
                                 outcome.name, total.rms_um(), 100.0 * total.rms_um() / outcome.stroke_um,
                                 outcome.stroke_um, total.max_um, counted(total.samples, "sample"));
  const controller::ErrorStatistics ideal = outcome.statistics.total_against_ideal();
  if (ideal.sum_of_squares != total.sum_of_squares)
    line += fmt::format("; relative to the reference without rounded corners: RMS {:.4f} um, max {:.4f} um",
                        ideal.rms_um(), ideal.max_um);
  return line;
}

// A fault is returned first, because the fault of one axis ends the run of all axes and explains why another
// axis did not track.
std::string failure_of(const std::vector<controller::AxisOutcome>& axes) {
  for (const controller::AxisOutcome& axis : axes)
    if (axis.fault.cause != controller::Cause::none) return describe(axis.name, axis.fault);
  for (const controller::AxisOutcome& axis : axes) {
    if (axis.statistics.total().samples > 0) continue;
    if (axis.state == controller::AxisState::tracking)
      return fmt::format(
          "axis {} tracked, but no sample arrived after the settling time of a reference segment", axis.name);
    return fmt::format("axis {} did not start to track its reference: {}", axis.name, to_string(axis.state));
  }
  return {};
}

std::string describe(const controller::Learning::Report& learning) {
  if (learning.periods == 0) return "nothing learnt: every period had a limited drive or a missing sample";
  const std::string errors = fmt::format(
      "{} evaluated, error RMS of the last segment (setpoint[{}]): "
      "{:.4f} um in its first period, {:.4f} um in its last period",
      counted(learning.periods, "period"), learning.segment, learning.first_rms_um, learning.rms_um);
  if (learning.state == controller::LearningState::diverged)
    return errors +
           "; warning: the error of a segment grew in each attempt to learn, "
           "so the correction of this segment was removed permanently";
  if (learning.state == controller::LearningState::resting)
    return errors + "; warning: the error grew, so the learnt correction was set to 0, and learning pauses";
  return errors + fmt::format("; correction up to {:.4f} um", learning.correction_max_um);
}

std::vector<std::string> describe_segments(const controller::AxisOutcome& outcome) {
  std::vector<std::string> lines;
  const controller::TrackingStatistics& statistics = outcome.statistics;
  for (std::size_t i = 0; i < statistics.segments().size(); ++i) {
    const controller::ErrorStatistics& error = statistics.segments()[i];
    const controller::LevelStatistics& levels = statistics.levels()[i];
    const metrics::StepResponse::Result steps = levels.steps.result();
    if (error.samples == 0 && steps.steps == 0) continue;
    std::string line = fmt::format("{}, setpoint[{}], {}: error RMS {:.4f} um, max {:.4f} um", outcome.name,
                                   i, segment_kind(outcome, i), error.rms_um(), error.max_um);
    if (steps.steps > 0) line += describe_steps(steps, statistics.tolerance_um());
    if (levels.hold.samples() > 0)
      line += fmt::format("; hold noise {:.2g} um RMS over {}", levels.hold.rms_um(),
                          counted(levels.hold.samples(), "sample"));
    lines.push_back(line);
  }
  if (outcome.learning) lines.push_back(outcome.name + ", learning: " + describe(*outcome.learning));
  return lines;
}

std::string describe(const std::string& axis, const controller::Fault& fault) {
  return fmt::format("axis {} faulted at {:.3f} s: {}; {}", axis, fault.time_s, to_string(fault.cause),
                     remedy(fault.cause));
}

}  // namespace hystcan::app
