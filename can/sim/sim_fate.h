// How a frame on the simulated wire ends: delivered, destroyed by a random error, or not acknowledged.
// Internal to the simulated bus.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>

#include "can/sim/sim_node.h"

namespace hystcan::can::sim {

enum class Ending : std::uint8_t { delivered, not_acknowledged, destroyed };

struct Fate {
  Ending ending = Ending::delivered;
  unsigned bits = 0;              ///< from start of frame to the end of the interframe space
  const Node* witness = nullptr;  ///< the one node that saw the error first; null: all saw it at once
};

using Nodes = std::span<const std::unique_ptr<Node>>;

/// Draws the bit errors. Each bit has an error with a given probability, for all nodes or for one node. The
/// first error ends the frame.
class Disturbance {
 public:
  /// `bit_error` is the probability of an error for all nodes at once.
  Disturbance(double bit_error, std::uint64_t seed) : bit_error_(bit_error), random_(seed) {}

  void set_bit_error(double probability) { bit_error_ = probability; }
  /// The wire calls this function when a node is attached or detached, or changes its faults.
  void note_faults(Nodes nodes);
  /// True: at least one probability is above 0.
  bool is_active() const { return is_active_; }

  /// Marks the error-passive nodes that miss the frame, because they alone see an error.
  Fate draw(const Frame& frame, const Node& sender, Nodes nodes);
  /// True: the node alone loses the frame in its full receive buffer.
  bool overruns(const Node& node) { return node.faults.overrun > 0.0 && uniform() < node.faults.overrun; }

 private:
  std::optional<Fate> error_within(unsigned bits, const Node& sender, Nodes nodes);
  unsigned first_error(double per_bit, unsigned none);
  unsigned dominant_bits_before_flag();
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

  double bit_error_;
  std::mt19937_64 random_;
  bool is_active_ = false;
};

}  // namespace hystcan::can::sim
