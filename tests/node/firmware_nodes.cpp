#include "tests/node/firmware_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "can/protocol/protocol.h"
#include "tests/node/tables.h"
#include "twin/noise.h"
#include "twin/simulated_amplifier.h"
#include "twin/simulated_sensor.h"

namespace hystcan::firmware {
namespace {

can::Frame to_can(const hystcan_frame& frame) {
  can::Frame made{.id = frame.id,
                  .extended = frame.extended,
                  .kind = frame.kind == HYSTCAN_FD ? can::FrameKind::fd : can::FrameKind::data,
                  .length = frame.length,
                  .fd_flags = frame.bit_rate_switch ? can::fd_bit_rate_switch : std::uint8_t{0}};
  std::copy_n(std::begin(frame.data), frame.length, made.data.begin());
  return made;
}

hystcan_frame to_firmware(const can::Frame& frame) {
  hystcan_frame made{.id = frame.id,
                     .extended = frame.extended,
                     .kind = static_cast<std::uint8_t>(frame.kind == can::FrameKind::fd       ? HYSTCAN_FD
                                                       : frame.kind == can::FrameKind::remote ? HYSTCAN_REMOTE
                                                                                              : HYSTCAN_DATA),
                     .bit_rate_switch = false,
                     .length = frame.length,
                     .data = {}};
  std::copy_n(frame.data.begin(), frame.length, std::begin(made.data));
  return made;
}

std::uint32_t ticks(can::Duration duration) { return static_cast<std::uint32_t>(duration.count()); }

std::vector<can::Filter> filters_of(std::uint8_t node) {
  return {{can::nmt_id}, {can::sync_id}, {can::heartbeat_base + node}, {can::sdo_request_base + node}};
}

}  // namespace

Caller::Caller(can::Scheduler& scheduler, std::unique_ptr<can::Bus> bus)
    : scheduler_(scheduler),
      bus_(std::move(bus)),
      timer_(scheduler.make_timer([this] {
        on_time();
        arm();
      })),
      objects_(64) {
  bus_->on_frame([this](const can::Frame& frame, can::Time) {
    on_frame(to_firmware(frame));
    arm();
  });
}

void Caller::start() {
  start_node();
  arm();
}

hystcan_time Caller::now() const {
  return static_cast<hystcan_time>(scheduler_.now().time_since_epoch().count());
}

void Caller::arm() {
  const hystcan_time at = due();
  if (at == HYSTCAN_NEVER) return timer_->cancel();
  timer_->expire_at(can::Time{} + can::Duration{static_cast<can::Duration::rep>(at)});
}

void Caller::send(const hystcan_frame& frame) { bus_->send(to_can(frame)); }

hystcan_node_config Caller::node_config(std::uint8_t number, const twin::CommonConfig& common) {
  return {
      .number = number,
      .slots = static_cast<std::uint8_t>(common.background_slots),
      .capacity = static_cast<std::uint8_t>(objects_.size()),
      .objects = objects_.data(),
      .heartbeat_period = ticks(common.heartbeat_period),
      .context = this,
      .send = [](void* context, const hystcan_frame* frame) { static_cast<Caller*>(context)->send(*frame); }};
}

/// An amplifier node with the outputs of its axes as the twin's plants.
class Amplifier final : public Caller {
 public:
  Amplifier(const twin::CommonConfig& common, const twin::WiredAxisConfig& first,
            const can::Database& database, can::Scheduler& scheduler, std::unique_ptr<can::Bus> bus)
      : Caller(scheduler, std::move(bus)), interpolation_(common.cycle) {
    command_ = Tables(database, *can::message_map<can::AmpCommand>(first.wire), "").message();
    config_ = {
        .node = node_config(first.wire.amplifier_node, common),
        .command = &command_,
        .axes = nullptr,
        .axis_count = 0,
        .cycle = ticks(common.cycle),
        .write = [](void* self, unsigned axis, std::int32_t setpoint) { of(self).write(axis, setpoint); },
        .connect = [](void*, unsigned) {},
        .leave = [](void* self, unsigned axis, bool tripped) { of(self).leave(axis, tripped); },
        .approach = [](void* self, unsigned axis, std::int32_t setpoint,
                       std::uint32_t elapsed) { of(self).approach(axis, setpoint, elapsed); },
        .output = [](void* self, unsigned axis) { return of(self).output(axis); }};
    node_.config = &config_;
  }

  /// Returns the number of the axis in the node.
  unsigned add(const twin::WiredAxisConfig& config, const can::Database& database, twin::Plant& plant) {
    const Tables command(database, *can::message_map<can::AmpCommand>(config.wire), config.wire.drive_unit);
    Axis axis{.config = config.axis,
              .device = std::make_unique<twin::SimulatedAmplifier>(config.axis.plant.amplifier, plant),
              .command = command,
              .unit = config.wire.drive_unit};
    hystcan_amplifier_axis_config table{};
    table.setpoint = command.drive("setpoint");
    table.enable = command.number("enable");
    table.clear_fault = command.number("clear_fault");
    table.sync_counter = command.number("sync_counter");
    if (const auto map = can::message_map<can::AmpStatus>(config.wire)) {
      axis.status.emplace(database, *map, config.wire.drive_unit);
      axis.has_output = map->carries("output");
      table.status = &statuses_.try_emplace(map->message, axis.status->message()).first->second;
      table.output = axis.status->drive("output");
      table.state = axis.status->number("state");
      table.fault = axis.status->number("fault");
      for (int i = 0; i < 4; ++i)
        table.state_values[i] = static_cast<std::uint8_t>(map->states.raw(static_cast<can::AmpState>(i)));
    }
    const twin::Amplifier::Config& amplifier = config.axis.plant.amplifier;
    table.drive_minimum = static_cast<std::int32_t>(std::llround(amplifier.drive_min * micro));
    table.drive_maximum = static_cast<std::int32_t>(std::llround(amplifier.drive_max * micro));
    table.command_timeout = ticks(config.axis.command_timeout);
    table.enable_delay = ticks(config.axis.enable_delay);
    table.soft_start = ticks(config.axis.soft_start);
    table.status_every = static_cast<std::uint16_t>(config.axis.status_every);
    axes_.push_back(std::move(axis));
    tables_.push_back(table);
    states_.push_back({});
    config_.axes = tables_.data();
    config_.axis_count = static_cast<std::uint8_t>(tables_.size());
    node_.axes = states_.data();
    return config_.axis_count - 1U;
  }

  void set_cause(unsigned axis, bool lasts) {
    hystcan_amplifier_set_cause(&node_, axis, lasts, 0x5000);
    arm();
  }
  void set_interlock(unsigned axis, bool is_open) {
    hystcan_amplifier_set_interlock(&node_, axis, is_open);
    arm();
  }

 private:
  struct Axis {
    node::AmplifierConfig config;
    std::unique_ptr<node::DriveOutput> device;
    Tables command;
    std::string unit;
    std::optional<Tables> status{};
    bool has_output = false;
    double soft_start_from = 0.0;
  };

  static Amplifier& of(void* self) { return static_cast<Amplifier&>(*static_cast<Caller*>(self)); }

  void write(unsigned axis, std::int32_t setpoint) { aim(axes_[axis], physical(axes_[axis], setpoint)); }
  static double physical(const Axis& axis, std::int32_t setpoint) {
    return axis.command.to_physical("setpoint", axis.unit, setpoint);
  }
  void aim(Axis& axis, double drive) {
    axis.device->go_to(drive, scheduler().now(),
                       axis.config.interpolate ? interpolation_ : can::Duration::zero());
  }
  void approach(unsigned number, std::int32_t setpoint, std::uint32_t elapsed) {
    Axis& axis = axes_[number];
    if (elapsed == 0) axis.soft_start_from = axis.device->output(scheduler().now());
    const double share = can::seconds(can::Duration{elapsed}) / can::seconds(axis.config.soft_start);
    if (elapsed != 0) aim(axis, std::lerp(axis.soft_start_from, physical(axis, setpoint), share));
  }
  void leave(unsigned axis, bool tripped) {
    axes_[axis].device->leave(tripped ? axes_[axis].config.watchdog_action : node::WatchdogAction::safe,
                              scheduler().now());
  }
  std::int32_t output(unsigned number) {
    const Axis& axis = axes_[number];
    const double drive = axis.device->output(scheduler().now());
    return axis.has_output ? axis.status->to_value("output", axis.unit, drive) : 0;
  }

  void start_node() override { hystcan_amplifier_start(&node_, now()); }
  void on_frame(const hystcan_frame& frame) override { hystcan_amplifier_on_frame(&node_, &frame, now()); }
  void on_time() override { hystcan_amplifier_on_time(&node_, now()); }
  hystcan_time due() const override { return hystcan_amplifier_due(&node_); }

  can::Duration interpolation_;
  hystcan_message command_{};
  std::map<std::string, hystcan_message> statuses_;
  std::vector<Axis> axes_;
  std::vector<hystcan_amplifier_axis_config> tables_;
  std::vector<hystcan_amplifier_axis> states_;
  hystcan_amplifier_config config_{};
  hystcan_amplifier node_{};
};

/// A sensor node with the sensors of its axes as those of the twin.
class Sensor final : public Caller {
 public:
  Sensor(const twin::CommonConfig& common, const twin::WiredAxisConfig& first, const can::Database& database,
         can::Scheduler& scheduler, std::unique_ptr<can::Bus> bus)
      : Caller(scheduler, std::move(bus)), seed_(common.seed) {
    sample_ = Tables(database, *can::message_map<can::SensorSample>(first.wire), "").message();
    config_ = {.node = node_config(first.wire.sensor_node, common),
               .sample = &sample_,
               .axes = nullptr,
               .axis_count = 0,
               .measure = [](void* self, unsigned axis, std::int32_t* position) {
                 return static_cast<Sensor&>(*static_cast<Caller*>(self)).measure(axis, *position);
               }};
    node_.config = &config_;
  }

  void add(const twin::WiredAxisConfig& config, const can::Database& database, twin::Plant& plant) {
    const Tables sample(database, *can::message_map<can::SensorSample>(config.wire), config.wire.drive_unit);
    twin::Sensor sensor(config.axis.sensor, twin::seed_of(seed_, config.wire.sensor_node, axes_.size()),
                        scheduler().now(), config.axis.plant.substep);
    axes_.push_back(
        {.device = std::make_unique<twin::SimulatedSensor>(std::move(sensor), plant, scheduler().now()),
         .sample = sample});
    tables_.push_back({sample.position("position"), sample.number("sync_counter"), sample.number("status")});
    config_.axes = tables_.data();
    config_.axis_count = static_cast<std::uint8_t>(tables_.size());
  }

 private:
  struct Axis {
    std::unique_ptr<node::PositionInput> device;
    Tables sample;
  };

  std::uint8_t measure(unsigned number, std::int32_t& position) {
    const Axis& axis = axes_[number];
    const node::PositionInput::Reading reading = axis.device->read(scheduler().now());
    position = axis.sample.to_value("position", "um", reading.position_um);
    return reading.status;
  }

  void start_node() override { hystcan_sensor_start(&node_, now()); }
  void on_frame(const hystcan_frame& frame) override { hystcan_sensor_on_frame(&node_, &frame, now()); }
  void on_time() override { hystcan_sensor_on_time(&node_, now()); }
  hystcan_time due() const override { return hystcan_sensor_due(&node_); }

  std::uint64_t seed_;
  hystcan_message sample_{};
  std::vector<Axis> axes_;
  std::vector<hystcan_sensor_axis_config> tables_;
  hystcan_sensor_config config_{};
  hystcan_sensor node_{};
};

Nodes::Nodes(const twin::Config& config, const can::Database& database, can::Scheduler& scheduler,
             const can::Attach& attach) {
  std::map<std::uint8_t, Amplifier*> amplifiers;
  std::map<std::uint8_t, Sensor*> sensors;
  for (const twin::WiredAxisConfig& axis : config.axes) {
    Amplifier*& amplifier = amplifiers[axis.wire.amplifier_node];
    if (amplifier == nullptr) {
      std::vector filters = filters_of(axis.wire.amplifier_node);
      const auto command = can::find_layout<can::AmpCommand>(database, axis.wire);
      filters.push_back({.id = command->id(), .extended = command->extended()});
      auto made = std::make_unique<Amplifier>(config, axis, database, scheduler, attach(filters));
      amplifier = made.get();
      nodes_.push_back(std::move(made));
    }
    Sensor*& sensor = sensors[axis.wire.sensor_node];
    if (sensor == nullptr) {
      auto made = std::make_unique<Sensor>(config, axis, database, scheduler,
                                           attach(filters_of(axis.wire.sensor_node)));
      sensor = made.get();
      nodes_.push_back(std::move(made));
    }
    plants_.push_back(std::make_unique<twin::Plant>(axis.axis.plant, scheduler.now()));
    amplifiers_.push_back({amplifier, amplifier->add(axis, database, *plants_.back())});
    sensor->add(axis, database, *plants_.back());
  }
}

Nodes::~Nodes() = default;

void Nodes::start() {
  for (const auto& node : nodes_) node->start();
}

void Nodes::set_internal_fault(std::size_t axis, bool lasts) {
  amplifiers_[axis].node->set_cause(amplifiers_[axis].axis, lasts);
}

void Nodes::set_relay_open(std::size_t axis, bool is_open) {
  amplifiers_[axis].node->set_interlock(amplifiers_[axis].axis, is_open);
}

}  // namespace hystcan::firmware
