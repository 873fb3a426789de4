// How a frame on the simulated wire ends: errors drawn at random, an acknowledgement that does not come.
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
  unsigned bits = 0;              ///< up to the end of the interframe space
  const Node* witness = nullptr;  ///< the node that alone saw the error first; null: all did
};

using Nodes = std::span<const std::unique_ptr<Node>>;

/// Each bit is in error with a probability, for all nodes or for one; the first error ends the frame.
class Disturbance {
 public:
  /// `bit_error`: for all nodes at once.
  Disturbance(double bit_error, std::uint64_t seed) : bit_error_(bit_error), random_(seed) {}

  void set_bit_error(double probability) { bit_error_ = probability; }
  /// To be told when a node comes, goes, or changes its faults.
  void note_faults(Nodes nodes);
  /// Anything is drawn at random.
  bool is_there() const { return is_there_; }

  /// Error-passive nodes that alone see an error are marked: they miss the frame.
  Fate draw(const Frame& frame, const Node& sender, Nodes nodes);
  /// The frame that all others have heard is lost in the node's full receive buffer.
  bool overruns(const Node& node) { return node.faults.overrun > 0.0 && uniform() < node.faults.overrun; }

 private:
  std::optional<Fate> error_within(unsigned bits, const Node& sender, Nodes nodes);
  unsigned first_error(double per_bit, unsigned none);
  unsigned dominant_before();
  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

  double bit_error_;
  std::mt19937_64 random_;
  bool is_there_ = false;
};

}  // namespace hystcan::can::sim
