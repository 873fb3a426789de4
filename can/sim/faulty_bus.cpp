#include "can/sim/faulty_bus.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace hystcan::can {
namespace {

void check(const FaultRule& rule) {
  const std::string name(to_string(rule.fault));
  if (!(rule.probability >= 0.0 && rule.probability <= 1.0))
    throw std::invalid_argument(name + ": probability " + std::to_string(rule.probability) +
                                ", expected 0 to 1");
  if (rule.delay <= Duration::zero()) throw std::invalid_argument(name + ": delay expected to be above 0");
}

}  // namespace

std::string_view to_string(BusFault fault) {
  constexpr std::array<std::string_view, bus_fault_count> names = {
      "lose",       "delay",          "duplicate",    "reorder",          "corrupt payload",
      "corrupt id", "corrupt length", "corrupt kind", "corrupt extension"};
  return names[static_cast<std::size_t>(fault)];
}

FaultyBus::FaultyBus(std::unique_ptr<Bus> within, Scheduler& scheduler, FaultyBusConfig config)
    : within_(std::move(within)), scheduler_(scheduler), config_(std::move(config)), random_(config_.seed) {
  std::ranges::for_each(config_.rules, check);
  for (Held& held : held_) {
    held.timer = scheduler_.make_timer([this, &held] { release(held); });
  }
  within_->on_frame([this](const Frame& frame, Time received) { pass(frame, Direction::receive, received); });
}

void FaultyBus::set_rules(std::vector<FaultRule> rules) {
  std::ranges::for_each(rules, check);
  config_.rules = std::move(rules);
}

bool FaultyBus::send(const Frame& frame) { return pass(frame, Direction::transmit, scheduler_.now()); }

bool FaultyBus::pass(const Frame& frame, Direction direction, Time received) {
  if (config_.rules.empty() && held_count_ == 0) return deliver(frame, direction, received);
  return apply_rules(frame, direction, received);
}

bool FaultyBus::apply_rules(Frame frame, Direction direction, Time received) {
  bool twice = false;
  for (const FaultRule& rule : config_.rules) {
    if (!applies(rule, frame, direction)) continue;
    switch (rule.fault) {
      case BusFault::lose:
        count(rule.fault);
        return true;
      case BusFault::delay:
      case BusFault::reorder:
        if (!hold(frame, direction, rule)) break;
        count(rule.fault);
        return true;
      case BusFault::duplicate:
        count(rule.fault);
        twice = true;
        break;
      default:
        if (corrupt(frame, rule.fault)) count(rule.fault);
    }
  }
  const bool passed = deliver(frame, direction, received);
  if (twice) deliver(frame, direction, received);
  release_reordered(direction);
  return passed;
}

bool FaultyBus::deliver(const Frame& frame, Direction direction, Time received) {
  if (direction == Direction::transmit) return within_->send(frame);
  if (handler_) handler_(frame, received);
  return true;
}

bool FaultyBus::applies(const FaultRule& rule, const Frame& frame, Direction direction) {
  if (!(direction == Direction::receive ? rule.on_receive : rule.on_transmit)) return false;
  if (rule.only && (rule.only->id != frame.id || rule.only->extended != frame.extended)) return false;
  return uniform() < rule.probability;
}

bool FaultyBus::hold(const Frame& frame, Direction direction, const FaultRule& rule) {
  const auto free = std::ranges::find(held_, false, &Held::taken);
  if (free == held_.end()) return false;
  free->frame = frame;
  free->direction = direction;
  free->taken = true;
  ++held_count_;
  free->until_next = rule.fault == BusFault::reorder;
  const double share = free->until_next ? 1.0 : 1.0 - uniform();
  const auto wait = static_cast<Duration::rep>(share * static_cast<double>(rule.delay.count()));
  free->timer->expire_at(scheduler_.now() + Duration{std::max<Duration::rep>(wait, 1)});
  return true;
}

void FaultyBus::release(Held& held) {
  held.timer->cancel();
  held.taken = false;
  --held_count_;
  const Frame frame = held.frame;
  deliver(frame, held.direction, scheduler_.now());
}

void FaultyBus::release_reordered(Direction direction) {
  for (Held& held : held_) {
    if (held.taken && held.until_next && held.direction == direction) release(held);
  }
}

bool FaultyBus::corrupt(Frame& frame, BusFault fault) {
  switch (fault) {
    case BusFault::corrupt_payload:
      return flip_payload_bit(frame);
    case BusFault::corrupt_id:
      frame.id ^= 1U << below(frame.extended ? 29 : 11);
      return true;
    case BusFault::corrupt_length: {
      const unsigned other = below(frame.length <= 8 ? 8 : 9);  // one of the lengths 0..8 but its own
      frame.length = static_cast<std::uint8_t>(other >= frame.length ? other + 1 : other);
      return true;
    }
    case BusFault::corrupt_kind:
      if (frame.kind != FrameKind::data) return false;
      frame.kind = below(2) == 0 ? FrameKind::remote : FrameKind::fd;
      return true;
    case BusFault::corrupt_extension:
      frame.extended = !frame.extended;
      if (!frame.extended) frame.id &= 0x7FFU;
      return true;
    default:
      return false;
  }
}

bool FaultyBus::flip_payload_bit(Frame& frame) {
  if (frame.length == 0) return false;
  const unsigned bit = below(8U * frame.length);
  frame.data[bit / 8] = static_cast<std::uint8_t>(frame.data[bit / 8] ^ 1U << bit % 8);
  return true;
}

}  // namespace hystcan::can
