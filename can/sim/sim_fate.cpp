#include "can/sim/sim_fate.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace hystcan::can::sim {

void Disturbance::note_faults(Nodes nodes) {
  is_active_ = bit_error_ > 0.0 || std::ranges::any_of(nodes, [](const auto& node) {
                 const NodeFaults& f = node->faults;
                 return f.transmit_bit_error > 0.0 || f.receive_bit_error > 0.0 || f.overrun > 0.0;
               });
}

Fate Disturbance::draw(const Frame& frame, const Node& sender, Nodes nodes) {
  const unsigned whole = frame_bits(frame);
  const bool acknowledged =
      std::ranges::any_of(nodes, [&](const auto& node) { return node.get() != &sender && node->listens(); });
  // The error flag begins at the ACK delimiter. The ACK delimiter and the end of frame have eight bits.
  const unsigned heard = whole - interframe_bits - (acknowledged ? 0 : 8);
  if (is_active_) {
    if (const auto destroyed = error_within(heard, sender, nodes)) return *destroyed;
  }
  if (acknowledged) return {.ending = Ending::delivered, .bits = whole};
  return {.ending = Ending::not_acknowledged,
          .bits = heard + error_flag_bits + error_delimiter_bits + interframe_bits};
}

std::optional<Fate> Disturbance::error_within(unsigned bits, const Node& sender, Nodes nodes) {
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
      node->missed = true;  // its flag is recessive: no other node sees it
    } else {
      take(*node, bit);
    }
  }
  if (first == bits) return std::nullopt;
  const unsigned flags =
      witness == nullptr ? error_flag_bits : error_flags_max_bits - dominant_bits_before_flag();
  return Fate{.ending = Ending::destroyed,
              .bits = first + 1 + flags + error_delimiter_bits + interframe_bits,
              .witness = witness};
}

/// Draws the first bit in error, with the probability `per_bit` for each bit (geometric distribution).
/// Returns `none` if no bit of this frame is in error.
unsigned Disturbance::first_error(double per_bit, unsigned none) {
  if (per_bit <= 0.0) return none;
  if (per_bit >= 1.0) return 0;
  const double bit = std::log1p(-uniform()) / std::log1p(-per_bit);
  return bit < none ? static_cast<unsigned>(bit) : none;
}

/// Draws the number of dominant bits just before an error flag, 0..4. The stuff error of the other nodes, and
/// with it their flags, come earlier by this number of bits.
unsigned Disturbance::dominant_bits_before_flag() {
  return std::min<unsigned>(static_cast<unsigned>(std::countr_one(random_())), 4);
}

}  // namespace hystcan::can::sim
