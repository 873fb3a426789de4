// The Preisach model on a grid, computed with its Everett function: a classical model for comparison.
//
//   x = x_lo + gain (v - v_lo) + sum_ij w_ij relay_ij[v],     relay in {0, 1}
//
// The plane of switching inputs (up at alpha, down at beta <= alpha) is divided into N (N + 1) / 2 cells of
// equal side h = span / N.  The weight w_ij of row i (alpha) and column j <= i (beta) is spread evenly over
// its cell, so that the output is continuous; a cell on the diagonal is a triangle.  A branch that starts at
// (v_s, x_s) is
//
//   rising     x_s + gain (v - v_s) + E(v, v_s)
//   falling    x_s - gain (v_s - v) - E(v_s, v)
//
//   E(alpha, beta) = weight of the relays (alpha', beta') with  beta <= beta' <= alpha' <= alpha
//
// Loops between the same inputs are congruent (Mayergoyz 1986).  Memory, wiping out and alignment are the
// same as in every memory-based model.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "model/memory_model.h"

namespace hystcan::model {

struct PreisachParameters {
  std::string input_unit;
  std::string output_unit;
  Interval input_range;
  double offset = 0.0;  ///< x_lo: output at v_lo with all relays off
  double gain = 0.0;    ///< slope of the reversible part, output units per input unit, >= 0
  /// Weights w_00, w_10, w_11, w_20, ... of the cells, output units, >= 0. Cell ij: relays that switch up in
  /// the i-th of N equal parts of the input range, and down in the j-th part, j <= i. These are N (N + 1) / 2
  /// cells.
  std::vector<double> weights;
};

/// The law of a branch: its output as a function of the input. Branch::offset and Branch::coefficient are not
/// used.
class EverettLaw {
 public:
  using Parameters = PreisachParameters;
  /// Throws std::invalid_argument if the range is not lo < hi, if a number is not finite, if gain or a weight
  /// is negative, or if the output would not rise from the lower to the upper threshold. Also throws if the
  /// number of weights is not N (N + 1) / 2 for a whole number N.
  explicit EverettLaw(PreisachParameters parameters);

  const PreisachParameters& parameters() const { return parameters_; }
  static constexpr std::string_view kind() { return "preisach"; }
  std::uint64_t fingerprint() const;
  const Interval& input_range() const { return parameters_.input_range; }
  Symmetry symmetry() const { return Symmetry::none; }

  Branch threshold_branch(Direction direction) const;
  Branch virgin_branch() const { return threshold_branch(Direction::ascending); }
  Branch reversed(const HysteresisState& state) const;
  double value(const Branch& branch, Direction direction, double input) const;
  Jet jet(const Branch& branch, Direction direction, double input) const;
  static double third_derivative_bound(const Branch&, Direction) {
    return std::numeric_limits<double>::infinity();  // the slope has kinks at the borders of the cells
  }

 private:
  struct Cell {
    std::size_t index = 0;  // number of the row or column of the grid
    double fraction = 0.0;  // position inside the cell, 0 to 1
  };
  Cell cell(double input) const;
  double below(std::size_t rows, std::size_t columns) const { return below_[rows * (levels_ + 1) + columns]; }
  double on_diagonal(std::size_t i) const { return below(i + 1, i + 1) - below(i + 1, i); }
  double weight_up_to(Cell v) const;            // weight of the relays with alpha <= v
  double left_of(Cell alpha, Cell beta) const;  // weight of the relays with alpha' <= alpha and beta' <= beta
  double everett(double alpha, double beta) const;
  double slope(const Branch& branch, Direction direction, double input) const;

  PreisachParameters parameters_;
  std::size_t levels_ = 0;
  // Values of below(rows, columns): the total weight of the cells in the first `rows` rows and the first
  // `columns` columns. `rows` and `columns` are from 0 to levels_.
  std::vector<double> below_;
};

using Preisach = MemoryModel<EverettLaw>;
extern template class MemoryModel<EverettLaw>;

}  // namespace hystcan::model
