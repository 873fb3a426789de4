#include "app/stage/promise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/dynamics_text.h"
#include "base/error.h"
#include "config/files/model_file.h"
#include "controller/analysis/linear_loop.h"

namespace hystcan::app {
namespace {

using controller::LinearLoop;
using identification::Misfit;

/// Factors for the squared parts of the error (see promise.h): `other_motion` for the misfit m,
/// `never_let_through` for the floor f, `extrapolated_creep` for the creep c.
constexpr double other_motion = 1.2, never_let_through = 0.08, extrapolated_creep = 0.006;
/// Limits for the standard error of the sensor's share of the delay that amplifier and sensor have together.
constexpr double least_share_error = 0.03, most_share_error = 0.5;
/// Standard deviations of the logarithm of uncertain values: the damping of a mode that no record shows, and
/// the parts x (exact), m (misfit), f (floor) and c (creep) of the error (see promise.h).
constexpr double damping_spread = 0.2, exact_spread = 0.15, misfit_spread = 0.3, floor_spread = 0.5,
                 creep_spread = 0.35;

/// Values of a normal distribution with standard deviation 1: the centres of eleven intervals of equal
/// probability.
constexpr std::array deviates{-1.69, -1.10, -0.75, -0.47, -0.23, 0.0, 0.23, 0.47, 0.75, 1.10, 1.69};
constexpr double deviate(std::size_t k) { return deviates[k % deviates.size()]; }

double square(double x) { return x * x; }

/// Rehearses a setup. Provides the true error of each axis, and the mean speed of its drive while the axis
/// tracks.
class Run {
 public:
  explicit Run(const rehearsal::Setup& setup)
      : cycle_s_(1.0 / setup.controller.rate_Hz),
        moved_(setup.controller.axes.size()),
        outcome_(rehearsal::run_once(setup, settle_s,
                                     [this](const controller::CycleRecord& cycle) { take(cycle); })) {}

  bool ended_well() const { return failure_of(outcome_.axes).empty(); }
  std::string failure() const { return failure_of(outcome_.axes); }
  const rehearsal::Outcome& outcome() const { return outcome_; }
  double true_um(std::size_t i) const { return outcome_.true_errors[i].total().rms_um(); }
  /// Returns the mean speed of the drive of axis i in drive units per second.
  double speed(std::size_t i) const {
    return moved_[i].cycles > 0 ? moved_[i].distance / (static_cast<double>(moved_[i].cycles) * cycle_s_)
                                : 0.0;
  }

 private:
  struct Moved {
    std::optional<double> last{};
    double distance = 0.0;
    std::size_t cycles = 0;
  };
  void take(const controller::CycleRecord& cycle) {
    throw_if_signalled();
    if (cycle.report.state != controller::AxisState::tracking) return;
    Moved& moved = moved_[cycle.axis];
    if (moved.last) moved.distance += std::abs(cycle.report.drive - *moved.last);
    if (moved.last) ++moved.cycles;
    moved.last = cycle.report.drive;
  }

  double cycle_s_;
  std::vector<Moved> moved_;
  rehearsal::Outcome outcome_;
};

/// Returns the setup after calling `change(i, stage)` for each axis i of the controller. `stage` is the
/// twin's configuration of this axis.
template <class Change>
rehearsal::Setup changed(rehearsal::Setup setup, const Change& change) {
  for (std::size_t i = 0; i < setup.controller.axes.size(); ++i)
    for (twin::WiredAxisConfig& stage : setup.twin.axes)
      if (stage.wire.name == setup.controller.axes[i].wire.name) change(i, stage.axis);
  return setup;
}

rehearsal::Setup with_exact_models(const rehearsal::Setup& setup) {
  return changed(setup, [&](std::size_t i, twin::AxisConfig& stage) {
    const controller::ControlLaw::Config& law = setup.controller.axes[i].axis.law;
    stage.plant.hysteresis = law.model;
    stage.plant.hysteresis_creep = law.creep;
    stage.plant.creep.reset();
  });
}

/// Computes the magnitude |S| of the loop's sensitivity at a frequency: the share of a disturbance that the
/// loop does not remove. |S| is 1 without feedback, and above half the rate.
class Sensitivity {
 public:
  explicit Sensitivity(const controller::AxisConfig& axis, double cycle_s)
      : cycle_s_(cycle_s), loop_(controller::loop_config_of(axis.law, axis.delays, cycle_s)) {
    if (controller::feeds_back(axis.law.structure)) gains_ = axis.law.pi;
  }
  double operator()(double frequency_Hz) const {
    constexpr double nearly_half_the_rate = 0.98 * std::numbers::pi;
    const double theta = 2.0 * std::numbers::pi * frequency_Hz * cycle_s_;
    if (!(theta > 0.0) || theta > nearly_half_the_rate) return 1.0;
    return 1.0 / std::abs(1.0 + loop_(gains_, theta));
  }

 private:
  double cycle_s_;
  LinearLoop loop_;
  controller::PiGains gains_{};
};

/// The parts x^2, m^2, f^2 and c^2 of the squared tracking error in um^2 (see promise.h).
struct Parts {
  std::vector<double> exact{};  ///< squared error in um^2 of each rehearsal with an exact actuator model; the
                                ///< rehearsals differ in the unknown dynamics
  double misfit = 0.0, floor = 0.0, creep = 0.0;
};

/// Adds the misfit of the model to the error. The misfit is a spectrum with one RMS value for each octave.
/// Only the octaves below half the resonance are added: higher octaves contain the ringing of the mode, which
/// the rehearsal already includes. `speed`: speed of the drive in drive units per second.
void add_misfit(Parts& parts, const Misfit& misfit, const Sensitivity& sensitivity, double speed,
                double resonance_Hz) {
  constexpr double ringing = 0.5;  // share of the resonance above which an octave contains the mode
  for (std::size_t i = 0; i < misfit.rms.size(); ++i) {
    if (misfit.middle(i) * misfit.speed > ringing * resonance_Hz) break;
    parts.misfit += other_motion * square(sensitivity(misfit.middle(i) * speed) * misfit.rms[i]);
    parts.floor += never_let_through * square(misfit.rms[i]);
  }
}

/// Returns equally probable values of the squared error in um^2, sorted. Each value is a sum of the four
/// parts in `parts`. Each part takes eleven values, which represent its distribution. Not all combinations of
/// these values are computed, but for any two parts, every pair of values occurs (an orthogonal array).
std::vector<double> distribution_of(const Parts& parts) {
  std::vector<double> squares;
  const auto times = [](double square_um, double spread, std::size_t k) {
    return square_um * std::exp(2.0 * spread * deviate(k));
  };
  for (const double exact : parts.exact)
    for (std::size_t i = 0; i < deviates.size(); ++i)
      for (std::size_t j = 0; j < deviates.size(); ++j)
        squares.push_back(times(exact, exact_spread, i) + times(parts.misfit, misfit_spread, j) +
                          times(parts.floor, floor_spread, i + j) +
                          times(parts.creep, creep_spread, i + 2 * j));
  std::ranges::sort(squares);
  return squares;
}

/// Formats a value with two significant digits, including a trailing zero: 0.40, 1.1, 12.
std::string two_digits(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return fmt::format("{:g}", value);
  const double shown = rounded(value, 2);
  return fmt::format("{:.{}f}", shown, std::max(0, 1 - static_cast<int>(std::floor(std::log10(shown)))));
}

bool is_uncertain(const Uncertainty& uncertainty) {
  return uncertainty.mode_error > 0.0 || uncertainty.unshared_s > 0.0;
}

/// Changes the unknown dynamics of a stage to sample k of eleven: resonance, damping, and the sensor's share
/// of the delay.
void move(twin::AxisConfig& stage, const Uncertainty& uncertainty, std::size_t k) {
  if (uncertainty.mode_error > 0.0) {
    stage.plant.mode.natural_frequency_Hz *= 1.0 + uncertainty.mode_error * deviate(k);
    stage.plant.mode.damping_ratio *= std::exp(damping_spread * deviate(7 * k + 5));
  }
  if (!(uncertainty.unshared_s > 0.0)) return;
  constexpr double without_lag_Hz = 1e5;
  const double error = std::clamp(uncertainty.share_error, least_share_error, most_share_error),
               off = std::abs(uncertainty.sensor_share + error * deviate(3 * k + 5)),
               share = off > 1.0 ? 2.0 - off : off,  // a value above 1 is reflected into 0 to 1
      lag_s = (1.0 - share) * uncertainty.unshared_s;
  stage.sensor.delay = std::chrono::nanoseconds(std::llround(1e9 * share * uncertainty.unshared_s));
  stage.plant.amplifier.bandwidth_Hz = std::min(without_lag_Hz, 1.0 / (2.0 * std::numbers::pi * lag_s));
}

/// Rehearses the setup, computes the parts of the squared error of each axis (exact, misfit, floor, creep),
/// and combines them into promises.
class Promises {
 public:
  Promises(const rehearsal::Setup& setup, const std::vector<PromiseBasis>& bases)
      : setup_(with_exact_models(setup)),
        bases_(bases),
        configured_(setup),
        exact_(setup_),
        parts_(bases.size()) {
    if (!configured_.ended_well()) throw RunError("the rehearsal ended: " + configured_.failure());
  }

  std::vector<Promise> all() {
    for (std::size_t i = 0; i < parts_.size(); ++i) add_actuator(i);
    add_samples();
    std::vector<Promise> promises;
    for (std::size_t i = 0; i < parts_.size(); ++i) promises.push_back(promise(i));
    return promises;
  }

 private:
  /// Returns the rehearsal with an actuator that equals the model. If this rehearsal did not track, returns
  /// the rehearsal with the configured twin.
  const Run& base() const { return exact_.ended_well() ? exact_ : configured_; }

  void add_actuator(std::size_t i) {
    const controller::AxisConfig& axis = setup_.controller.axes[i].axis;
    Parts& parts = parts_[i];
    if (!is_uncertain(bases_[i].uncertainty)) parts.exact.push_back(square(base().true_um(i)));
    if (!bases_[i].misfit || axis.learning) {
      parts.misfit = std::max(0.0, square(configured_.true_um(i)) - square(base().true_um(i)));
      return;
    }
    const Sensitivity sensitivity(axis, 1.0 / setup_.controller.rate_Hz);
    const double speed = base().speed(i);
    add_misfit(parts, *bases_[i].misfit, sensitivity, speed, axis.delays.resonance_Hz);
    if (!axis.law.creep) return;
    const double fundamental_Hz = speed / (2.0 * axis.law.model.input_range().span());
    parts.creep =
        extrapolated_creep *
        square(axis.law.creep->per_decade * base().outcome().axes[i].stroke_um * sensitivity(fundamental_Hz));
  }

  /// Rehearses the loops with eleven samples of the unknown dynamics. Each sample has another mode, and
  /// assigns another share of the delay to the sensor.
  void add_samples() {
    if (std::ranges::none_of(bases_, [](const PromiseBasis& of) { return is_uncertain(of.uncertainty); }))
      return;
    for (std::size_t k = 0; k < deviates.size(); ++k) {
      const Run run(changed(
          setup_, [&](std::size_t i, twin::AxisConfig& stage) { move(stage, bases_[i].uncertainty, k); }));
      if (!run.ended_well()) continue;
      for (std::size_t i = 0; i < parts_.size(); ++i)
        if (is_uncertain(bases_[i].uncertainty)) parts_[i].exact.push_back(square(run.true_um(i)));
    }
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (parts_[i].exact.empty()) parts_[i].exact.push_back(square(base().true_um(i)));
  }

  Promise promise(std::size_t i) const {
    const std::vector<double> squares = distribution_of(parts_[i]);
    const auto quantile = [&](double share) {
      return std::sqrt(squares[static_cast<std::size_t>(share * static_cast<double>(squares.size()))]);
    };
    return {.axis = setup_.controller.axes[i].wire.name,
            .loop = bases_[i].loop,
            .rms_um = quantile(0.5),
            .least_um = quantile(0.05),
            .most_um = quantile(0.95),
            .stroke_um = base().outcome().axes[i].stroke_um,
            .exact_failure = exact_.failure()};
  }

  rehearsal::Setup setup_;
  const std::vector<PromiseBasis>& bases_;
  Run configured_, exact_;
  std::vector<Parts> parts_;
};

}  // namespace

PromiseBasis basis_of(const config::Config& config, std::size_t i, std::string loop,
                      const Uncertainty& uncertainty) {
  const std::filesystem::path& model = config.axes[i].control_model;
  PromiseBasis basis{.loop = std::move(loop), .uncertainty = uncertainty};
  if (!model.empty()) basis.misfit = config::load_misfit(config.file.parent_path() / model);
  return basis;
}

std::vector<Promise> promises_of(const rehearsal::Setup& setup, const std::vector<PromiseBasis>& bases) {
  return Promises(setup, bases).all();
}

std::vector<Promise> promises_of(const config::Config& config) {
  std::vector<PromiseBasis> bases;
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    bases.push_back(basis_of(config, i, std::string(to_string(config.axes[i].control.law.structure))));
  try {
    return promises_of(rehearsal_setup(config), bases);
  } catch (const RunError&) {
    if (stop_signalled != 0) throw;
    return {};
  }
}

std::string warning_of(const Promise& promise) {
  if (promise.exact_failure.empty()) return {};
  return fmt::format("{}: the rehearsal fails with an actuator that equals the model: {}", promise.axis,
                     promise.exact_failure);
}

std::string text_of(const Promise& promise) {
  return fmt::format("promise {}: {} um RMS true (90 %: {} to {}), {} % of stroke; {}", promise.axis,
                     two_digits(promise.rms_um), two_digits(promise.least_um), two_digits(promise.most_um),
                     two_digits(promise.percent()), promise.loop);
}

nlohmann::json to_json(const Promise& promise) {
  return {{"axis", promise.axis},
          {"loop", promise.loop},
          {"true_rms_um", promise.rms_um},
          {"interval_90_um", {promise.least_um, promise.most_um}},
          {"percent_of_stroke", promise.percent()},
          {"stroke_um", promise.stroke_um}};
}

}  // namespace hystcan::app
