#include "identification/numerics/nelder_mead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hystcan::identification {
namespace {

class Simplex {
 public:
  Simplex(const std::function<double(const Eigen::VectorXd&)>& function, const std::function<bool()>& go_on,
          int evaluations)
      : function_(function), go_on_(go_on), left_(evaluations) {}

  Minimum search(const Eigen::VectorXd& start, const Eigen::VectorXd& step, double tolerance) {
    const auto n = static_cast<double>(start.size());
    expand_ = 1.0 + 2.0 / n;
    contract_ = 0.75 - 0.5 / n;
    shrink_ = n > 1.0 ? 1.0 - 1.0 / n : 0.5;
    corners_.push_back(evaluate(start));
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      Eigen::VectorXd corner = start;
      corner[i] += step[i];
      corners_.push_back(evaluate(corner));
    }
    sort();
    while (left_ > 0 && go_on_() && !agree(tolerance)) {
      move();
      sort();
    }
    return corners_.front();
  }

 private:
  Minimum evaluate(const Eigen::VectorXd& at) {
    --left_;
    const double value = function_(at);
    return {at, std::isfinite(value) ? value : std::numeric_limits<double>::infinity()};
  }
  void sort() {
    std::ranges::stable_sort(corners_, [](const Minimum& a, const Minimum& b) { return a.value < b.value; });
  }
  bool agree(double tolerance) const {
    return corners_.back().value - corners_.front().value <= tolerance * std::abs(corners_.front().value);
  }

  void move() {
    Minimum& worst = corners_.back();
    Eigen::VectorXd centre = Eigen::VectorXd::Zero(worst.at.size());
    for (std::size_t i = 0; i + 1 < corners_.size(); ++i) centre += corners_[i].at;
    centre /= static_cast<double>(corners_.size() - 1);
    const Eigen::VectorXd way = centre - worst.at;
    const Minimum reflected = evaluate(centre + way);
    if (reflected.value < corners_.front().value) {
      const Minimum expanded = evaluate(centre + expand_ * way);
      worst = expanded.value < reflected.value ? expanded : reflected;
    } else if (reflected.value < corners_[corners_.size() - 2].value) {
      worst = reflected;
    } else {
      const bool outside = reflected.value < worst.value;
      const Minimum contracted = evaluate(centre + (outside ? contract_ : -contract_) * way);
      if (contracted.value < std::min(reflected.value, worst.value))
        worst = contracted;
      else
        shrink();
    }
  }
  void shrink() {
    const Eigen::VectorXd best = corners_.front().at;
    for (std::size_t i = 1; i < corners_.size(); ++i)
      corners_[i] = evaluate(best + shrink_ * (corners_[i].at - best));
  }

  const std::function<double(const Eigen::VectorXd&)>& function_;
  const std::function<bool()>& go_on_;
  int left_;
  double expand_ = 2.0, contract_ = 0.5, shrink_ = 0.5;
  std::vector<Minimum> corners_;
};

}  // namespace

Minimum minimise(const std::function<double(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                 const Eigen::VectorXd& step, double tolerance, int evaluations,
                 const std::function<bool()>& go_on) {
  return Simplex(function, go_on, evaluations).search(start, step, tolerance);
}

}  // namespace hystcan::identification
