#include "can/sim/sim_wire.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace hystcan::can::sim {

Wire::Wire(VirtualClock& clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& config)
    : clock_(clock),
      bit_ns_(1e9 / bitrate_bit_per_s),
      start_(clock.now()),
      free_at_(start_),
      disturbance_(config.bit_error, config.seed),
      recovery_(clock, bit_ns_, config.restart_after, [this](Node& node) { on_recovery_timer(node); }) {
  timer_ = clock_.make_timer([this] {
    const auto keep = shared_from_this();  // a handler may destroy the last node and the bus
    if (on_wire_) {
      finish();
    } else {
      arbitrate();
    }
  });
  note_faults();
}

Duration Wire::duration_of(unsigned bits) const {
  return Duration{static_cast<Duration::rep>(std::llround(bits * bit_ns_))};
}

// ---- Sending

void Wire::contend() {
  if (on_wire_ || contending_) return;
  contending_ = true;
  timer_->expire_at(std::max(clock_.now(), free_at_));
}

void Wire::arbitrate() {
  contending_ = false;
  const Time now = clock_.now();
  Node* winner = nullptr;
  std::size_t contenders = 0;
  for (const auto& node : nodes_) {
    if (node->key == never || node->suspended_until > now) continue;
    ++contenders;
    if (node->key < (winner != nullptr ? winner->key : never)) winner = node.get();
  }
  if (winner == nullptr) {
    await_suspended();
    return;
  }
  if (contenders > 1) count_losers(*winner);
  frame_ = winner->pop();
  sender_ = winner;
  on_wire_ = true;
  recovery_.frame_begins(nodes_);
  fate_ = disturbance_.draw(frame_, *sender_, nodes_);
  free_at_ = now + duration_of(fate_.bits);
  busy_ += free_at_ - now;
  timer_->expire_at(now + duration_of(fate_.bits - interframe_bits));
}

/// All nodes with a frame to send are error-passive and pause. Another node may send before they do.
void Wire::await_suspended() {
  std::optional<Time> earliest;
  for (const auto& node : nodes_) {
    if (node->key == never) continue;
    earliest = earliest ? std::min(*earliest, node->suspended_until) : node->suspended_until;
  }
  if (earliest) timer_->expire_at(*earliest);
}

void Wire::count_losers(const Node& winner) {
  for (const auto& node : nodes_) {
    if (node.get() != &winner && node->key != never && node->suspended_until <= clock_.now())
      ++node->counters.arbitration_lost;
  }
}

// ---- The end of a frame

void Wire::finish() {
  calling_handlers_ = true;
  const std::size_t present = nodes_.size();  // a node that a handler attaches does not receive the frame
  if (fate_.ending == Ending::delivered) {
    deliver(present);
  } else {
    destroy(present);
  }
  calling_handlers_ = false;
  on_wire_ = false;
  sender_ = nullptr;
  remove_detached();
  recovery_.frame_ended(nodes_, free_at_);
  if (std::ranges::any_of(nodes_, [](const auto& node) { return node->key != never; })) contend();
}

void Wire::deliver(std::size_t present) {
  const Time received = clock_.now();
  if (sender_ != nullptr) {
    sender_->confinement.transmitted();
    suspend_if_passive(*sender_);
    report_state(*sender_);
    if (sender_->on_sent) sender_->on_sent(frame_, received);
  }
  for (std::size_t i = 0; i < present; ++i) {
    Node& node = *nodes_[i];
    if (&node == sender_ || !node.listens()) continue;
    if (disturbance_.is_active() && misses(node)) continue;
    node.confinement.received();
    report_state(node);
    ++node.counters.received;
    if (node.on_frame) node.on_frame(frame_, received);
  }
}

bool Wire::misses(Node& node) {
  if (std::exchange(node.missed, false)) {
    count_error(node);
    node.confinement.receive_error();
    return true;
  }
  if (!disturbance_.overruns(node)) return false;
  node.confinement.received();
  ++node.counters.controller_overflows;
  ++node.counters.error_frames;
  return true;
}

void Wire::destroy(std::size_t present) {
  for (std::size_t i = 0; i < present; ++i) {
    Node& node = *nodes_[i];
    if (!node.listens()) continue;
    node.missed = false;
    if (&node == sender_) {
      count_sender_error(node);
    } else {
      count_error(node);
      node.confinement.receive_error();
      if (fate_.witness == &node) node.confinement.dominant_after_error_flag();
    }
    report_state(node);
  }
}

void Wire::count_sender_error(Node& node) {
  if (fate_.ending == Ending::not_acknowledged) {
    ++node.counters.not_acknowledged;
    ++node.counters.error_frames;
    node.confinement.not_acknowledged();
  } else {
    count_error(node);
    node.confinement.transmit_error();
  }
  if (node.confinement.bus_off()) {
    recovery_.go_off(node);
    return;
  }
  node.give_back(frame_);
  suspend_if_passive(node);
}

void Wire::count_error(Node& node) {
  ++node.counters.protocol_errors;
  ++node.counters.error_frames;
}

void Wire::suspend_if_passive(Node& node) {
  if (node.confinement.passive()) node.suspended_until = free_at_ + duration_of(suspend_bits);
}

void Wire::report_state(Node& node) {
  const BusState state = node.confinement.state();
  if (state == node.reported) return;
  node.reported = state;
  ++node.counters.error_frames;
  if (state == BusState::warning) ++node.counters.warnings;
  if (state == BusState::passive) ++node.counters.passives;
  if (state == BusState::bus_off) ++node.counters.bus_offs;
  if (node.on_state) node.on_state(state);
}

// ---- Bus-off and recovery

void Wire::request_restart(Node& node) {
  std::optional<Time> recessive_since;
  if (!on_wire_) recessive_since = std::max(clock_.now(), free_at_);
  recovery_.request_restart(node, recessive_since);
}

void Wire::on_recovery_timer(Node& node) {
  const auto keep = shared_from_this();
  if (node.recovery == Recovery::waiting) {
    request_restart(node);
    return;
  }
  recovery_.come_back(node);
  calling_handlers_ = true;
  report_state(node);
  calling_handlers_ = false;
  remove_detached();
}

// ---- Attaching and detaching nodes

Node& Wire::attach(TransmitOrder order) { return *nodes_.emplace_back(std::make_unique<Node>(order)); }

void Wire::detach(Node& node) {
  node.attached = false;
  node.forget_frames();
  any_detached_ = true;
  if (!calling_handlers_) remove_detached();
}

void Wire::remove_detached() {
  if (!std::exchange(any_detached_, false)) return;
  std::erase_if(nodes_, [this](const auto& node) {
    if (node->attached) return false;
    if (node.get() == sender_) sender_ = nullptr;
    if (node.get() == fate_.witness) fate_.witness = nullptr;
    recovery_.forget(*node);
    return true;
  });
  note_faults();
}

void Wire::set_bit_error(double probability) {
  disturbance_.set_bit_error(probability);
  note_faults();
}

double Wire::load() const {
  const Duration elapsed = clock_.now() - start_;
  if (elapsed <= Duration::zero()) return 0.0;
  const Duration ahead = std::max(free_at_ - clock_.now(), Duration::zero());
  return static_cast<double>((busy_ - ahead).count()) / static_cast<double>(elapsed.count());
}

}  // namespace hystcan::can::sim
