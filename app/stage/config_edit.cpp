#include "app/stage/config_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <system_error>

#include "app/stage/dynamics_text.h"
#include "base/output_file.h"
#include "config/document/toml_edit.h"

namespace hystcan::app {
namespace {

/// Whole ones, as the configuration has them.
double whole_microseconds(std::chrono::nanoseconds duration) { return std::round(microseconds(duration)); }

class LoopEdit {
 public:
  LoopEdit(config::TomlEdit& edit, std::size_t axis)
      : edit_(edit), control_(fmt::format("axis[{}].control.", axis)) {}

  void number(const std::string& key, double before, double after) {
    if (after != before || !edit_.contains(control_ + key)) edit_.set(control_ + key, toml_number(after));
  }
  void truth(const std::string& key, bool before, bool after) {
    if (after != before) edit_.set(control_ + key, after ? "true" : "false");
  }
  void low_pass(double before, double after) {
    if (after > 0.0)
      number("measurement_filter_Hz", before, after);
    else
      edit_.comment_out(control_ + "measurement_filter_Hz");
  }
  void notch(const std::optional<controller::Notch::Config>& before,
             const std::optional<controller::Notch::Config>& after) {
    if (!after) {
      edit_.comment_out(control_ + "notch");
      return;
    }
    const controller::Notch::Config old = before.value_or(*after);
    number("notch.frequency_Hz", old.frequency_Hz, after->frequency_Hz);
    number("notch.depth", old.depth, after->depth);
    number("notch.width", old.width, after->width);
  }

 private:
  config::TomlEdit& edit_;
  std::string control_;
};

}  // namespace

LoopKeys loop_keys_of(const config::AxisConfig& axis) {
  const controller::ControlLaw::Config& law = axis.control.law;
  return {{law.pi, law.measurement_filter_Hz, law.notch}, axis.control.delays};
}

std::size_t index_of_axis(const config::Config& config, const std::string& name) {
  if (name.empty()) return 0;
  const auto found = std::ranges::find(config.axes, name, [](const auto& axis) { return axis.wire.name; });
  if (found == config.axes.end())
    throw Error(fmt::format("{}: no axis {}, expected one of its names", config.file.string(), name));
  return static_cast<std::size_t>(found - config.axes.begin());
}

std::string with_loop_keys(const config::Config& config, std::size_t axis, const LoopKeys& keys) {
  config::TomlEdit text = config::TomlEdit::of_file(config.file);
  LoopEdit edit(text, axis);
  const LoopKeys before = loop_keys_of(config.axes[axis]);
  const controller::Delays &was = before.delays, &now = keys.delays;
  edit.number("kp", before.setting.pi.kp, keys.setting.pi.kp);
  edit.number("ki_per_s", before.setting.pi.ki_per_s, keys.setting.pi.ki_per_s);
  edit.low_pass(before.setting.measurement_filter_Hz, keys.setting.measurement_filter_Hz);
  edit.number("delays.command_delay_us", whole_microseconds(was.command_delay),
              whole_microseconds(now.command_delay));
  edit.number("delays.amplifier_bandwidth_Hz", was.amplifier_bandwidth_Hz, now.amplifier_bandwidth_Hz);
  if (now.sensor_delay != was.sensor_delay)
    edit.number("delays.sensor_delay_us", whole_microseconds(was.sensor_delay),
                whole_microseconds(now.sensor_delay));
  edit.number("delays.resonance_Hz", was.resonance_Hz, now.resonance_Hz);
  edit.number("delays.damping_ratio", was.damping_ratio, now.damping_ratio);
  edit.truth("delays.second_order", was.second_order, now.second_order);
  edit.truth("delays.plant_inverse", was.plant_inverse, now.plant_inverse);
  edit.notch(before.setting.notch, keys.setting.notch);
  return text.text();
}

void refuse_to_overwrite_inputs(const std::filesystem::path& output, const std::filesystem::path& file,
                                const config::Config& config) {
  const auto folder = file.parent_path();
  refuse_to_overwrite(output, file);
  refuse_to_overwrite(output, folder / config.bus.dbc);
  for (const config::AxisConfig& axis : config.axes)
    for (const auto& model : {axis.control_model, axis.twin_model})
      refuse_to_overwrite(output, folder / model);
}

void refuse_to_write_into(const std::filesystem::path& written, const config::Config& config,
                          const std::filesystem::path& output, const std::filesystem::path& data) {
  refuse_to_overwrite_inputs(written, config.file, config);
  refuse_to_share(written, output);
  if (!data.empty()) refuse_to_overwrite(written, data);
  if (std::filesystem::exists(written))
    throw Error(fmt::format("{}: exists already, expected a new file", written.string()));
  const auto folder = [](const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, ignored), ignored).parent_path();
  };
  if (folder(written) != folder(config.file))
    throw Error(
        fmt::format("{}: is not beside {}, expected a file in its folder: the paths in it count from there",
                    written.string(), config.file.string()));
}

}  // namespace hystcan::app
