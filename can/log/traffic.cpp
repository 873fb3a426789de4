#include "can/log/traffic.h"

#include <linux/can/error.h>

#include <cmath>

#include "can/log/error_frame.h"

namespace hystcan::can {
namespace {

/// The maximum payload of a frame; a longer message uses several frames (J1939).
constexpr std::size_t max_frame_bytes = Frame{}.data.size();

bool is_protected_as_ours(const Message& message) {
  const Signal* counter = message.find("Counter");
  const Signal* crc = message.find("Crc");
  return counter != nullptr && crc != nullptr && message.length >= 2 && message.length <= max_frame_bytes &&
         is_decodable(*counter) && is_decodable(*crc) && bytes_needed(*counter) <= message.length &&
         counter->length <= 8 && crc->length == 8 && crc->start_bit == 8U * (message.length - 1U) &&
         crc->byte_order == ByteOrder::little_endian;
}

/// Finds the signals for counter and CRC of a message. Returns nullopt if neither the configuration nor the
/// signal names define them. If several messages have the same name, the configuration applies to the first
/// message with this name.
std::optional<Protection> find_protection(const Database& database, const Message& message,
                                          const Protections& configured) {
  if (message.length > max_frame_bytes) return std::nullopt;
  const auto found = configured.find(message.name);
  if (found != configured.end() && database.find(message.name) == &message) return found->second;
  if (!is_protected_as_ours(message)) return std::nullopt;
  return Protection{SignalCodec(*message.find("Counter")), SignalCodec(*message.find("Crc"))};
}

std::size_t length_on_the_wire(const Message& message) {
  if (message.length > max_frame_bytes) return message.length;
  return wire_length(static_cast<std::uint8_t>(message.length));
}

}  // namespace

Traffic::Traffic(const Database& database, const Protections& configured) : database_(database) {
  for (const Message& message : database_.messages) {
    const Key key{message.extended, message.id};
    known_.emplace(key, &message);
    if (const auto protection = find_protection(database_, message, configured))
      checkers_.emplace(key, E2eChecker(*protection, static_cast<std::uint8_t>(message.length),
                                        message.extended, message.fd));
  }
}

void Traffic::add(const LoggedFrame& logged) {
  const Frame& frame = logged.frame;
  if (frame.kind == FrameKind::error) return add_error(frame);
  ++frames_;
  ++frames_of_period_;
  Key key{frame.extended, frame.id};
  auto known = known_.find(key);
  if (const Key other{!frame.extended, frame.id}; known == known_.end() && checkers_.contains(other)) {
    key = other;
    known = known_.find(key);
  }
  MessageTraffic& traffic = messages_[key];
  Period& period = periods_[key];
  traffic.message = known == known_.end() ? nullptr : known->second;
  ++traffic.count;
  ++period.frames;
  if (const auto rejection = check(key, traffic.message, frame)) {
    ++traffic.rejected[static_cast<std::size_t>(*rejection)];
    return;
  }
  if (traffic.newest) {
    const double interval_s = std::chrono::duration<double>(logged.time - traffic.newest->time).count();
    ++period.intervals;
    const double deviation_s = interval_s - period.mean_s;
    period.mean_s += deviation_s / static_cast<double>(period.intervals);
    period.squares_s2 += deviation_s * (interval_s - period.mean_s);
  }
  traffic.last = logged.time;
  traffic.newest = logged;
}

std::optional<Rejection> Traffic::check(const Key& key, const Message* message, const Frame& frame) {
  if (message == nullptr) return std::nullopt;
  if (const auto checker = checkers_.find(key); checker != checkers_.end())
    return checker->second.check(frame);
  const bool may_be_fd = wire_kind(message->length, message->fd) == FrameKind::fd;
  if (frame.kind == FrameKind::remote || (frame.kind == FrameKind::fd && !may_be_fd))
    return Rejection::wrong_kind;
  if (frame.length != length_on_the_wire(*message)) return Rejection::wrong_length;
  return std::nullopt;
}

void Traffic::add_error(const Frame& frame) {
  if (drops_reported_by(frame)) return;
  ++error_frames_;
  if (const auto state = interpret(frame).state) state_ = state;
  const bool has_counters = (frame.id & CAN_ERR_CNT) != 0 || frame.data[6] != 0 || frame.data[7] != 0;
  if (has_counters) error_counters_ = ErrorCounters{frame.data[6], frame.data[7]};
}

void Traffic::end_period(std::chrono::duration<double> period) {
  const auto rate = [&](std::uint64_t frames) { return static_cast<double>(frames) / period.count(); };
  rate_Hz_ = rate(frames_of_period_);
  frames_of_period_ = 0;
  for (auto& [key, traffic] : messages_) {
    Period& of_message = periods_[key];
    traffic.rate_Hz = rate(of_message.frames);
    traffic.jitter_ms.reset();
    if (of_message.intervals >= 2)
      traffic.jitter_ms =
          1e3 * std::sqrt(of_message.squares_s2 / static_cast<double>(of_message.intervals - 1));
    of_message = Period{};
  }
}

}  // namespace hystcan::can
