#include "twin/faulty_connection.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace hystcan::twin {
namespace {

using enum Fault;

/// The identifier of the highest priority that no node uses: 0 is NMT, which nodes would follow.
constexpr std::uint32_t babble_id = 0x001;

/// Adds the rules by which one active fault acts on frames.
void add_rules(std::vector<can::FaultRule>& rules, Fault kind, double value, const can::Filter& message,
               const can::Filter& command, std::uint8_t node) {
  using can::BusFault;
  const auto sent = [&](BusFault fault, const can::Filter& only) {
    rules.push_back(
        {.fault = fault, .probability = 1.0, .on_receive = false, .on_transmit = true, .only = only});
  };
  const auto heard = [&](double probability, std::optional<can::Filter> only) {
    rules.push_back({.fault = BusFault::lose, .probability = probability, .only = only});
  };
  switch (kind) {
    case no_reply:
      sent(BusFault::lose, {.id = can::sdo_response_base + node});
      return sent(BusFault::lose, message);
    case no_heartbeat:
      return sent(BusFault::lose, {.id = can::heartbeat_base + node});
    case duplicate:
      return sent(BusFault::duplicate, message);
    case wrong_length:
      return sent(BusFault::corrupt_length, message);
    case wrong_id_type:
      return sent(BusFault::corrupt_extension, message);
    case watchdog_trip:
      return heard(1.0, command);
    case error_passive:
      return heard(value, std::nullopt);
    case node_reboot:
    case bus_off:
      rules.push_back({.fault = BusFault::lose, .probability = 1.0, .on_transmit = true, .only = {}});
      return;
    default:
      return;
  }
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
  // The limits of the signal can be packed exactly.
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
    : bus_(std::move(within), scheduler, {.seed = config.seed, .rules = {}}),
      scheduler_(scheduler),
      config_(config),
      babbles_(scheduler.make_timer([this] { babble(); })) {}

void FaultyConnection::begin(Fault kind, double value) {
  on_[static_cast<std::size_t>(kind)] = value;
  set_rules();
  if (kind == emergency)
    bus_.send(can::emergency_frame(config_.node,
                                   {.code = static_cast<std::uint16_t>(value), .error_register = 0x01}));
  if (kind == babbling_node) babbles_->expire_at(scheduler_.now());
}

void FaultyConnection::end(Fault kind) {
  if (!std::exchange(on_[static_cast<std::size_t>(kind)], std::nullopt)) return;
  set_rules();
  if (kind == frozen_value) frozen_value_.reset();
  if (kind == frozen_counter) frozen_counter_.reset();
  if (kind == sensor_gain) gain_from_.reset();
  if (kind == out_of_order) overtaken_.reset();
  if (kind == late) late_count_ = 0;
  if (kind == babbling_node) babbles_->cancel();
  if (kind == emergency) bus_.send(can::emergency_frame(config_.node, {}));
}

void FaultyConnection::set_rules() {
  constexpr std::array changes{late,         out_of_order,      frozen_value, frozen_counter, wrong_crc,
                               out_of_range, sensor_bad_status, sensor_gain,  sensor_offset};
  corrupts_ = config_.sends && std::ranges::any_of(changes, [this](Fault kind) { return is_on(kind); });
  constexpr can::Filter nothing{.id = 0xFFFF'FFFF};
  const can::Filter message = config_.sends ? config_.sends->filter() : nothing;
  std::vector<can::FaultRule> rules;
  for (std::size_t i = 0; i < fault_count; ++i)
    if (on_[i])
      add_rules(rules, static_cast<Fault>(i), *on_[i], message, config_.obeys.value_or(nothing),
                config_.node);
  bus_.set_rules(std::move(rules));
}

bool FaultyConnection::send(const can::Frame& frame) {
  if (!corrupts_ || !config_.sends->is(frame)) return bus_.send(frame);
  can::Frame corrupted = frame;
  corrupt(corrupted);
  return is_on(late) ? pass_late(corrupted) : pass_in_order(corrupted);
}

void FaultyConnection::corrupt(can::Frame& frame) {
  const SentMessage& message = *config_.sends;
  if (is_on(frozen_value)) {
    if (!frozen_value_) frozen_value_ = message.value(frame);
    message.put_value(frame, *frozen_value_);
  }
  if (is_on(sensor_gain)) {
    const double value = message.physical(frame);
    if (!gain_from_) gain_from_ = value;
    message.put_physical(frame, *gain_from_ + value_of(sensor_gain) * (value - *gain_from_));
  }
  if (is_on(sensor_offset)) message.put_physical(frame, message.physical(frame) + value_of(sensor_offset));
  if (is_on(out_of_range)) message.put_physical(frame, value_of(out_of_range));
  if (is_on(sensor_bad_status)) message.put_bad_status(frame);
  if (is_on(frozen_counter)) {
    if (!frozen_counter_) frozen_counter_ = message.counter(frame);
    message.put_counter(frame, *frozen_counter_);
  }
  message.seal(frame);
  if (is_on(wrong_crc)) message.corrupt_crc(frame);
}

bool FaultyConnection::pass_in_order(const can::Frame& frame) {
  if (!is_on(out_of_order)) return bus_.send(frame);
  if (!overtaken_) {
    overtaken_ = frame;
    return true;
  }
  const bool passed = bus_.send(frame);
  return bus_.send(*std::exchange(overtaken_, std::nullopt)) && passed;
}

bool FaultyConnection::pass_late(const can::Frame& frame) {
  const auto delay = static_cast<std::size_t>(value_of(late));
  while (late_count_ > delay) {  // the delay has become shorter
    oldest_late_ = (oldest_late_ + 1) % held_frames;
    --late_count_;
  }
  late_[(oldest_late_ + late_count_++) % held_frames] = frame;
  if (late_count_ <= delay) return true;
  const can::Frame& due = late_[oldest_late_];
  oldest_late_ = (oldest_late_ + 1) % held_frames;
  --late_count_;
  return pass_in_order(due);
}

void FaultyConnection::babble() {
  can::Frame frame{.id = babble_id, .length = 8};
  frame.data.fill(0);
  std::fill_n(frame.data.begin(), frame.length, std::uint8_t{0x55});
  bus_.send(frame);
  const auto period = static_cast<can::Duration::rep>(1e9 / value_of(babbling_node));
  babbles_->expire_at(scheduler_.now() + can::Duration{period});
}

}  // namespace hystcan::twin
