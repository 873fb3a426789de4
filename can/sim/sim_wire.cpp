#include "can/sim/sim_wire.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace hystcan::can::sim {

// ---- Errors on the wire

namespace {

BitCount followed_by_error_frame(BitCount bits, unsigned flags) {
  bits.nominal += flags + error_delimiter_bits + interframe_bits;
  return bits;
}

}  // namespace

void Disturbance::note_faults(Nodes nodes) {
  is_active_ = bit_error_ > 0.0 || std::ranges::any_of(nodes, [](const auto& node) {
                 const NodeFaults& f = node->faults;
                 return f.transmit_bit_error > 0.0 || f.receive_bit_error > 0.0 || f.overrun > 0.0;
               });
}

Transmission Disturbance::draw(const Frame& frame, const Node& sender, Nodes nodes) {
  const FrameBits whole = frame_bits(frame);
  const bool acknowledged =
      std::ranges::any_of(nodes, [&](const auto& node) { return node.get() != &sender && node->listens(); });
  // Without an acknowledgement, an error flag replaces the ACK delimiter and the end of frame, eight bits.
  const unsigned bits = whole.total() - interframe_bits - (acknowledged ? 0 : 8);
  if (is_active_) {
    if (const auto destroyed = error_within(whole, bits, sender, nodes)) return *destroyed;
  }
  if (acknowledged) return {.end = Transmission::End::delivered, .bits = whole.all()};
  return {.end = Transmission::End::not_acknowledged,
          .bits = followed_by_error_frame(whole.first(bits), error_flag_bits)};
}

std::optional<Transmission> Disturbance::error_within(const FrameBits& frame, unsigned bits,
                                                      const Node& sender, Nodes nodes) {
  unsigned first = first_error(bit_error_, bits);
  const Node* witness = nullptr;
  const auto take = [&](const Node& node, unsigned bit) {
    if (bit >= first) return;
    first = bit;
    witness = &node;
  };
  take(sender, first_error(sender.faults.transmit_bit_error, bits));
  for (const auto& node : nodes) {
    if (node.get() == &sender || !node->listens()) continue;
    const unsigned bit = first_error(node->faults.receive_bit_error, bits);
    if (bit == bits) continue;
    if (node->confinement.passive()) {
      node->missed = true;  // other nodes do not detect the recessive error flag of this node
    } else {
      take(*node, bit);
    }
  }
  if (first == bits) return std::nullopt;
  const unsigned flags =
      witness == nullptr ? error_flag_bits : error_flags_max_bits - dominant_bits_before_flag();
  return Transmission{.end = Transmission::End::destroyed,
                      .bits = followed_by_error_frame(frame.first(first + 1), flags),
                      .witness = witness};
}

/// Returns a random index of the first bit with an error; each bit has an error with probability `per_bit`
/// (geometric distribution). Returns `none`, the number of bits, if no bit of the frame has an error.
unsigned Disturbance::first_error(double per_bit, unsigned none) {
  if (per_bit <= 0.0) return none;
  if (per_bit >= 1.0) return 0;
  const double bit = std::log1p(-uniform()) / std::log1p(-per_bit);
  return bit < none ? static_cast<unsigned>(bit) : none;
}

/// Returns a random number of dominant bits directly before the six dominant bits of an error flag, 0..4.
/// With them, other nodes detect six equal bits, and send their own flags, earlier by this number of bits.
unsigned Disturbance::dominant_bits_before_flag() {
  return std::min<unsigned>(static_cast<unsigned>(std::countr_one(random_())), 4);
}

// ---- Which nodes receive the frames of an identifier

void Receivers::add(Node& node) {
  if (node.filters.empty()) {
    unfiltered_.push_back(&node);
    for (auto& [id, nodes] : filtered_) nodes.push_back(&node);
  }
  for (const Filter& filter : node.filters) {
    std::vector<Node*>& nodes = filtered_.try_emplace(filter.id, unfiltered_).first->second;
    if (nodes.empty() || nodes.back() != &node) nodes.push_back(&node);
  }
}

void Receivers::remove(Node& node) {
  std::erase(unfiltered_, &node);
  for (auto& [id, nodes] : filtered_) std::erase(nodes, &node);
}

// ---- Construction of the wire, and duration of bits

Wire::Wire(VirtualClock& clock, const BitRates& rates, const SimBusConfig& config)
    : clock_(clock),
      bit_ns_(1e9 / rates.nominal_bit_per_s),
      data_bit_ns_(rates.data_bit_per_s == 0 ? bit_ns_ : 1e9 / rates.data_bit_per_s),
      start_(clock.now()),
      free_at_(start_),
      disturbance_(config.bit_error, config.seed),
      restart_after_(config.restart_after) {
  timer_ = clock_.make_timer([this] {
    const auto keep = shared_from_this();  // a handler may destroy the bus and its last node
    if (on_wire_) {
      finish();
    } else {
      arbitrate();
    }
  });
  note_faults();
}

Duration Wire::duration_of(const BitCount& bits) const {
  return Duration{
      static_cast<Duration::rep>(std::llround(bits.nominal * bit_ns_ + bits.data * data_bit_ns_))};
}

// ---- Sending a frame: queue and arbitration

bool Wire::send(Node& node, const Frame& frame) {
  if (!node.push(frame)) return false;
  note_pending(node);
  contend();
  return true;
}

/// Updates pending_, the list of nodes with a frame to send, after the queue of `node` changed.
void Wire::note_pending(Node& node) {
  const auto place = std::ranges::find(pending_, &node);
  if ((place != pending_.end()) == (node.key != never)) return;
  if (node.key != never)
    pending_.push_back(&node);
  else
    pending_.erase(place);
}

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
  for (Node* node : pending_) {
    if (node->suspended_until > now) continue;
    ++contenders;
    if (winner == nullptr || std::pair(node->key, node->number) < std::pair(winner->key, winner->number))
      winner = node;
  }
  if (winner == nullptr) {
    await_suspended();
    return;
  }
  if (contenders > 1) count_losers(*winner);
  frame_ = winner->pop();
  note_pending(*winner);
  if (frame_.kind == FrameKind::fd)
    frame_.fd_flags = static_cast<std::uint8_t>((frame_.fd_flags & ~fd_error_state) |
                                                (winner->confinement.passive() ? fd_error_state : 0));
  sender_ = winner;
  on_wire_ = true;
  count_recessive_bits();
  transmission_ = disturbance_.draw(frame_, *sender_, nodes_);
  free_at_ = now + duration_of(transmission_.bits);
  busy_ += free_at_ - now;
  const auto [nominal, data] = transmission_.bits;
  timer_->expire_at(now + duration_of({.nominal = nominal - interframe_bits, .data = data}));
}

/// Waits for the earliest end of a pause: all nodes in pending_ are error-passive and pause after a frame.
void Wire::await_suspended() {
  std::optional<Time> earliest;
  for (const Node* node : pending_)
    earliest = earliest ? std::min(*earliest, node->suspended_until) : node->suspended_until;
  if (earliest) timer_->expire_at(*earliest);
}

void Wire::count_losers(const Node& winner) {
  const Time now = clock_.now();
  for (Node* node : pending_)
    if (node != &winner && node->suspended_until <= now) ++node->counters.arbitration_lost;
}

// ---- The end of a frame: delivery or error

void Wire::finish() {
  calling_handlers_ = true;
  const std::size_t present = nodes_.size();  // a node that a handler attaches now does not get this frame
  if (transmission_.end == Transmission::End::delivered) {
    deliver(present);
  } else {
    destroy(present);
  }
  calling_handlers_ = false;
  on_wire_ = false;
  sender_ = nullptr;
  remove_detached();
  add_recessive_end();
  if (!pending_.empty()) contend();
}

void Wire::deliver(std::size_t present) {
  if (sender_ != nullptr) {
    sender_->confinement.transmitted();
    suspend_if_passive(*sender_);
    report_state(*sender_);
    if (sender_->on_sent) sender_->on_sent(frame_, clock_.now());
  }
  if (disturbance_.is_active() || any_receive_error_) return deliver_and_count_errors(present);
  const std::vector<Node*>& receivers = receivers_.of(frame_.id);
  const std::size_t count = receivers.size();
  for (std::size_t i = 0; i < count; ++i)
    if (receivers[i] != sender_ && receivers[i]->listens()) pass_to(*receivers[i]);
}

void Wire::deliver_and_count_errors(std::size_t present) {
  for (std::size_t i = 0; i < present; ++i) {
    Node& node = *nodes_[i];
    if (&node == sender_ || !node.listens()) continue;
    if (disturbance_.is_active() && misses(node)) continue;
    node.confinement.received();
    report_state(node);
    if (node.receives(frame_.id)) pass_to(node);
  }
  any_receive_error_ =
      std::ranges::any_of(nodes_, [](const auto& node) { return node->confinement.counters().receive != 0; });
}

void Wire::pass_to(Node& node) {
  ++node.counters.received;
  if (node.on_frame) node.on_frame(frame_, clock_.now());
}

bool Wire::misses(Node& node) {
  if (std::exchange(node.missed, false)) {
    any_receive_error_ = true;
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
  any_receive_error_ = true;
  for (std::size_t i = 0; i < present; ++i) {
    Node& node = *nodes_[i];
    if (!node.listens()) continue;
    node.missed = false;
    if (&node == sender_) {
      count_sender_error(node);
    } else {
      count_error(node);
      node.confinement.receive_error();
      if (transmission_.witness == &node) node.confinement.dominant_after_error_flag();
    }
    report_state(node);
  }
}

void Wire::count_sender_error(Node& node) {
  if (transmission_.end == Transmission::End::not_acknowledged) {
    ++node.counters.not_acknowledged;
    ++node.counters.error_frames;
    node.confinement.not_acknowledged();
  } else {
    count_error(node);
    node.confinement.transmit_error();
  }
  if (node.confinement.bus_off()) {
    go_off(node);
    return;
  }
  node.give_back(frame_);
  note_pending(node);
  suspend_if_passive(node);
}

void Wire::count_error(Node& node) {
  ++node.counters.protocol_errors;
  ++node.counters.error_frames;
}

void Wire::suspend_if_passive(Node& node) {
  if (node.confinement.passive()) node.suspended_until = free_at_ + duration_of({.nominal = suspend_bits});
}

void Wire::report_state(Node& node) {
  const BusState state = node.confinement.state();
  if (state == node.reported) return;
  node.reported = state;
  ++node.counters.error_frames;
  node.counters.count_entry(state);
  if (node.on_state) node.on_state(state);
}

// ---- Bus-off and recovery (ISO 11898-1): a restart request, then 128 times 11 recessive bits

void Wire::go_off(Node& node) {
  node.off = true;
  node.forget_frames();
  note_pending(node);
  node.recovery = Recovery::waiting;
  ++nodes_off_;
  if (!node.recovery_timer)
    node.recovery_timer = clock_.make_timer([this, &node] { on_recovery_timer(node); });
  if (restart_after_) node.recovery_timer->expire_at(clock_.now() + *restart_after_);
}

void Wire::request_restart(Node& node) {
  if (node.recovery != Recovery::waiting) return;
  node.recovery = Recovery::counting;
  node.sequences_left = recovery_sequences;
  node.recovery_timer->cancel();
  if (!on_wire_) expect_recessive(node, std::max(clock_.now(), free_at_));
}

void Wire::expect_recessive(Node& node, Time since) const {
  node.recessive_since = since;
  node.recovery_timer->expire_at(since +
                                 duration_of({.nominal = node.sequences_left * recovery_sequence_bits}));
}

/// When a frame begins: counts the recessive bits of the idle bus before it, for nodes in bus-off recovery.
void Wire::count_recessive_bits() {
  if (nodes_off_ == 0) return;
  for (const auto& node : nodes_) {
    if (node->recovery != Recovery::counting) continue;
    const double stood_ns = static_cast<double>((clock_.now() - node->recessive_since).count()) + 0.5;
    const auto sequences =
        static_cast<unsigned>(std::max(stood_ns, 0.0) / (bit_ns_ * recovery_sequence_bits));
    if (sequences >= node->sequences_left) continue;  // the node recovers at this instant
    node->sequences_left -= sequences;
    node->recovery_timer->cancel();
  }
}

/// Counts the eleven recessive bits at the end of a frame for each node that recovers from bus-off. A
/// complete and a destroyed frame both end with these bits, interframe space included.
void Wire::add_recessive_end() {
  if (nodes_off_ == 0) return;
  for (const auto& node : nodes_) {
    if (node->recovery != Recovery::counting) continue;
    --node->sequences_left;
    expect_recessive(*node, free_at_);
  }
}

void Wire::on_recovery_timer(Node& node) {
  const auto keep = shared_from_this();
  if (node.recovery == Recovery::waiting) return request_restart(node);
  come_back(node);
  calling_handlers_ = true;
  report_state(node);
  calling_handlers_ = false;
  remove_detached();
}

void Wire::come_back(Node& node) {
  node.off = false;
  node.recovery = Recovery::none;
  --nodes_off_;
  node.confinement.restart();
  node.suspended_until = Time{};
  ++node.counters.restarts;
}

// ---- Attaching and detaching nodes

Node& Wire::attach(TransmitOrder order, std::span<const Filter> filters) {
  Node& node = *nodes_.emplace_back(std::make_unique<Node>(attached_++, order, filters));
  receivers_.add(node);
  pending_.reserve(nodes_.size());
  return node;
}

void Wire::detach(Node& node) {
  node.attached = false;
  node.forget_frames();
  note_pending(node);
  any_detached_ = true;
  if (!calling_handlers_) remove_detached();
}

void Wire::remove_detached() {
  if (!std::exchange(any_detached_, false)) return;
  std::erase_if(nodes_, [this](const auto& node) {
    if (node->attached) return false;
    if (node.get() == sender_) sender_ = nullptr;
    if (node.get() == transmission_.witness) transmission_.witness = nullptr;
    if (node->off) --nodes_off_;
    receivers_.remove(*node);
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
