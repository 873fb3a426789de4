#include "app/stage/stage_questions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "app/stage/identified_plant.h"
#include "app/stage/lab_frames.h"
#include "app/stage/shipped.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "config/schema/analogue_schema.h"
#include "config/schema/check.h"
#include "identification/dynamics/second_order_fit.h"
#include "node/analogue/device_name.h"

namespace hystcan::app {
namespace {

using model::Interval;

constexpr const char* on_can = "can";

void require_names(const std::vector<std::string>& axes) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    // File names are AXIS.first.toml or AXIS.model.toml, so a dot in an axis name would be ambiguous.
    if (!config::is_axis_name(axes[i]) || axes[i].find('.') != std::string::npos)
      throw Error(fmt::format("--axis is '{}'", axes[i]),
                  expect("1 to 64 letters, digits, _ or -, because the name is part of file names"));
    if (std::find(axes.begin(), axes.begin() + static_cast<std::ptrdiff_t>(i), axes[i]) !=
        axes.begin() + static_cast<std::ptrdiff_t>(i))
      throw Error(fmt::format("--axis {} occurs twice", axes[i]), expect("different names"));
  }
}

/// Collects the facts about the axes, one axis at a time. Asks the user only about the first axis: the
/// answers also apply to the other axes, except for values that options or records give.
class AxisQuestions {
 public:
  AxisQuestions(const InitOptions& stated, const std::vector<AxisRecords>& records, Questions& questions)
      : stated_(stated), records_(records), questions_(questions) {}

  AxisFacts ask(std::size_t i) {
    axis_ = i;
    AxisFacts axis;
    axis.config.wire.name = stated_.axes[i];
    axis.config.wire.drive_unit = unit_;
    drive(axis.config.control.gate);
    travel(axis);
    mode(axis);
    const double sensor_delay_us =
        number({"--sensor-delay", "Sensor's delay", "us",
                "time from a position to the sample that shows it, see the data sheet; 0 if unknown"},
               stated_.sensor_delay_us, {}, 0.0, sensor_delay_us_, [](double value) {
                 return unless(value >= 0.0 && value <= 100'000.0, "{:g}, expected 0 to 100000", value);
               });
    axis.config.control.delays.sensor_delay = std::chrono::nanoseconds(std::llround(1e3 * sensor_delay_us));
    if (card_ != on_can) wire_to_card(axis.config.analogue.emplace());
    const controller::Gate::Config& gate = axis.config.control.gate;
    if (const AxisRecords* measured = record())
      refuse_contradictions(*measured, unit_, {gate.drive_min, gate.drive_max},
                            of_axis("--stroke", stated_.stroke_um, i, stated_.axes.size()));
    return axis;
  }

  void ask_card() {
    card_ = questions_.text(
        {"--card", "Amplifier on CAN, or analogue", "",
         "can, or the card of an analogue amplifier: comedi:/dev/comedi0, iio:ad5791, simulated"},
        stated_.card, on_can, [](const std::string& card) {
          return unless(card == on_can || node::DeviceName::parsed(card), "'{}', expected can, {}", card,
                        node::DeviceName::expected);
        });
  }

  void ask_unit() {
    std::optional<std::string> usual = "V";
    if (!records_.empty()) usual = records_.front().loops.front().input_unit;
    const std::optional<std::string> known =
        stated_.drive_unit || records_.empty() ? stated_.drive_unit : usual;
    unit_ = questions_.text({"--unit", "Unit of the drive", "", "V for a piezo stack, A for a coil"}, known,
                            usual, [](const std::string& unit) {
                              return unless(unit == "V" || unit == "A", "'{}', expected V or A", unit);
                            });
  }

 private:
  const AxisRecords* record() const { return records_.empty() ? nullptr : &records_[axis_]; }

  /// Returns a value for the current axis. A value stated by an option has precedence. Otherwise, the user is
  /// asked if this is the first axis; the default is `measured` or `usual`. Any other axis uses `measured`,
  /// or else `answer`, the value that was found for the first axis.
  double number(const Question& question, const std::vector<double>& stated, std::optional<double> measured,
                std::optional<double> usual, std::optional<double>& answer,
                const Questions::Check<double>& check = {}) {
    std::optional<double> known = of_axis(question.option.c_str(), stated, axis_, stated_.axes.size());
    if (!known && axis_ > 0) known = measured ? measured : answer;
    if (known && std::isnan(*known)) return *known;  // the first axis has no number, so this one has none
    answer = questions_.number(question, known, measured ? measured : usual, check);
    return *answer;
  }

  static constexpr double largest_drive = 1e6;
  static constexpr double usual_damping_ratio = 0.02;
  static std::optional<std::string> if_too_large(double value, double most = largest_drive) {
    return unless(std::abs(value) <= most, "{:g}, expected at most {:g} in magnitude", value, most);
  }

  void drive(controller::Gate::Config& gate) {
    std::optional<double> least, most;
    if (const AxisRecords* measured = record()) {
      const Interval range = measured->drive();
      const double grain = std::pow(10.0, std::floor(std::log10(range.span())) - 2.0);
      least = grain * std::floor(range.lo / grain + 0.1);
      most = grain * std::ceil(range.hi / grain - 0.1);
    }
    gate.drive_min =
        number({"--drive-min", "Lowest drive", unit_, "the controller commands no drive below this limit"},
               stated_.drive_min, least, {}, drive_min_, [&](double value) {
                 if (auto problem = if_too_large(value)) return problem;
                 return unless(!least || value <= *least, "{:g}, but the record goes down to {:g} {}", value,
                               least.value_or(0.0), unit_);
               });
    gate.drive_max = number(
        {"--drive-max", "Highest drive", unit_, "the controller commands no drive above this limit"},
        stated_.drive_max, most, {}, drive_max_, [&](double value) {
          if (auto problem = if_too_large(value)) return problem;
          if (most && value < *most)
            return unless(false, "{:g}, but the record goes up to {:g} {}", value, *most, unit_);
          if (value <= gate.drive_min)
            return unless(false, "{:g}, expected more than the lowest drive, {:g}", value, gate.drive_min);
          return unless(value - gate.drive_min >= 1e-6,
                        "{:g}, expected at least 1e-6 above the lowest drive, {:g}", value, gate.drive_min);
        });
    const double nearest_zero = std::min(std::max(0.0, gate.drive_min), gate.drive_max);
    gate.safe_drive =
        number({"--safe", "Safe drive", unit_, "drive at the end of every run, also after a fault"},
               stated_.safe_drive, {}, nearest_zero, safe_drive_, [&](double value) {
                 return unless(value >= gate.drive_min && value <= gate.drive_max,
                               "{:g}, expected {:g} to {:g}", value, gate.drive_min, gate.drive_max);
               });
  }

  void travel(AxisFacts& axis) {
    if (const AxisRecords* measured = record()) {
      axis.travel_um = measured->travel_um();
      return;
    }
    const double stroke = number({"--stroke", "Stroke", "um", "travel from the lowest to the highest drive"},
                                 stated_.stroke_um, {}, {}, stroke_um_, a_millionth_to_1e9_);
    const controller::Gate::Config& gate = axis.config.control.gate;
    const double below = stroke * (gate.safe_drive - gate.drive_min) / (gate.drive_max - gate.drive_min);
    const double at_safe =
        number({"--sensor-at-safe", "Reading of the sensor at the safe drive", "um",
                "init computes the position limits from this reading and the stroke"},
               stated_.sensor_at_safe_um, {}, 0.0, sensor_at_safe_um_, [](double value) {
                 return unless(std::abs(value) <= 1e6, "{:g}, expected at most 1e6 in magnitude", value);
               });
    axis.travel_um = {at_safe - below, at_safe + stroke - below};
    axis.config.twin.sensor.noise_um_rms = 1e-5 * stroke;
  }

  void mode(AxisFacts& axis) {
    std::optional<double> resonance_Hz, damping_ratio;
    const auto stated = of_axis("--resonance", stated_.resonance_Hz, axis_, stated_.axes.size());
    if (const AxisRecords* measured = record(); measured != nullptr && measured->step) {
      try {
        const auto fit = identification::fit_second_order(*measured->step);
        if (!stated || is_as_stated(fit, *stated)) {
          resonance_Hz = fit.natural_frequency_Hz.value;
          damping_ratio = fit.damping_ratio.value;
        }
      } catch (const identification::ModeNotShown& error) {
        if (!stated) note("{}: {}; set --resonance\n", measured->step_file->string(), error.what());
      } catch (const std::invalid_argument& error) {
        throw Error(*measured->step_file, error);
      }
    }
    controller::Delays& delays = axis.config.control.delays;
    delays.resonance_Hz =
        known_or_asked({"--resonance", "First resonance", "Hz",
                        "feedback, ramps and reference stay below this frequency; see the data sheet"},
                       resonance_Hz, stated_.resonance_Hz, {}, resonance_Hz_);
    delays.damping_ratio = known_or_asked(
        {"--damping", "Damping ratio", "", "damping of the first resonance; 0.01 to 0.05 for flexures"},
        damping_ratio, stated_.damping_ratio, usual_damping_ratio, damping_ratio_);
    axis.mode_is_measured = resonance_Hz.has_value();
    axis.damping_is_assumed =
        !damping_ratio && stated_.damping_ratio.empty() && delays.damping_ratio == usual_damping_ratio;
  }

  /// Assigns channel 0 of the card to the first axis, channel 1 to the second axis, and so on.
  void wire_to_card(node::AnalogueConfig& analogue) {
    const auto is_scale = [](double value) {
      return unless(config::scale_range.contains(value), "{:g}, expected {}", value,
                    config::scale_range.describe());
    };
    constexpr unsigned usual_output_subdevice = 1;
    analogue.device = card_;
    analogue.drive_output.channel = analogue.position_input.place.channel = static_cast<unsigned>(axis_);
    if (node::device_named(card_).kind == node::CardKind::comedi)
      analogue.drive_output.subdevice = usual_output_subdevice;
    const auto usual_volts = unit_ == "V" ? std::optional(0.1) : std::nullopt;
    analogue.volts_per_drive = number({"--volts-per-drive", "Volts of the card for a drive of 1 " + unit_,
                                       "V", "0.1 for an amplifier of 10 V/V"},
                                      stated_.volts_per_drive, {}, usual_volts, volts_per_drive_, is_scale);
    analogue.position_um_per_V =
        number({"--um-per-V", "Position for 1 V of the sensor", "um", "see the data sheet of the sensor"},
               stated_.um_per_V, {}, stated_.input.layout.output_scale, um_per_V_, is_scale);
  }

  /// Returns `shown`, the value from a step record, if there is one; otherwise asks for the value.
  double known_or_asked(const Question& question, std::optional<double> shown,
                        const std::vector<double>& stated, std::optional<double> usual,
                        std::optional<double>& answer) {
    return shown ? *shown : number(question, stated, {}, usual, answer, a_millionth_to_1e9_);
  }

  const Questions::Check<double> a_millionth_to_1e9_ = [](double value) {
    return unless(value >= 1e-6 && value <= 1e9, "{:g}, expected 1e-6 to 1e9", value);
  };
  const InitOptions& stated_;
  const std::vector<AxisRecords>& records_;
  Questions& questions_;
  std::size_t axis_ = 0;
  std::string unit_, card_;
  std::optional<double> drive_min_, drive_max_, safe_drive_, stroke_um_, sensor_at_safe_um_, resonance_Hz_,
      damping_ratio_, sensor_delay_us_, volts_per_drive_, um_per_V_;
};

std::vector<int> parsed_nodes(const std::string& text) {
  std::vector<int> nodes;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (at != end) {
    int node = 0;
    const auto [behind, error] = std::from_chars(at, end, node);
    if (error != std::errc()) return {};
    nodes.push_back(node);
    at = behind;
    while (at != end && (*at == ',' || *at == ' ')) ++at;
  }
  return nodes;
}

std::optional<std::string> wrong_with(const std::vector<int>& nodes, std::size_t axes) {
  const bool sound = nodes.size() == 2 * axes &&
                     std::ranges::all_of(nodes, [](int node) { return node >= 1 && node <= 127; });
  if (!sound)
    return unless(false, "expected {} node ids from 1 to 127, two for each axis: amplifier, sensor",
                  2 * axes);
  std::vector<int> sorted = nodes;
  std::ranges::sort(sorted);
  return unless(std::ranges::adjacent_find(sorted) == sorted.end(), "expected different ids");
}

void number_nodes(StageFacts& stage, const InitOptions& stated, Questions& questions) {
  std::vector<int> known = stated.nodes, usual;
  std::string usual_text;
  bool from_dbc = true;
  for (std::size_t i = 0; i < stage.axes.size(); ++i) {
    const can::AxisWire& wire = stage.axes[i].config.wire;
    from_dbc = from_dbc && wire.amplifier_node != 0 && wire.sensor_node != 0;
    usual.push_back(wire.amplifier_node != 0 ? wire.amplifier_node : static_cast<int>(2 * i + 1));
    usual.push_back(wire.sensor_node != 0 ? wire.sensor_node : static_cast<int>(2 * i + 2));
  }
  for (const int node : usual) usual_text += fmt::format("{}{}", usual_text.empty() ? "" : ",", node);
  if (known.empty() && from_dbc) known = usual;
  std::optional<std::string> known_text;
  for (const int node : known)
    known_text = known_text ? *known_text + fmt::format(",{}", node) : fmt::format("{}", node);
  const std::string answer = questions.text(
      {"--nodes", "Node ids", "",
       "two node ids for each axis, amplifier and sensor (for CANopen heartbeats and SYNC)"},
      known_text, usual_text,
      [&](const std::string& text) { return wrong_with(parsed_nodes(text), stage.axes.size()); });
  const std::vector<int> nodes = parsed_nodes(answer);
  for (std::size_t i = 0; i < stage.axes.size() && 2 * i + 1 < nodes.size(); ++i) {
    stage.axes[i].config.wire.amplifier_node = static_cast<std::uint8_t>(nodes[2 * i]);
    stage.axes[i].config.wire.sensor_node = static_cast<std::uint8_t>(nodes[2 * i + 1]);
  }
}

/// Returns the shipped DBC whose standard frames have a setpoint in this unit, V or A.
std::filesystem::path shipped_dbc(const std::string& drive_unit) {
  return shipped_file(drive_unit == "A" ? "galfenol.dbc" : "hystcan.dbc");
}

constexpr double usual_rate_Hz = 1000.0;

void ask_about_the_bus(StageFacts& stage, const InitOptions& stated, Questions& questions) {
  stage.config.controller.rate_Hz = questions.number(
      {"--cycle-rate", "Cycle rate", "Hz",
       "cycles (sample and command) per second; the bus must carry four frames in each cycle"},
      stated.rate_Hz, usual_rate_Hz, [](double value) {
        return unless(value >= 1.0 && value <= 10'000.0, "{:g}, expected 1 to 10000", value);
      });
  stage.rate_is_assumed = !stated.rate_Hz && stage.config.controller.rate_Hz == usual_rate_Hz;
  stage.config.bus.interface =
      questions.text({"--interface", "CAN interface", "", "vcan0 for the twin; can be changed at any time"},
                     stated.interface, "vcan0", [](const std::string& name) {
                       return unless(name.size() <= 15 && name.find_first_of("/ ") == std::string::npos,
                                     "'{}', expected a name of at most 15 letters", name);
                     });
  const std::filesystem::path shipped = shipped_dbc(stage.axes.front().config.wire.drive_unit);
  const std::string own = shipped.filename().string();
  const bool has_own_nodes = stage.axes.front().config.analogue.has_value();
  const auto known = stated.dbc || !has_own_nodes ? stated.dbc : std::optional(own);
  const std::string dbc = questions.text(
      {"--dbc", "DBC of the frames", "", "DBC file of the nodes; " + own + " has the standard frames"}, known,
      own, [&](const std::string& file) -> std::optional<std::string> {
        if (file == own && !std::filesystem::exists(file)) return std::nullopt;
        try {
          can::load_dbc(file);
          return std::nullopt;
        } catch (const Error& error) {
          return error.what();
        }
      });
  stage.config.bus.dbc = dbc == own && !std::filesystem::exists(dbc) ? shipped : std::filesystem::path(dbc);
}

StageFacts asked_from_the_first(const InitOptions& stated, const std::vector<AxisRecords>& records,
                                Questions& questions) {
  questions.begin();
  StageFacts stage;
  AxisQuestions axes(stated, records, questions);
  axes.ask_card();
  axes.ask_unit();
  for (std::size_t i = 0; i < stated.axes.size(); ++i) stage.axes.push_back(axes.ask(i));
  ask_about_the_bus(stage, stated, questions);
  questions.require_all();
  find_frames(stage, stated.roles, questions);
  number_nodes(stage, stated, questions);
  return stage;
}

}  // namespace

StageFacts ask_about(const InitOptions& stated, const std::vector<AxisRecords>& records,
                     Questions& questions) {
  require_names(stated.axes);
  for (;;) try {
      return asked_from_the_first(stated, records, questions);
    } catch (const Questions::StepBack&) {
    }
}

}  // namespace hystcan::app
