#include "app/page/open_metrics.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/text.h"
#include "base/words.h"

namespace hystcan::app {
namespace {

using nlohmann::json;

class MetricsText {
 public:
  explicit MetricsText(bool is_open) : is_open_(is_open) {}

  void family(std::string_view name, std::string_view type, std::string_view help,
              std::string_view unit = {}) {
    const bool is_only_open = type == "stateset" || type == "info";
    text_ += fmt::format("# TYPE hystcan_{} {}\n", name, is_only_open && !is_open_ ? "gauge" : type);
    if (!unit.empty() && is_open_) text_ += fmt::format("# UNIT hystcan_{} {}\n", name, unit);
    text_ += fmt::format("# HELP hystcan_{} {}\n", name, help);
  }
  /// Adds a line with a value; adds nothing if the value is not finite. `labels`: text in braces, or empty.
  void sample(std::string_view name, const std::string& labels, const json& value) {
    if (!std::isfinite(value.get<double>())) return;
    text_ += fmt::format("hystcan_{}{} {}\n", name, labels, value.dump());
  }
  void counter(const std::string& name, std::string_view help, const json& value) {
    family(is_open_ ? name : name + "_total", "counter", help);
    sample(name + "_total", "", value);
  }
  void gauge(const std::string& name, std::string_view help, const json& value) {
    family(name, "gauge", help);
    sample(name, "", value);
  }
  void histogram(const std::string& name, std::string_view help, const metrics::Histogram& times) {
    family(name, "histogram", help, "seconds");
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < times.counts().size(); ++i) {
      below += times.counts()[i];
      const std::string edge =
          i < times.upper_edges().size() ? fmt::format("{:.6f}", 1e-6 * times.upper_edges()[i]) : "+Inf";
      sample(name + "_bucket", fmt::format("{{le=\"{}\"}}", edge), below);
    }
    sample(name + "_count", "", times.samples());
    sample(name + "_sum", "", 1e-6 * times.sum());
  }
  std::string end() { return is_open_ ? text_ + "# EOF\n" : text_; }
  bool is_open() const { return is_open_; }

 private:
  bool is_open_;
  std::string text_;
};

std::string label_value(const std::string& text) {
  return with_replaced(text, {{'\\', "\\\\"}, {'"', "\\\""}, {'\n', "\\n"}});
}

std::string axis_label(const AxisAnswer& axis) { return fmt::format("axis=\"{}\"", label_value(axis.name)); }

void put_axes(MetricsText& text, const std::vector<AxisAnswer>& axes) {
  text.family("axis_state", "stateset", "state of the axis");
  for (const AxisAnswer& axis : axes)
    for (const controller::AxisState state : every<controller::AxisState>())
      text.sample("axis_state",
                  fmt::format("{{{},hystcan_axis_state=\"{}\"}}", axis_label(axis), to_string(state)),
                  axis.state == state ? 1 : 0);
  text.family(text.is_open() ? "axis_fault" : "axis_fault_info", "info", "latched fault of the axis");
  for (const AxisAnswer& axis : axes)
    text.sample("axis_fault_info",
                fmt::format("{{{},cause=\"{}\"}}", axis_label(axis), label_value(axis.fault)), 1);
  const auto put = [&](std::string_view name, std::string_view help, double AxisAnswer::*value) {
    text.family(name, "gauge", help);
    for (const AxisAnswer& axis : axes)
      text.sample(name, fmt::format("{{{}}}", axis_label(axis)), axis.*value);
  };
  put("axis_position_um", "measured position, um", &AxisAnswer::position_um);
  put("axis_reference_um", "reference, um", &AxisAnswer::reference_um);
  put("axis_error_um", "reference - position, um", &AxisAnswer::error_um);
  put("axis_drive", "commanded drive, in the drive unit of the axis", &AxisAnswer::drive);
}

}  // namespace

bool accepts_open_metrics(std::string_view accept) {
  return accept.find("application/openmetrics-text") != std::string_view::npos;
}

const char* metrics_type(bool is_open) {
  return is_open ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
                 : "text/plain; version=0.0.4; charset=utf-8";
}

std::string metrics_text(bool is_open, const std::optional<StatusAnswer>& status, double age_s,
                         const BusReport& bus, const metrics::Histogram& turnaround,
                         const metrics::Histogram& lateness, const PageCounters& page) {
  MetricsText text(is_open);
  text.gauge("up", "1 if the controller answers", status ? 1 : 0);
  text.family("status_age_seconds", "gauge", "time since the last answer of the controller", "seconds");
  text.sample("status_age_seconds", "", age_s);
  if (status) {
    const controller::CycleCounters& counters = status->counters;
    text.counter("cycles", "cycles of the controller since its start", counters.cycles);
    text.counter("missed_cycles", "skipped cycles", counters.missed_cycles);
    text.counter("missing_samples", "cycles without a sample", counters.missing_samples);
    text.counter("late_samples", "samples that arrived after the end of their cycle", counters.late_samples);
    text.counter("replaced_commands", "commands that a newer command replaced before transmission",
                 counters.replaced_commands);
    put_axes(text, status->axes);
  }
  text.histogram("turnaround_seconds", "time from the received sample to the sent command", turnaround);
  text.histogram("lateness_seconds", "delay of a cycle after its scheduled time", lateness);
  text.gauge("bus_frames_per_second", "frames on the interface", bus.frames_per_s);
  text.gauge("bus_load_percent", "bus load, estimated from the counters of the interface", bus.load_percent);
  text.gauge("page_clients", "clients of the page", page.clients);
  text.counter("page_cut_off", "clients that were disconnected because they did not read or sent too much",
               page.cut_off);
  text.counter("page_refused",
               "requests that were refused because of a foreign host, a foreign origin or a wrong token",
               page.refused);
  text.counter("page_lost_rows", "rows that did not reach a client", page.lost_rows);
  return text.end();
}

}  // namespace hystcan::app
