#include "identification/sampled_record.h"

#include <cmath>

#include "model/refusal.h"

namespace hystcan::identification {
namespace {

using model::refuse;

constexpr std::size_t fewest_rows = 30;
constexpr double unevenness = 0.01;

double cycle_of(const std::vector<double>& time_s) {
  const double cycle_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  for (std::size_t n = 1; n < time_s.size(); ++n) {
    const double step_s = time_s[n] - time_s[n - 1];
    if (!(std::abs(step_s - cycle_s) <= unevenness * cycle_s))
      refuse("time_s of row ", n + 1, " is ", step_s, " s after the row before, expected ", cycle_s,
             " s within 1 %: an evenly sampled record, no row left out");
  }
  return cycle_s;
}

Eigen::VectorXd vector_of(const std::vector<double>& column) {
  return Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(column.size()));
}

}  // namespace

Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values) {
  const Eigen::VectorXd about_mean = values.array() - values.mean();  // the times' mean is zero
  return about_mean - time * (time.dot(about_mean) / time.squaredNorm());
}

SampledRecord sampled(const Record& record) {
  if (record.size() < fewest_rows)
    refuse("record of ", record.size(), " rows, expected at least ", fewest_rows);
  SampledRecord s;
  s.cycle_s = cycle_of(record.time_s);
  s.time = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(record.size()), -1.0, 1.0);
  s.drive = vector_of(record.input).array() - record.input.front();
  s.drive_scale = s.drive.cwiseAbs().maxCoeff();
  if (s.drive_scale == 0.0) refuse("input is constant, expected a step or a chirp");
  s.drive /= s.drive_scale;
  s.output = vector_of(record.output);
  s.output.array() -= s.output.mean();
  s.output_scale = std::sqrt(without_line(s.time, s.output).squaredNorm() / static_cast<double>(s.rows()));
  if (!(s.output_scale > 1e-12 * s.output.cwiseAbs().maxCoeff()))
    refuse("output is a straight line, expected an answer to the input");
  s.output /= s.output_scale;
  return s;
}

}  // namespace hystcan::identification
