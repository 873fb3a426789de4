#include "can/sim/sim_recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::can::sim {

BusOffRecovery::BusOffRecovery(VirtualClock& clock, double bit_ns, std::optional<Duration> restart_after,
                               TimerHandler on_timer)
    : clock_(clock), bit_ns_(bit_ns), restart_after_(restart_after), on_timer_(std::move(on_timer)) {}

void BusOffRecovery::go_off(Node& node) {
  node.off = true;
  node.forget_frames();
  node.recovery = Recovery::waiting;
  ++nodes_off_;
  if (!node.recovery_timer) node.recovery_timer = clock_.make_timer([this, &node] { on_timer_(node); });
  if (restart_after_) node.recovery_timer->expire_at(clock_.now() + *restart_after_);
}

void BusOffRecovery::request_restart(Node& node, std::optional<Time> recessive_since) {
  if (node.recovery != Recovery::waiting) return;
  node.recovery = Recovery::counting;
  node.sequences_left = recovery_sequences;
  node.recovery_timer->cancel();
  if (recessive_since) expect_recessive(node, *recessive_since);
}

void BusOffRecovery::expect_recessive(Node& node, Time since) const {
  node.recessive_since = since;
  const double ns = node.sequences_left * recovery_sequence_bits * bit_ns_;
  node.recovery_timer->expire_at(since + Duration{static_cast<Duration::rep>(std::llround(ns))});
}

void BusOffRecovery::frame_begins(Nodes nodes) {
  if (!any_off()) return;
  for (const auto& node : nodes) {
    if (node->recovery != Recovery::counting) continue;
    const double stood_ns = static_cast<double>((clock_.now() - node->recessive_since).count()) + 0.5;
    const auto sequences =
        static_cast<unsigned>(std::max(stood_ns, 0.0) / (bit_ns_ * recovery_sequence_bits));
    if (sequences >= node->sequences_left) continue;  // the node recovers at this instant
    node->sequences_left -= sequences;
    node->recovery_timer->cancel();
  }
}

void BusOffRecovery::frame_ended(Nodes nodes, Time free_at) {
  if (!any_off()) return;
  for (const auto& node : nodes) {
    if (node->recovery != Recovery::counting) continue;
    --node->sequences_left;
    expect_recessive(*node, free_at);
  }
}

void BusOffRecovery::come_back(Node& node) {
  node.off = false;
  node.recovery = Recovery::none;
  --nodes_off_;
  node.confinement.restart();
  node.suspended_until = Time{};
  ++node.counters.restarts;
}

void BusOffRecovery::forget(const Node& node) {
  if (node.off) --nodes_off_;
}

}  // namespace hystcan::can::sim
