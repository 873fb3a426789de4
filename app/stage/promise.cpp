#include "app/stage/promise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "app/live/rehearsal_setup.h"
#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/dynamics_text.h"
#include "app/stage/tuning.h"
#include "base/error.h"
#include "config/files/model_file.h"
#include "controller/analysis/linear_loop.h"

namespace hystcan::app {
namespace {

using controller::LinearLoop;
using identification::Misfit;

// Squares, but for the factors of the interval.
constexpr double other_motion = 1.2, never_let_through = 0.08, extrapolated_creep = 0.006, shared_delay = 2.0;
constexpr double least_share_error = 0.03, most_share_error = 0.5;
/// A mode that no record shows: standard errors of the resonance, and a factor of its damping.
struct ModeOff {
  double errors, damping;
};
constexpr std::array modes_off{ModeOff{-1.65, 1.3}, ModeOff{-0.8, 1.0 / 1.3}, ModeOff{0.8, 1.3},
                               ModeOff{1.65, 1.0 / 1.3}};

// Of the interval: x, and all else.
struct Factors {
  double exact, rest;
};
constexpr Factors at_least{0.9, 0.65}, at_most{1.2, 1.5};
constexpr double unseen_mode = 1.2;  // more of both for x where no record shows the mode

double square(double x) { return x * x; }

/// A rehearsal: true errors and how fast the drives move while they are judged.
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
  /// Drive units per second.
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

/// Calls `change` with what the twin has of each axis of the controller.
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

/// |S| at a frequency; 1 where there is no feedback, and above half the rate.
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

/// Without the octaves in which the records ring: the rehearsal has the mode.
double misfit_square(const Misfit& misfit, const Sensitivity& sensitivity, double speed,
                     double resonance_Hz) {
  constexpr double ringing = 0.5;  // of the resonance
  double let_through = 0.0, whole = 0.0;
  for (std::size_t i = 0; i < misfit.rms.size(); ++i) {
    if (misfit.middle(i) * misfit.speed > ringing * resonance_Hz) break;
    let_through += square(sensitivity(misfit.middle(i) * speed) * misfit.rms[i]);
    whole += square(misfit.rms[i]);
  }
  return other_motion * let_through + never_let_through * whole;
}

/// 0.40, 1.1, 12: two digits, a zero at the end too.
std::string two_digits(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return fmt::format("{:g}", value);
  const double shown = rounded(value, 2);
  return fmt::format("{:.{}f}", shown, std::max(0, 1 - static_cast<int>(std::floor(std::log10(shown)))));
}

/// Gathers the parts of the error of each axis.
class Promises {
 public:
  Promises(const rehearsal::Setup& setup, const std::vector<Ground>& grounds)
      : setup_(with_exact_models(setup)),
        grounds_(grounds),
        configured_(setup),
        exact_(setup_),
        parts_(grounds.size()) {
    if (!configured_.ended_well()) throw RunError("the rehearsal ended: " + configured_.failure());
  }

  std::vector<Promise> all() {
    for (std::size_t i = 0; i < parts_.size(); ++i) add_actuator(i);
    add_modes();
    add_delays();
    std::vector<Promise> promises;
    for (std::size_t i = 0; i < parts_.size(); ++i) promises.push_back(promise(i));
    return promises;
  }

 private:
  struct Parts {
    std::vector<double> exact_um{};  ///< with each mode
    double rest = 0.0;               ///< um^2
  };

  /// With an actuator that is exactly the model, where that tracks.
  const Run& base() const { return exact_.ended_well() ? exact_ : configured_; }

  void add_actuator(std::size_t i) {
    const controller::AxisConfig& axis = setup_.controller.axes[i].axis;
    Parts& parts = parts_[i];
    parts.exact_um.push_back(base().true_um(i));
    if (!grounds_[i].misfit || axis.learning) {
      parts.rest += std::max(0.0, square(configured_.true_um(i)) - square(base().true_um(i)));
      return;
    }
    const Sensitivity sensitivity(axis, 1.0 / setup_.controller.rate_Hz);
    const double speed = base().speed(i);
    parts.rest += misfit_square(*grounds_[i].misfit, sensitivity, speed, axis.delays.resonance_Hz);
    if (!axis.law.creep) return;
    const double fundamental_Hz = speed / (2.0 * axis.law.model.input_range().span());
    parts.rest +=
        extrapolated_creep *
        square(axis.law.creep->per_decade * base().outcome().axes[i].stroke_um * sensitivity(fundamental_Hz));
  }

  static bool knows_mode(const Ground& ground) { return ground.doubt.mode_error == 0.0; }

  void add_modes() {
    if (std::ranges::all_of(grounds_, knows_mode)) return;
    for (const ModeOff& off : modes_off) {
      const Run run(changed(setup_, [&](std::size_t i, twin::AxisConfig& stage) {
        if (knows_mode(grounds_[i])) return;
        stage.plant.mode.natural_frequency_Hz *= 1.0 + off.errors * grounds_[i].doubt.mode_error;
        stage.plant.mode.damping_ratio *= off.damping;
      }));
      if (!run.ended_well()) continue;
      for (std::size_t i = 0; i < parts_.size(); ++i)
        if (!knows_mode(grounds_[i])) parts_[i].exact_um.push_back(run.true_um(i));
    }
  }

  void add_delays() {
    if (std::ranges::none_of(grounds_, [](const Ground& of) { return of.doubt.unshared_s > 0.0; })) return;
    std::vector<double> slopes(parts_.size(), 0.0);  // of the squared error, per square of the share
    for (const bool all : {false, true}) {
      const Run run(changed(setup_, [&](std::size_t i, twin::AxisConfig& stage) {
        if (grounds_[i].doubt.unshared_s > 0.0) set_delay(stage, grounds_[i].doubt.unshared_s, all);
      }));
      if (!run.ended_well()) continue;
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        constexpr double far_enough = 0.05;
        const double moved = std::abs((all ? 1.0 : 0.0) - grounds_[i].doubt.sensor_share);
        if (moved < far_enough) continue;
        slopes[i] = std::max(slopes[i], (square(run.true_um(i)) - square(base().true_um(i))) / square(moved));
      }
    }
    for (std::size_t i = 0; i < parts_.size(); ++i)
      if (grounds_[i].doubt.unshared_s > 0.0)
        parts_[i].rest +=
            shared_delay * slopes[i] *
            square(std::clamp(grounds_[i].doubt.share_error, least_share_error, most_share_error));
  }

  Promise promise(std::size_t i) const {
    const Parts& parts = parts_[i];
    double mean = 0.0;
    for (const double um : parts.exact_um) mean += square(um) / static_cast<double>(parts.exact_um.size());
    const auto [least, most] = std::ranges::minmax(parts.exact_um);
    const double unsure = knows_mode(grounds_[i]) ? 1.0 : unseen_mode;
    const auto end = [&](double exact_um, const Factors& factors) {
      return std::sqrt(square(factors.exact * exact_um) + square(factors.rest) * parts.rest);
    };
    return {.axis = setup_.controller.axes[i].wire.name,
            .loop = grounds_[i].loop,
            .rms_um = std::sqrt(mean + parts.rest),
            .least_um = end(least / unsure, at_least),
            .most_um = end(most * unsure, at_most),
            .stroke_um = base().outcome().axes[i].stroke_um,
            .exact_failure = exact_.failure()};
  }

  rehearsal::Setup setup_;
  const std::vector<Ground>& grounds_;
  Run configured_, exact_;
  std::vector<Parts> parts_;
};

}  // namespace

Ground ground_of(const config::Config& config, std::size_t i, std::string loop, const Doubt& doubt) {
  const std::filesystem::path& model = config.axes[i].control_model;
  Ground ground{.loop = std::move(loop), .doubt = doubt};
  if (!model.empty()) ground.misfit = config::load_misfit(config.file.parent_path() / model);
  return ground;
}

std::vector<Promise> promises_of(const rehearsal::Setup& setup, const std::vector<Ground>& grounds) {
  return Promises(setup, grounds).all();
}

std::vector<Promise> promises_of(const config::Config& config) {
  std::vector<Ground> grounds;
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    grounds.push_back(ground_of(config, i, std::string(to_string(config.axes[i].control.law.structure))));
  try {
    return promises_of(rehearsal_setup(config), grounds);
  } catch (const RunError&) {
    if (stop_signalled != 0) throw;
    return {};
  }
}

std::string warning_of(const Promise& promise) {
  if (promise.exact_failure.empty()) return {};
  return fmt::format("{}: with an actuator that is exactly the model the rehearsal ends: {}", promise.axis,
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
