#include "twin/simulated_card.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/error.h"
#include "node/analogue/device_name.h"

namespace hystcan::twin {
namespace {

double converted(const node::VoltageRange& range, double volts) {
  return range.lo + range.step * std::round((std::clamp(volts, range.lo, range.hi) - range.lo) / range.step);
}

class SimulatedOutput final : public node::VoltageOutput {
 public:
  SimulatedOutput(const node::VoltageRange& range, std::function<void(double)> set)
      : range_(range), set_(std::move(set)) {}
  const node::VoltageRange& range() const override { return range_; }
  bool write(double volts) override {
    set_(converted(range_, volts));
    return true;
  }

 private:
  node::VoltageRange range_;
  std::function<void(double)> set_;
};

class SimulatedInput final : public node::VoltageInput {
 public:
  SimulatedInput(const node::VoltageRange& range, std::function<double()> volts)
      : range_(range), volts_(std::move(volts)) {}
  const node::VoltageRange& range() const override { return range_; }
  std::optional<double> read() override { return converted(range_, volts_()); }

 private:
  node::VoltageRange range_;
  std::function<double()> volts_;
};

class UnusedLine final : public node::LineOutput {
 public:
  bool write(bool) override { return true; }
};

class SteadyLine final : public node::LineInput {
 public:
  explicit SteadyLine(bool level) : level_(level) {}
  std::optional<bool> read() override { return level_; }

 private:
  bool level_;
};

constexpr std::string_view card_name = "simulated";

/// Returns true if `device` names this card. Compares the parsed names, because `simulated` and
/// `simulated:16` are the same card.
bool is_on(const std::string& device, const node::DeviceName& card) {
  const node::DeviceName named = node::device_named(device);
  return named.kind == card.kind && named.bits == card.bits;
}

bool is_at(const node::CardChannel& one, const node::CardChannel& other) {
  return one.subdevice == other.subdevice && one.channel == other.channel;
}

}  // namespace

struct SimulatedCard::Stage {
  Stage(const node::WiredAnalogueAxis& axis, const AxisConfig& stage, std::uint64_t seed, can::Time start)
      : wired(axis),
        plant(stage.plant, start),
        sensor(Sensor(stage.sensor, seed_of(seed, axis.wire.sensor_node, 0), start, stage.plant.substep),
               plant, start),
        drive_noise(stage.drive_noise, stage.plant.substep, start,
                    seed_of(seed, axis.wire.amplifier_node, 0)) {
    if (!drive_noise.is_silent()) plant.set_drive_noise([this](can::Time time) { return drive_noise(time); });
  }

  node::WiredAnalogueAxis wired;
  Plant plant;
  SimulatedSensor sensor;
  DriveNoise drive_noise;
};

SimulatedCard::SimulatedCard(const std::string& name, const Config& config,
                             const std::vector<node::WiredAnalogueAxis>& axes, can::Scheduler& scheduler)
    : bits_(node::device_named(name).bits), scheduler_(scheduler) {
  for (const node::WiredAnalogueAxis& axis : axes) {
    if (!is_on(axis.config.device, node::device_named(name))) continue;
    const auto twin = std::ranges::find(config.axes, axis.wire.name,
                                        [](const WiredAxisConfig& one) { return one.wire.name; });
    stages_.push_back(std::make_unique<Stage>(axis, twin->axis, config.seed, scheduler.now()));
  }
  couple(config);
}

SimulatedCard::~SimulatedCard() = default;

void SimulatedCard::couple(const Config& config) {
  const auto stage_of = [&](const std::string& name) {
    const auto found = std::ranges::find(stages_, name, [](const auto& one) { return one->wired.wire.name; });
    return found == stages_.end() ? nullptr : found->get();
  };
  for (const WiredAxisConfig& axis : config.axes)
    for (const model::Coupling& coupling : axis.axis.couplings)
      if (Stage* to = stage_of(axis.wire.name), *from = stage_of(coupling.from);
          to != nullptr && from != nullptr)
        to->plant.couple(from->plant, coupling.um_per_um);
}

Plant& SimulatedCard::plant(std::string_view axis) {
  const auto found = std::ranges::find(stages_, axis, [](const auto& one) { return one->wired.wire.name; });
  Plant& plant = (*found)->plant;
  plant.advance_to(scheduler_.now());
  return plant;
}

node::VoltageRange SimulatedCard::range_of(unsigned bits, const node::CardChannel& place) {
  const auto range = [&](double lo, double hi) {
    return node::VoltageRange{lo, hi, (hi - lo) / (std::exp2(bits) - 1.0)};
  };
  if (place.range.empty() || place.range == "-10..10 V") return range(-10.0, 10.0);
  if (place.range == "0..10 V") return range(0.0, 10.0);
  throw node::ChannelError(
      "range", Error(card_name, fmt::format("channel {} has no range \"{}\"", place.channel, place.range),
                     {.remedy = "available ranges: -10..10 V, 0..10 V"}));
}

SimulatedCard::Stage& SimulatedCard::stage_driven_by(const node::CardChannel& place) {
  for (const auto& stage : stages_)
    if (is_at(stage->wired.config.drive_output, place)) return *stage;
  throw Error(
      card_name, fmt::format("no axis of this card has channel {} as its output", place.channel),
      {.remedy = "name this card in the key device of the axis, and remove the key device of the channel"});
}

node::VoltageRange SimulatedCard::check_output(const node::CardChannel& place) {
  stage_driven_by(place);
  return range_of(bits_, place);
}

std::unique_ptr<node::VoltageOutput> SimulatedCard::output(const node::CardChannel& place) {
  Stage& stage = stage_driven_by(place);
  return std::make_unique<SimulatedOutput>(
      range_of(bits_, place),
      [this, &plant = stage.plant, volts_per_drive = stage.wired.config.volts_per_drive](double volts) {
        plant.advance_to(scheduler_.now());
        plant.set_target(volts / volts_per_drive);
      });
}

std::unique_ptr<node::VoltageInput> SimulatedCard::input(const node::CardChannel& place) {
  for (const auto& stage : stages_) {
    const node::AnalogueConfig& config = stage->wired.config;
    if (is_at(config.position_input.place, place))
      return std::make_unique<SimulatedInput>(range_of(bits_, place), [this, &stage = *stage, &config] {
        return (stage.sensor.read(scheduler_.now()).position_um - config.position_zero_um) /
               config.position_um_per_V;
      });
    if (config.output_input && is_at(*config.output_input, place))
      return std::make_unique<SimulatedInput>(range_of(bits_, place), [this, &plant = stage->plant, &config] {
        plant.advance_to(scheduler_.now());
        return plant.drive() * config.volts_per_drive;
      });
  }
  throw Error(
      card_name, fmt::format("no axis of this card has channel {} as an input", place.channel),
      {.remedy = "name this card in the key device of the axis, and remove the key device of the channel"});
}

std::unique_ptr<node::LineOutput> SimulatedCard::line_output(const node::CardChannel&) {
  return std::make_unique<UnusedLine>();
}

std::unique_ptr<node::LineInput> SimulatedCard::line_input(const node::CardChannel& place) {
  const auto is_active_low = [&](const auto& stage) {
    const auto& line = stage->wired.config.interlock_line;
    return line && is_at(line->place, place) && line->active == node::ActiveLevel::low;
  };
  return std::make_unique<SteadyLine>(std::ranges::any_of(stages_, is_active_low));
}

}  // namespace hystcan::twin
