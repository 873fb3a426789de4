#include "identification/sampling_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/text.h"

namespace hystcan::identification {
namespace {

// A SYNC that is late moves the sample and the drive together: its jitter matters little.
constexpr double unevenness = 0.1;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

Grid grid_of(const std::vector<double>& time_s) {
  if (time_s.size() < 2) refuse(time_s.size(), " rows, expected at least 2");
  std::vector<double> steps_s(time_s.size() - 1);
  for (std::size_t n = 1; n < time_s.size(); ++n) steps_s[n - 1] = time_s[n] - time_s[n - 1];
  const double usual_s = median(steps_s);
  Grid grid{.cycles = {0}};
  for (const double step_s : steps_s)
    grid.cycles.push_back(grid.cycles.back() +
                          static_cast<Eigen::Index>(std::clamp(std::round(step_s / usual_s), 1.0, 1e9)));
  grid.cycle_s = (time_s.back() - time_s.front()) / static_cast<double>(grid.cycles.back());
  for (std::size_t n = 1; n < time_s.size(); ++n) {
    const double cycles = static_cast<double>(grid.cycles[n] - grid.cycles[n - 1]);
    if (!(std::abs(steps_s[n - 1] - cycles * grid.cycle_s) <= unevenness * grid.cycle_s))
      refuse("time_s of row ", n + 1, " is ", steps_s[n - 1],
             " s after the row before, expected a whole multiple of ", grid.cycle_s,
             " s within 10 % of it: an evenly sampled dataset");
  }
  if (grid.length() > 2 * static_cast<Eigen::Index>(time_s.size()))
    refuse(grid.length() - static_cast<Eigen::Index>(time_s.size()), " of ", grid.length(),
           " cycles have no row, expected most of them");
  return grid;
}

Eigen::VectorXd held_on(const Grid& grid, const std::vector<double>& column) {
  Eigen::VectorXd held(grid.length());
  for (std::size_t n = 0; n < column.size(); ++n) {
    const Eigen::Index end = n + 1 < column.size() ? grid.cycles[n + 1] : grid.length();
    held.segment(grid.cycles[n], end - grid.cycles[n]).setConstant(column[n]);
  }
  return held;
}

}  // namespace hystcan::identification
