#include "can/sim_bus.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::can {
namespace {

constexpr std::uint32_t never = 0xFFFF'FFFF;

/// The arbitration field as a number, in the order in which its bits pass: the lowest wins.
std::uint32_t arbitration_key(const Frame& frame) {
  const std::uint32_t remote = frame.kind == FrameKind::remote ? 1 : 0;
  if (!frame.extended) return frame.id << 21U | remote << 20U;
  return frame.id >> 18U << 21U | std::uint32_t{3} << 19U | (frame.id & 0x3FFFFU) << 1U | remote;
}

bool can_be_sent(const Frame& frame) {
  if (frame.id > (frame.extended ? 0x1FFF'FFFFU : 0x7FFU)) return false;
  switch (frame.kind) {
    case FrameKind::data:
    case FrameKind::remote:
      return frame.length <= 8;
    case FrameKind::fd:
      return frame.length <= frame.data.size();
    case FrameKind::error:
      return false;
  }
  return false;
}

struct Node {
  Bus::FrameHandler on_frame;
  BusCounters counters;
  std::array<Frame, SimBus::transmit_queue_length> queue;
  std::size_t oldest = 0;
  std::size_t queued = 0;
  std::uint32_t key = never;  ///< of the oldest frame
  bool attached = true;

  bool push(const Frame& frame) {
    if (queued == queue.size() || !can_be_sent(frame)) return false;
    queue[(oldest + queued) % queue.size()] = frame;
    ++queued;
    if (queued == 1) key = arbitration_key(frame);
    return true;
  }

  Frame pop() {
    const Frame& frame = queue[oldest];
    oldest = (oldest + 1) % queue.size();
    --queued;
    key = queued == 0 ? never : arbitration_key(queue[oldest]);
    return frame;
  }
};

}  // namespace

struct SimBus::Wire : std::enable_shared_from_this<Wire> {
  Wire(VirtualClock& its_clock, std::uint32_t bitrate_bit_per_s)
      : clock(its_clock), bit_ns(1e9 / bitrate_bit_per_s), start(its_clock.now()), free_at(start) {
    timer = clock.make_timer([this] {
      const auto keep = shared_from_this();  // a handler may drop the last node and the bus
      if (on_wire) {
        deliver();
      } else {
        arbitrate();
      }
    });
  }

  Duration bits_last(unsigned bits) const {
    return Duration{static_cast<Duration::rep>(std::llround(bits * bit_ns))};
  }

  /// Nodes that send at this very instant still take part.
  void contend() {
    if (on_wire || contending) return;
    contending = true;
    timer->expire_at(std::max(clock.now(), free_at));
  }

  void arbitrate() {
    contending = false;
    Node* winner = nullptr;
    for (const auto& node : nodes) {
      if (node->key < (winner != nullptr ? winner->key : never)) winner = node.get();
    }
    if (winner == nullptr) return;
    frame = winner->pop();
    sender = winner;
    on_wire = true;
    const unsigned bits = frame_bits(frame);
    free_at = clock.now() + bits_last(bits);
    busy += free_at - clock.now();
    timer->expire_at(clock.now() + bits_last(bits - interframe_bits));
  }

  void deliver() {
    const Time received = clock.now();
    delivering = true;
    const std::size_t present = nodes.size();  // who attaches now has not heard the frame
    for (std::size_t i = 0; i < present; ++i) {
      Node& node = *nodes[i];
      if (&node == sender || !node.attached) continue;
      ++node.counters.received;
      if (node.on_frame) node.on_frame(frame, received);
    }
    delivering = false;
    on_wire = false;
    sender = nullptr;
    sweep();
    if (std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node->queued != 0; }))
      contend();
  }

  void detach(Node& node) {
    node.attached = false;
    node.queued = 0;
    node.key = never;
    any_detached = true;
    if (!delivering) sweep();
  }

  void sweep() {
    if (!std::exchange(any_detached, false)) return;
    std::erase_if(nodes, [this](const auto& node) {
      if (node.get() == sender && !node->attached) sender = nullptr;
      return !node->attached;
    });
  }

  VirtualClock& clock;
  double bit_ns;
  Time start;
  Time free_at;  ///< end of the interframe space after the latest frame
  Duration busy{};
  std::vector<std::unique_ptr<Node>> nodes;
  Frame frame;  ///< the one on the wire
  const Node* sender = nullptr;
  bool on_wire = false;
  bool contending = false;
  bool delivering = false;
  bool any_detached = false;
  std::unique_ptr<Timer> timer;
};

class SimBus::Port final : public Bus {
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
  void on_state(StateHandler) override {}
  BusState state() const override { return BusState::active; }
  const BusCounters& counters() const override { return node_.counters; }

 private:
  std::shared_ptr<Wire> wire_;
  Node& node_;
};

SimBus::SimBus(VirtualClock& clock, std::uint32_t bitrate_bit_per_s)
    : wire_(std::make_shared<Wire>(clock, bitrate_bit_per_s)) {
  if (bitrate_bit_per_s == 0) throw std::invalid_argument("bit rate 0, expected more");
}
SimBus::~SimBus() = default;

std::unique_ptr<Bus> SimBus::attach() { return std::make_unique<Port>(wire_); }

double SimBus::load() const {
  const Duration elapsed = wire_->clock.now() - wire_->start;
  if (elapsed <= Duration::zero()) return 0.0;
  const Duration ahead = std::max(wire_->free_at - wire_->clock.now(), Duration::zero());
  return static_cast<double>((wire_->busy - ahead).count()) / static_cast<double>(elapsed.count());
}

}  // namespace hystcan::can
