// The Preisach model as in textbooks: a triangle of relays, each of which is evaluated at every step. The
// tests compare the Everett form (model/preisach.h) with this model in outputs and in speed.
#pragma once

#include <cstddef>
#include <vector>

#include "model/preisach.h"

namespace hystcan::support {

/// The levels are N + 1 equidistant inputs. With input v, relay (i, j), j <= i, switches
///
///   on at v >= level(i + 1),   off at v <= level(j).
///
/// At these inputs, each cell of the Everett form is also either completely on or completely off.
class Relays {
 public:
  explicit Relays(const model::PreisachParameters& parameters) : p_(parameters) {
    while (levels_ * (levels_ + 1) / 2 < p_.weights.size()) ++levels_;
    on_.assign(p_.weights.size(), 0.0);
  }

  double level(std::size_t i) const {
    return p_.input_range.lo + p_.input_range.span() * static_cast<double>(i) / static_cast<double>(levels_);
  }
  std::size_t levels() const { return levels_; }

  double advance(double v) {
    double sum = 0.0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < levels_; ++i) {
      const bool up = v >= level(i + 1);
      for (std::size_t j = 0; j <= i; ++j, ++n) {
        if (up) on_[n] = 1.0;
        if (v <= level(j)) on_[n] = 0.0;
        sum += p_.weights[n] * on_[n];
      }
    }
    return p_.offset + p_.gain * (v - p_.input_range.lo) + sum;
  }

 private:
  model::PreisachParameters p_;
  std::size_t levels_ = 0;
  std::vector<double> on_;
};

}  // namespace hystcan::support
