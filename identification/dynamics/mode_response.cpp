#include "identification/dynamics/mode_response.h"

#include <cmath>
#include <numbers>

#include "model/held_mode.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// inputs_ repeats the first input for the longest delay, and for this number of further cycles. One cycle is
// for slope(), which also uses a slightly longer delay. One cycle is for the input before the first step of
// the simulation.
constexpr Index cycles_before = 2;
// inputs_ repeats the last input for this number of cycles. With a negative delay, the mode follows later
// inputs: slope() uses delays slightly below -1 cycle, and long_response() continues for one more cycle.
constexpr Index cycles_after = 3;

}  // namespace

/// One simulation of a mode: its drive and its state at the first cycle.
struct ModeResponse::Lane {
  model::HeldMode mode;
  /// Drive of each cycle, already delayed; drive[-1] is the drive of the previous cycle.
  const double* drive;
  Eigen::Vector2d state;

  /// Simulates two modes, `a` and `b`, in the same `for` loop. The processor then does each operation for
  /// both modes at once. Writes the position of each mode in every cycle to `of_a` and `of_b`.
  static void run(const Lane& a, const Lane& b, Eigen::Ref<VectorXd> of_a, Eigen::Ref<VectorXd> of_b) {
    using Two = Eigen::Array2d;
    const Eigen::Matrix2d &from_a = a.mode.transition(), &from_b = b.mode.transition();
    const Two pp(from_a(0, 0), from_b(0, 0)), pv(from_a(0, 1), from_b(0, 1)), vp(from_a(1, 0), from_b(1, 0)),
        vv(from_a(1, 1), from_b(1, 1));
    const Two p_old(a.mode.from_old()[0], b.mode.from_old()[0]),
        v_old(a.mode.from_old()[1], b.mode.from_old()[1]), p_new(a.mode.from_new()[0], b.mode.from_new()[0]),
        v_new(a.mode.from_new()[1], b.mode.from_new()[1]);
    Two position(a.state[0], b.state[0]), velocity(a.state[1], b.state[1]), before(a.drive[-1], b.drive[-1]);
    double *to_a = of_a.data(), *to_b = of_b.data();
    for (Index n = 0; n < of_a.size(); ++n) {
      to_a[n] = position[0];
      to_b[n] = position[1];
      const Two now(a.drive[n], b.drive[n]);
      const Two next = pp * position + pv * velocity + p_old * before + p_new * now;
      velocity = vp * position + vv * velocity + v_old * before + v_new * now;
      position = next;
      before = now;
    }
  }
};

ModeResponse::ModeResponse(const SampledDataset& dataset, Index longest_delay)
    : dataset_(dataset),
      longest_delay_(longest_delay),
      inputs_(longest_delay + cycles_before + dataset.inputs.rows() + cycles_after,
              dataset.inputs.cols() + 1) {
  const Index before = longest_delay + cycles_before, inputs = dataset.inputs.cols();
  inputs_.topLeftCorner(before, inputs).rowwise() = dataset.inputs.row(0);
  inputs_.block(before, 0, dataset.inputs.rows(), inputs) = dataset.inputs;
  inputs_.bottomLeftCorner(cycles_after, inputs).rowwise() = dataset.inputs.row(dataset.inputs.rows() - 1);
  inputs_.rightCols<1>().setZero();
}

/// Returns a simulation of the mode that begins at cycle `first`, counted from the first fitted cycle. The
/// initial state is rest at the input of the previous cycle, plus a free oscillation: `more` contains its
/// initial position, and its initial velocity divided by 2 pi f (f: natural frequency).
ModeResponse::Lane ModeResponse::lane(const ModePoint& point, const Eigen::Ref<const VectorXd>& input,
                                      Index first, const Eigen::Vector2d& more) const {
  const double f = std::exp(point[0]);
  const model::HeldMode mode({f, std::exp(point[1])}, point[2] * dataset_.cycle_s, dataset_.cycle_s);
  const double* drive =
      input.data() + longest_delay_ + cycles_before + dataset_.first + first - mode.whole_cycles();
  return {mode, drive, {drive[-1] + more[0], 2.0 * std::numbers::pi * f * more[1]}};
}

VectorXd ModeResponse::combined_input(const VectorXd& amplitudes) const {
  return inputs_.leftCols(inputs_.cols() - 1) * amplitudes.tail(inputs_.cols() - 1);
}

Eigen::MatrixXd ModeResponse::fitted(Eigen::MatrixXd cycles) const {
  if (dataset_.rows() == cycles.rows()) return cycles;
  return cycles(dataset_.cycles, Eigen::seqN(0, cycles.cols()));
}

Eigen::MatrixXd ModeResponse::columns(const ModePoint& point) const {
  const Index inputs = inputs_.cols() - 1;
  Eigen::MatrixXd cycles(dataset_.length(), gain + inputs);
  const Lane position = lane(point, inputs_.col(inputs), 0, {1.0, 0.0}),
             velocity = lane(point, inputs_.col(inputs), 0, {0.0, 1.0});
  Lane::run(position, velocity, cycles.col(free_position), cycles.col(free_velocity));
  for (Index i = 0; i < inputs; i += 2) {
    const bool has_pair = i + 1 < inputs;
    const Lane one = lane(point, inputs_.col(i), 0, Eigen::Vector2d::Zero());
    Lane::run(one, has_pair ? lane(point, inputs_.col(i + 1), 0, Eigen::Vector2d::Zero()) : one,
              cycles.col(gain + i), cycles.col(has_pair ? gain + i + 1 : offset));
  }
  Eigen::MatrixXd rows = fitted(std::move(cycles));
  rows.col(offset).setOnes();
  rows.col(drift) = dataset_.time;
  return rows;
}

VectorXd ModeResponse::driven(const ModePoint& point, const VectorXd& amplitudes) const {
  const VectorXd input = combined_input(amplitudes);
  Eigen::MatrixXd cycles(dataset_.length(), 2);
  const Lane one = lane(point, input, 0, Eigen::Vector2d::Zero());
  Lane::run(one, one, cycles.col(0), cycles.col(1));
  return fitted(std::move(cycles)).col(0);
}

ModeResponse::Slope ModeResponse::slope(const ModePoint& point, const VectorXd& amplitudes) const {
  return slope_with(point, amplitudes, {amplitudes[free_position], amplitudes[free_velocity]});
}

ModeResponse::Slope ModeResponse::driven_slope(const ModePoint& point, const VectorXd& amplitudes) const {
  return slope_with(point, amplitudes, Eigen::Vector2d::Zero());
}

ModeResponse::Slope ModeResponse::slope_with(const ModePoint& point, const VectorXd& amplitudes,
                                             const Eigen::Vector2d& decay) const {
  constexpr double h = 1e-5;
  const VectorXd input = combined_input(amplitudes);
  Eigen::MatrixXd cycles(dataset_.length(), 3);
  VectorXd less(dataset_.length());
  for (int i = 0; i < 3; ++i) {
    const ModePoint shift = h * ModePoint::Unit(i);
    Lane::run(lane(point + shift, input, 0, decay), lane(point - shift, input, 0, decay), cycles.col(i),
              less);
    cycles.col(i) = (cycles.col(i) - less) / (2.0 * h);
  }
  return fitted(std::move(cycles));
}

VectorXd ModeResponse::long_response(const ModePoint& point) const {
  Eigen::MatrixXd cycles(longest_delay_ + dataset_.length() + 1, 2);
  const Lane one = lane(point, inputs_.col(0), -longest_delay_, Eigen::Vector2d::Zero());
  Lane::run(one, one, cycles.col(0), cycles.col(1));
  return cycles.col(0);
}

}  // namespace hystcan::identification
