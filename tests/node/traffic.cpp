#include "tests/node/traffic.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hystcan::firmware {

using std::chrono::microseconds;

Traffic::Traffic(std::uint64_t seed, const twin::Config& config, const can::Database& database)
    : random_(seed), cycle_(config.cycle) {
  for (const twin::WiredAxisConfig& axis : config.axes) {
    for (const std::uint8_t node : {axis.wire.amplifier_node, axis.wire.sensor_node})
      if (std::ranges::find(nodes_, node) == nodes_.end()) nodes_.push_back(node);
    const auto layout = *can::find_layout<can::AmpCommand>(database, axis.wire);
    const twin::Amplifier::Config& amplifier = axis.axis.plant.amplifier;
    const auto same = std::ranges::find_if(
        commands_, [&](const Command& command) { return command.axes.front().id() == layout.id(); });
    if (same == commands_.end())
      commands_.push_back({.protector = can::E2eProtector(layout.protection()),
                           .axes = {layout},
                           .setpoints = {amplifier.safe_drive},
                           .drive_min = amplifier.drive_min,
                           .drive_max = amplifier.drive_max,
                           .last = {}});
    else
      same->axes.push_back(layout), same->setpoints.push_back(amplifier.safe_drive);
  }
}

can::Duration Traffic::within(double from, double to) {
  const double cycle_us = can::seconds(cycle_) * 1e6;
  return microseconds(std::lround(cycle_us * std::lerp(from, to, uniform())));
}

void Traffic::choose_mode() {
  static constexpr std::array<std::pair<Mode, double>, 8> shares{{{Mode::drive, 0.5},
                                                                  {Mode::switch_off, 0.08},
                                                                  {Mode::clear_faults, 0.14},
                                                                  {Mode::anything, 0.1},
                                                                  {Mode::no_sync, 0.05},
                                                                  {Mode::no_commands, 0.06},
                                                                  {Mode::silence, 0.04},
                                                                  {Mode::objects, 0.03}}};
  double rest = uniform();
  for (const auto& [mode, share] : shares) {
    mode_ = mode;
    if ((rest -= share) < 0.0) break;
  }
  cycles_left_ = mode_ == Mode::drive ? 20 + pick(120) : mode_ == Mode::objects ? 70 : 1 + pick(40);
  if (mode_ == Mode::silence && chance(0.3)) cycles_left_ = 150 + pick(200);
}

std::vector<Traffic::Item> Traffic::next_cycle() {
  if (cycles_left_-- == 0) choose_mode();
  std::vector<Item> items;
  for (Item& item : later_) item.at -= cycle_;
  while (!later_.empty() && later_.front().at < cycle_) {
    items.push_back({std::max(later_.front().at, can::Duration::zero()), later_.front().frame});
    later_.pop_front();
  }
  if (mode_ != Mode::silence) {
    if (mode_ != Mode::no_sync) add_sync(items);
    if (mode_ != Mode::no_commands)
      for (Command& command : commands_) add_command(command, items);
    add_nmt(items);
    add_sdo(items);
    add_noise(items);
  }
  std::ranges::stable_sort(items, {}, &Item::at);
  return items;
}

void Traffic::add_sync(std::vector<Item>& items) {
  if (chance(0.01)) sync_ = static_cast<std::uint8_t>(1 + pick(can::sync_counter_max));  // a jump
  sync_ = can::next_sync_counter(sync_);
  if (chance(0.02)) return;  // lost
  const can::Duration at = chance(0.05) ? within(0.0, 0.9) : within(0.0, 0.1);
  can::Frame frame = can::sync_frame(sync_);
  if (chance(0.01)) frame.data[0] = static_cast<std::uint8_t>(pick(256));
  items.push_back({at, chance(0.01) ? damaged(frame) : frame});
  if (chance(0.02)) items.push_back({at + within(0.0, 0.3), frame});
}

can::AmpCommand Traffic::axis_command(Command& command, std::size_t axis) {
  const double range = command.drive_max - command.drive_min;
  double& setpoint = command.setpoints[axis];
  setpoint = std::clamp(setpoint + 0.1 * range * (uniform() - 0.5), command.drive_min, command.drive_max);
  can::AmpCommand made{.setpoint = setpoint, .enable = true, .clear_fault = false, .sync_counter = sync_};
  if (chance(0.003)) made.setpoint = chance(0.5) ? command.drive_min : command.drive_max;
  if (chance(0.003)) made.setpoint = chance(0.5) ? command.drive_min - 0.002 : command.drive_max + 0.002;
  if (chance(0.001)) made.setpoint = (chance(0.5) ? 3.0 : 60.0) * command.drive_max * (uniform() - 0.5);
  if (mode_ == Mode::switch_off) made.enable = false;
  if (mode_ == Mode::clear_faults) made.clear_fault = true, made.enable = chance(0.2);
  if (mode_ == Mode::anything || chance(0.005)) made.enable = chance(0.6), made.clear_fault = chance(0.3);
  return made;
}

can::Frame Traffic::command_frame(Command& command) {
  can::Frame frame = command.axes.front().frame();
  std::uint8_t named = sync_;
  if (chance(0.04)) named = can::next_sync_counter(static_cast<std::uint8_t>((sync_ + 237 + pick(3)) % 240));
  if (chance(0.01)) named = static_cast<std::uint8_t>(pick(256));
  for (std::size_t axis = 0; axis < command.axes.size(); ++axis) {
    can::AmpCommand made = axis_command(command, axis);
    made.sync_counter = named;
    // A value that does not fit the signal stays 0: the limits are those of the sender's DBC.
    static_cast<void>(command.axes[axis].put(made, frame));
  }
  command.protector.seal(frame);
  if (chance(0.01)) command.protector.seal(frame);  // a gap
  return frame;
}

void Traffic::add_command(Command& command, std::vector<Item>& items) {
  can::Frame frame = command_frame(command);
  if (chance(0.02) && command.last) frame = *command.last;
  command.last = frame;
  if (chance(0.01)) return;  // lost
  if (chance(0.02)) frame = damaged(frame);
  can::Duration at = within(0.1, 0.8);
  if (chance(0.01)) at += cycle_ * (1 + pick(5));
  if (at < cycle_)
    items.push_back({at, frame});
  else
    later_.insert(std::ranges::upper_bound(later_, at, {}, &Item::at), {at, frame});
}

std::uint8_t Traffic::any_node() {
  if (chance(0.1)) return static_cast<std::uint8_t>(pick(128));
  return nodes_[pick(static_cast<unsigned>(nodes_.size()))];
}

void Traffic::add_nmt(std::vector<Item>& items) {
  if (chance(0.04))
    items.push_back({within(0.0, 0.9), can::nmt_frame({can::NmtCommand::start, std::uint8_t{0}})});
  if (!chance(0.006)) return;
  static constexpr std::array commands{can::NmtCommand::start, can::NmtCommand::stop,
                                       can::NmtCommand::enter_pre_operational, can::NmtCommand::reset_node,
                                       can::NmtCommand::reset_communication};
  can::Frame frame =
      can::nmt_frame({commands[pick(commands.size())], chance(0.2) ? std::uint8_t{0} : any_node()});
  if (chance(0.1)) frame.data[0] = static_cast<std::uint8_t>(pick(256));
  items.push_back({within(0.0, 0.9), chance(0.1) ? damaged(frame) : frame});
}

void Traffic::add_sdo(std::vector<Item>& items) {
  if (mode_ != Mode::objects && !chance(0.03)) return;
  const bool writes = mode_ == Mode::objects || chance(0.5);
  can::SdoMessage message{.service = writes ? can::SdoService::write : can::SdoService::read,
                          .object = {.index = static_cast<std::uint16_t>(0x2000 + pick(2)),
                                     .subindex = static_cast<std::uint8_t>(pick(6))},
                          .content = {.value = static_cast<std::uint32_t>(random_()),
                                      .bytes = static_cast<std::uint8_t>(1 + pick(4))}};
  if (mode_ == Mode::objects) message.object.subindex = static_cast<std::uint8_t>(++written_);
  if (chance(0.1))
    message.object.index = std::array<std::uint16_t, 4>{0x1FFF, 0x5FFF, 0x6000, 0x1000}[pick(4)];
  const std::uint8_t node = mode_ == Mode::objects ? nodes_.front() : any_node();
  message.content.value &= 0xFFFF'FFFFU >> 8 * (4 - message.content.bytes);
  can::Frame frame = can::sdo_request(node, message);
  if (chance(0.05)) frame.data[0] = static_cast<std::uint8_t>(pick(256));
  items.push_back({within(0.0, 0.9), chance(0.05) ? damaged(frame) : frame});
}

/// Frames of other nodes: heartbeats of unknown states and lengths, and bursts that delay later frames.
void Traffic::add_noise(std::vector<Item>& items) {
  if (chance(0.01)) {
    can::Frame frame = can::heartbeat_frame(any_node(), can::NmtState{0x42});
    if (chance(0.5)) frame.length = static_cast<std::uint8_t>(2 + pick(6));
    items.push_back({within(0.0, 0.9), frame});
  }
  if (!chance(0.005)) return;
  const can::Duration at = within(0.0, 0.9);
  const std::uint32_t id = chance(0.5) ? 0x001 : 0x7FE;
  for (unsigned i = pick(9); i > 0; --i) items.push_back({at, {.id = id, .length = 8}});
}

/// Changes a bit, the length, or the kind of the frame.
can::Frame Traffic::damaged(can::Frame frame) {
  switch (pick(5)) {
    case 0:
      frame.length = frame.length == 8 ? std::uint8_t{7} : std::uint8_t{8};
      return frame;
    case 1:
      frame.extended = !frame.extended;
      if (!frame.extended) frame.id &= 0x7FFU;
      return frame;
    case 2:
      frame.kind = frame.kind == can::FrameKind::fd ? can::FrameKind::data : can::FrameKind::fd;
      frame.length = std::min<std::uint8_t>(frame.length, 8);
      frame.fd_flags = 0;
      return frame;
    case 3:
      if (frame.kind == can::FrameKind::data) frame.kind = can::FrameKind::remote;
      return frame;
    default:
      frame.data[pick(frame.length)] ^= static_cast<std::uint8_t>(1U << pick(8));
      return frame;
  }
}

}  // namespace hystcan::firmware
