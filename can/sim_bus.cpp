#include "can/sim_bus.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "can/sim_node.h"

namespace hystcan::can {
namespace {

using sim::never;
using sim::Node;
using sim::Recovery;

double probability(double value, const char* name) {
  if (!(value >= 0.0 && value <= 1.0))
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + ", expected 0 to 1");
  return value;
}

/// How the frame on the wire will end.
struct Fate {
  enum class Ending : std::uint8_t { delivered, not_acknowledged, destroyed };
  Ending ending = Ending::delivered;
  unsigned bits = 0;              ///< up to the end of the interframe space
  const Node* witness = nullptr;  ///< the node that alone saw the error first; null: all did
};
using Ending = Fate::Ending;

}  // namespace

struct SimBus::Wire : std::enable_shared_from_this<Wire> {
  Wire(VirtualClock& its_clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& its_config)
      : clock(its_clock),
        bit_ns(1e9 / bitrate_bit_per_s),
        start(its_clock.now()),
        free_at(start),
        config(its_config),
        random(its_config.seed) {
    timer = clock.make_timer([this] {
      const auto keep = shared_from_this();  // a handler may drop the last node and the bus
      if (on_wire) {
        finish();
      } else {
        arbitrate();
      }
    });
    note_faults();
  }

  Duration bits_last(unsigned bits) const {
    return Duration{static_cast<Duration::rep>(std::llround(bits * bit_ns))};
  }

  // ---- Sending

  /// Nodes that send at this very instant still take part.
  void contend() {
    if (on_wire || contending) return;
    contending = true;
    timer->expire_at(std::max(clock.now(), free_at));
  }

  void arbitrate() {
    contending = false;
    const Time now = clock.now();
    Node* winner = nullptr;
    std::size_t contenders = 0;
    for (const auto& node : nodes) {
      if (node->key == never || node->suspended_until > now) continue;
      ++contenders;
      if (node->key < (winner != nullptr ? winner->key : never)) winner = node.get();
    }
    if (winner == nullptr) {
      await_suspended();
      return;
    }
    if (contenders > 1) count_losers(*winner);
    frame = winner->pop();
    sender = winner;
    on_wire = true;
    if (nodes_off != 0) stop_counting_recessive();
    fate = fate_of_frame();
    free_at = now + bits_last(fate.bits);
    busy += free_at - now;
    timer->expire_at(now + bits_last(fate.bits - interframe_bits));
  }

  /// Only error-passive nodes have something to send, and pause. Another may come first.
  void await_suspended() {
    std::optional<Time> earliest;
    for (const auto& node : nodes) {
      if (node->key == never) continue;
      earliest = earliest ? std::min(*earliest, node->suspended_until) : node->suspended_until;
    }
    if (earliest) timer->expire_at(*earliest);
  }

  void count_losers(const Node& winner) {
    for (const auto& node : nodes) {
      if (node.get() != &winner && node->key != never && node->suspended_until <= clock.now())
        ++node->counters.arbitration_lost;
    }
  }

  // ---- Errors

  void note_faults() {
    faulty = config.bit_error > 0.0 || std::ranges::any_of(nodes, [](const auto& node) {
               const NodeFaults& f = node->faults;
               return f.transmit_bit_error > 0.0 || f.receive_bit_error > 0.0 || f.overrun > 0.0;
             });
  }

  double uniform() { return static_cast<double>(random() >> 11U) * 0x1p-53; }

  /// The first bit in error where each of them is so with this probability: geometric. `none` or later: not
  /// in this frame.
  unsigned first_error(double per_bit, unsigned none) {
    if (per_bit <= 0.0) return none;
    if (per_bit >= 1.0) return 0;
    const double bit = std::log1p(-uniform()) / std::log1p(-per_bit);
    return bit < none ? static_cast<unsigned>(bit) : none;
  }

  Fate fate_of_frame() {
    const unsigned whole = frame_bits(frame);
    const bool acknowledged = std::ranges::any_of(
        nodes, [this](const auto& node) { return node.get() != sender && node->listens(); });
    // The error flag begins at the ACK delimiter, which with the end of frame makes eight bits.
    const unsigned heard = whole - interframe_bits - (acknowledged ? 0 : 8);
    if (faulty) {
      if (const auto destroyed = error_within(heard)) return *destroyed;
    }
    if (acknowledged) return {.ending = Ending::delivered, .bits = whole};
    return {.ending = Ending::not_acknowledged,
            .bits = heard + error_flag_bits + error_delimiter_bits + interframe_bits};
  }

  std::optional<Fate> error_within(unsigned bits) {
    unsigned first = first_error(config.bit_error, bits);
    const Node* witness = nullptr;
    const auto take = [&](const Node& node, unsigned bit) {
      if (bit >= first) return;
      first = bit;
      witness = &node;
    };
    take(*sender, first_error(sender->faults.transmit_bit_error, bits));
    for (const auto& node : nodes) {
      if (node.get() == sender || !node->listens()) continue;
      const unsigned bit = first_error(node->faults.receive_bit_error, bits);
      if (bit == bits) continue;
      if (node->confinement.passive()) {
        node->missed = true;  // its flag is recessive: nobody notices
      } else {
        take(*node, bit);
      }
    }
    if (first == bits) return std::nullopt;
    const unsigned flags = witness == nullptr ? error_flag_bits : error_flags_max_bits - dominant_before();
    return Fate{.ending = Ending::destroyed,
                .bits = first + 1 + flags + error_delimiter_bits + interframe_bits,
                .witness = witness};
  }

  /// Dominant bits just before a flag, 0..4: by so many the others' stuff error, and so their flags, come
  /// earlier.
  unsigned dominant_before() {
    return std::min<unsigned>(static_cast<unsigned>(std::countr_one(random())), 4);
  }

  // ---- The end of a frame

  void finish() {
    calling_handlers = true;
    const std::size_t present = nodes.size();  // who attaches now has not heard the frame
    if (fate.ending == Ending::delivered) {
      deliver(present);
    } else {
      destroy(present);
    }
    calling_handlers = false;
    on_wire = false;
    sender = nullptr;
    sweep();
    if (nodes_off != 0) count_recessive();
    if (std::ranges::any_of(nodes, [](const auto& node) { return node->key != never; })) contend();
  }

  void deliver(std::size_t present) {
    const Time received = clock.now();
    if (sender != nullptr) {
      sender->confinement.transmitted();
      suspend_if_passive(*sender);
      tell_state(*sender);
    }
    for (std::size_t i = 0; i < present; ++i) {
      Node& node = *nodes[i];
      if (&node == sender || !node.listens()) continue;
      if (faulty && misses(node)) continue;
      node.confinement.received();
      tell_state(node);
      ++node.counters.received;
      if (node.on_frame) node.on_frame(frame, received);
    }
  }

  bool misses(Node& node) {
    if (std::exchange(node.missed, false)) {
      count_error(node);
      node.confinement.receive_error();
      return true;
    }
    if (node.faults.overrun <= 0.0 || uniform() >= node.faults.overrun) return false;
    node.confinement.received();
    ++node.counters.controller_overflows;
    ++node.counters.error_frames;
    return true;
  }

  void destroy(std::size_t present) {
    for (std::size_t i = 0; i < present; ++i) {
      Node& node = *nodes[i];
      if (!node.listens()) continue;
      node.missed = false;
      if (&node == sender) {
        charge_sender(node);
      } else {
        count_error(node);
        node.confinement.receive_error();
        if (fate.witness == &node) node.confinement.dominant_after_error_flag();
      }
      tell_state(node);
    }
  }

  void charge_sender(Node& node) {
    if (fate.ending == Ending::not_acknowledged) {
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
    node.give_back(frame);
    suspend_if_passive(node);
  }

  static void count_error(Node& node) {
    ++node.counters.protocol_errors;
    ++node.counters.error_frames;
  }

  void suspend_if_passive(Node& node) {
    if (node.confinement.passive()) node.suspended_until = free_at + bits_last(suspend_bits);
  }

  static void tell_state(Node& node) {
    const BusState state = node.confinement.state();
    if (state == node.told) return;
    node.told = state;
    ++node.counters.error_frames;
    if (state == BusState::warning) ++node.counters.warnings;
    if (state == BusState::passive) ++node.counters.passives;
    if (state == BusState::bus_off) ++node.counters.bus_offs;
    if (node.on_state) node.on_state(state);
  }

  // ---- Bus-off and the way back

  void go_off(Node& node) {
    node.off = true;
    node.forget_frames();
    node.recovery = Recovery::waiting;
    ++nodes_off;
    if (!node.recovery_timer) {
      node.recovery_timer = clock.make_timer([this, &node] {
        const auto keep = shared_from_this();
        if (node.recovery == Recovery::waiting) {
          request_restart(node);
        } else {
          come_back(node);
        }
      });
    }
    if (config.restart_after) node.recovery_timer->expire_at(clock.now() + *config.restart_after);
  }

  void request_restart(Node& node) {
    if (node.recovery != Recovery::waiting) return;
    node.recovery = Recovery::counting;
    node.sequences_left = recovery_sequences;
    node.recovery_timer->cancel();
    if (!on_wire) expect_recessive(node, std::max(clock.now(), free_at));
  }

  void expect_recessive(Node& node, Time since) const {
    node.recessive_since = since;
    node.recovery_timer->expire_at(since + bits_last(node.sequences_left * recovery_sequence_bits));
  }

  /// A frame begins: what has stood recessive up to now counts.
  void stop_counting_recessive() {
    for (const auto& node : nodes) {
      if (node->recovery != Recovery::counting) continue;
      const double stood_ns = static_cast<double>((clock.now() - node->recessive_since).count()) + 0.5;
      const auto sequences =
          static_cast<unsigned>(std::max(stood_ns, 0.0) / (bit_ns * recovery_sequence_bits));
      if (sequences >= node->sequences_left) continue;  // comes back at this very instant
      node->sequences_left -= sequences;
      node->recovery_timer->cancel();
    }
  }

  /// Every frame, whole or destroyed, ends in eleven recessive bits, the interframe space the last of them.
  void count_recessive() {
    for (const auto& node : nodes) {
      if (node->recovery != Recovery::counting) continue;
      --node->sequences_left;
      expect_recessive(*node, free_at);
    }
  }

  void come_back(Node& node) {
    node.off = false;
    node.recovery = Recovery::none;
    --nodes_off;
    node.confinement.restart();
    node.suspended_until = Time{};
    ++node.counters.restarts;
    calling_handlers = true;
    tell_state(node);
    calling_handlers = false;
    sweep();
  }

  // ---- Coming and going

  void detach(Node& node) {
    node.attached = false;
    node.forget_frames();
    any_detached = true;
    if (!calling_handlers) sweep();
  }

  void sweep() {
    if (!std::exchange(any_detached, false)) return;
    std::erase_if(nodes, [this](const auto& node) {
      if (node->attached) return false;
      if (node.get() == sender) sender = nullptr;
      if (node.get() == fate.witness) fate.witness = nullptr;
      if (node->off) --nodes_off;
      return true;
    });
    note_faults();
  }

  VirtualClock& clock;
  double bit_ns;
  Time start;
  Time free_at;  ///< end of the interframe space after the latest frame
  Duration busy{};
  SimBusConfig config;
  std::mt19937_64 random;
  std::vector<std::unique_ptr<Node>> nodes;
  Frame frame;  ///< the one on the wire
  Fate fate;
  Node* sender = nullptr;
  std::size_t nodes_off = 0;
  bool faulty = false;  ///< anything is to be drawn at random
  bool on_wire = false;
  bool contending = false;
  bool calling_handlers = false;
  bool any_detached = false;
  std::unique_ptr<Timer> timer;
};

class SimBus::Port final : public SimNode {
 public:
  explicit Port(std::shared_ptr<Wire> wire)
      : wire_(std::move(wire)), node_(*wire_->nodes.emplace_back(std::make_unique<Node>())) {}
  ~Port() override { wire_->detach(node_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  bool send(const Frame& frame) override {
    if (!node_.push(frame)) {
      ++node_.counters.send_refused;
      return false;
    }
    ++node_.counters.sent;
    wire_->contend();
    return true;
  }

  void on_frame(FrameHandler handler) override { node_.on_frame = std::move(handler); }
  void on_state(StateHandler handler) override { node_.on_state = std::move(handler); }
  BusState state() const override { return node_.told; }
  std::optional<ErrorCounters> error_counters() const override { return node_.confinement.counters(); }
  const BusCounters& counters() const override { return node_.counters; }

  void set_faults(const NodeFaults& faults) override {
    probability(faults.transmit_bit_error, "transmit_bit_error");
    probability(faults.receive_bit_error, "receive_bit_error");
    probability(faults.overrun, "overrun");
    node_.faults = faults;
    wire_->note_faults();
  }
  void restart() override { wire_->request_restart(node_); }

 private:
  std::shared_ptr<Wire> wire_;
  Node& node_;
};

SimBus::SimBus(VirtualClock& clock, std::uint32_t bitrate_bit_per_s, const SimBusConfig& config)
    : wire_(std::make_shared<Wire>(clock, bitrate_bit_per_s, config)) {
  if (bitrate_bit_per_s == 0) throw std::invalid_argument("bit rate 0, expected more");
  probability(config.bit_error, "bit_error");
}
SimBus::~SimBus() = default;

std::unique_ptr<SimNode> SimBus::attach() { return std::make_unique<Port>(wire_); }

void SimBus::set_bit_error(double value) {
  wire_->config.bit_error = probability(value, "bit_error");
  wire_->note_faults();
}

double SimBus::load() const {
  const Duration elapsed = wire_->clock.now() - wire_->start;
  if (elapsed <= Duration::zero()) return 0.0;
  const Duration ahead = std::max(wire_->free_at - wire_->clock.now(), Duration::zero());
  return static_cast<double>((wire_->busy - ahead).count()) / static_cast<double>(elapsed.count());
}

}  // namespace hystcan::can
