#include "twin/faulty_connection.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace hystcan::twin {
namespace {

using enum Fault;

/// Identifier of the frames of a babbling node: the highest priority that no node uses. The identifier 0 has
/// a higher priority, but is an NMT command, and the nodes would obey it.
constexpr std::uint32_t babble_id = 0x001;

bool is_of(const can::Filter& filter, const can::Frame& frame) {
  return frame.id == filter.id && frame.extended == filter.extended;
}

}  // namespace

SentMessage::SentMessage(const can::Message& message, const can::MessageMap& map, std::string_view value_role,
                         std::string_view value_unit)
    : filter_{.id = message.id, .extended = message.extended}, protection_(protection_of(message, map)) {
  if (const auto named = map.signals.find(value_role); named != map.signals.end()) {
    const can::Signal& signal = can::find_signal(message, named->second);
    value_.emplace(signal);
    if (const auto step = can::decimal_step(signal.unit, std::string(value_unit))) step_ = *step;
  }
  if (const auto named = map.signals.find("status"); named != map.signals.end())
    status_.emplace(can::find_signal(message, named->second));
}

std::int64_t SentMessage::counter(const can::Frame& frame) const {
  return protection_.counter ? protection_.counter->unpack_raw(frame.payload()) : 0;
}

void SentMessage::put_value(can::Frame& frame, std::int64_t raw) const {
  if (value_) value_->pack_raw(raw, frame.payload());
}

void SentMessage::put_physical(can::Frame& frame, double value) const {
  if (!value_) return;
  const double nearest = std::clamp(step_.to_theirs(value), value_->minimum(), value_->maximum());
  // pack() can't fail: `nearest` is within the limits of the signal.
  static_cast<void>(value_->pack(nearest, frame.payload()));
}

void SentMessage::put_bad_status(can::Frame& frame) const {
  if (status_) status_->pack_raw(1, frame.payload());
}

void SentMessage::put_counter(can::Frame& frame, std::int64_t raw) const {
  if (protection_.counter) protection_.counter->pack_raw(raw, frame.payload());
}

void SentMessage::seal(can::Frame& frame) const {
  if (protection_.crc) protection_.crc->pack_raw(protection_.crc_of(frame), frame.payload());
}

void SentMessage::corrupt_crc(can::Frame& frame) const {
  if (protection_.crc)
    protection_.crc->pack_raw(protection_.crc->unpack_raw(frame.payload()) ^ 0x10, frame.payload());
}

std::optional<SentMessage> sent_by(Node node, const can::Database& database, const can::AxisWire& wire) {
  const bool by_sensor = node == Node::sensor;
  const auto map =
      by_sensor ? can::message_map<can::SensorSample>(wire) : can::message_map<can::AmpStatus>(wire);
  if (!map) return std::nullopt;
  return SentMessage(can::find_message(database, *map), *map, by_sensor ? "position" : "output",
                     by_sensor ? "um" : wire.drive_unit);
}

FaultyConnection::FaultyConnection(std::unique_ptr<can::Bus> within, can::Scheduler& scheduler,
                                   const Config& config)
    : within_(std::move(within)),
      scheduler_(scheduler),
      config_(config),
      random_(config.seed),
      babbles_(scheduler.make_timer([this] { babble(); })) {}

void FaultyConnection::begin(Fault kind, double number, std::size_t channel) {
  value(kind, channel) = number;
  note_faults();
  if (kind == emergency)
    put(can::emergency_frame(config_.node,
                             {.code = static_cast<std::uint16_t>(number), .error_register = 0x01}));
  if (kind == babbling_node) babbles_->expire_at(scheduler_.now());
}

void FaultyConnection::end(Fault kind, std::size_t channel) {
  if (!std::exchange(value(kind, channel), std::nullopt)) return;
  note_faults();
  if (kind == frozen_value) channels_[channel].frozen_value.reset();
  if (kind == sensor_gain) channels_[channel].gain_from.reset();
  for (Channel& one : channels_) {
    if (kind == frozen_counter) one.frozen_counter.reset();
    if (kind == out_of_order) one.overtaken.reset();
    if (kind == late) one.late_count = 0;
  }
  if (kind == babbling_node) babbles_->cancel();
  if (kind == emergency) put(can::emergency_frame(config_.node, {}));
}

void FaultyConnection::note_faults() {
  const auto any = [](const ActiveFaults& on) {
    return std::ranges::any_of(on, &std::optional<double>::has_value);
  };
  is_faulty_ = any(on_) || std::ranges::any_of(channels_, any, &Channel::on);
}

FaultyConnection::Channel* FaultyConnection::channel_of(const can::Frame& frame) {
  const auto found = std::ranges::find_if(
      channels_, [&](const Channel& channel) { return channel.sends && channel.sends->is(frame); });
  return found == channels_.end() ? nullptr : &*found;
}

void FaultyConnection::on_frame(FrameHandler handler) {
  within_->on_frame([this, handler = std::move(handler)](const can::Frame& frame, can::Time received) {
    if (!is_faulty_ || !misses(frame)) handler(frame, received);
  });
}

bool FaultyConnection::misses(const can::Frame& frame) {
  if (is_on(node_reboot) || is_on(bus_off)) return true;
  if (is_on(watchdog_trip) && config_.obeys && is_of(*config_.obeys, frame)) return true;
  return is_on(error_passive) && uniform() < value_of(error_passive);
}

bool FaultyConnection::loses(const can::Frame& frame) {
  if (is_on(node_reboot) || is_on(bus_off)) return true;
  if (is_on(no_heartbeat) && is_of({.id = can::heartbeat_base + config_.node}, frame)) return true;
  return is_on(no_reply) &&
         (channel_of(frame) != nullptr || is_of({.id = can::sdo_response_base + config_.node}, frame));
}

/// Passes a frame to the bus and returns true if it was sent. A frame that is lost by a fault counts as sent.
bool FaultyConnection::put(can::Frame frame) {
  if (loses(frame)) return true;
  if (channel_of(frame) == nullptr) return within_->send(frame);
  if (is_on(wrong_length)) {  // replaces the frame's length by a random different length, 0 to 8
    const auto other = static_cast<std::uint8_t>(uniform() * (frame.length <= 8 ? 8 : 9));
    frame.length = static_cast<std::uint8_t>(other >= frame.length ? other + 1 : other);
  }
  if (is_on(wrong_id_type)) {
    frame.extended = !frame.extended;
    if (!frame.extended) frame.id &= 0x7FFU;
  }
  const bool passed = within_->send(frame);
  if (is_on(duplicate)) within_->send(frame);
  return passed;
}

bool FaultyConnection::send(const can::Frame& frame) {
  if (!is_faulty_) return within_->send(frame);
  Channel* const first = channel_of(frame);
  if (first == nullptr) return put(frame);
  can::Frame corrupted = frame;
  corrupt(corrupted, *first);
  return is_on(late) ? pass_late(corrupted, *first) : pass_in_order(corrupted, *first);
}

void FaultyConnection::corrupt(can::Frame& frame, Channel& first) {
  for (Channel& channel : channels_)
    if (channel.sends && channel.sends->is(frame)) change_value(frame, channel);
  const SentMessage& message = *first.sends;
  if (is_on(frozen_counter)) {
    if (!first.frozen_counter) first.frozen_counter = message.counter(frame);
    message.put_counter(frame, *first.frozen_counter);
  }
  message.seal(frame);
  if (is_on(wrong_crc)) message.corrupt_crc(frame);
}

void FaultyConnection::change_value(can::Frame& frame, Channel& channel) {
  const SentMessage& message = *channel.sends;
  const auto on = [&](Fault kind) { return channel.on[static_cast<std::size_t>(kind)]; };
  if (on(frozen_value)) {
    if (!channel.frozen_value) channel.frozen_value = message.value(frame);
    message.put_value(frame, *channel.frozen_value);
  }
  if (const auto gain = on(sensor_gain)) {
    const double value = message.physical(frame);
    if (!channel.gain_from) channel.gain_from = value;
    message.put_physical(frame, *channel.gain_from + *gain * (value - *channel.gain_from));
  }
  if (const auto offset = on(sensor_offset)) message.put_physical(frame, message.physical(frame) + *offset);
  if (const auto value = on(out_of_range)) message.put_physical(frame, *value);
  if (on(sensor_bad_status)) message.put_bad_status(frame);
}

bool FaultyConnection::pass_in_order(const can::Frame& frame, Channel& first) {
  if (!is_on(out_of_order)) return put(frame);
  if (!first.overtaken) {
    first.overtaken = frame;
    return true;
  }
  const bool passed = put(frame);
  return put(*std::exchange(first.overtaken, std::nullopt)) && passed;
}

bool FaultyConnection::pass_late(const can::Frame& frame, Channel& first) {
  const auto delay = static_cast<std::size_t>(value_of(late));
  while (first.late_count > delay) {  // drops the oldest frames if the delay became shorter
    first.oldest_late = (first.oldest_late + 1) % held_frames;
    --first.late_count;
  }
  first.late[(first.oldest_late + first.late_count++) % held_frames] = frame;
  if (first.late_count <= delay) return true;
  const can::Frame& due = first.late[first.oldest_late];
  first.oldest_late = (first.oldest_late + 1) % held_frames;
  --first.late_count;
  return pass_in_order(due, first);
}

void FaultyConnection::babble() {
  can::Frame frame{.id = babble_id, .length = 8};
  frame.data.fill(0);
  std::fill_n(frame.data.begin(), frame.length, std::uint8_t{0x55});
  put(frame);
  const auto period = static_cast<can::Duration::rep>(1e9 / value_of(babbling_node));
  babbles_->expire_at(scheduler_.now() + can::Duration{period});
}

}  // namespace hystcan::twin
