// How far a number of the trial can move before the error grows: with the best values of the numbers that make up for it.
#pragma once

#include <functional>
#include <vector>

#include "identification/search.h"
#include "identification/unknowns.h"

namespace hystcan::identification {

struct ValueRange {
  double lo = 0.0, hi = 0.0;
};

class Valley {
 public:
  /// The numbers that make up for it, beside both k, at a trial.
  using Companions = std::function<std::vector<Unknown>(const Trial&)>;

  Valley(const Problem& problem, const SearchResult& found, double Trial::*number, Companions companions,
         const std::function<bool()>& go_on);

  /// The last trial in this direction that is as good, to a quarter of the step. Not below zero.
  Trial farthest(double step);

 private:
  bool is_as_good(Trial& trial);

  Trial trial_;
  double Trial::*number_;
  Companions companions_;
  SeparableFit fit_;
  const std::function<bool()>& go_on_;
  double largest_rms_ = 0.0;
};

}  // namespace hystcan::identification
