#include "model/output_creep.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "base/text.h"

namespace hystcan::model {
namespace {

constexpr double lags_per_decade = 2.0;

std::size_t lags_of(const OutputCreep::Config& config) {
  const auto& [per_decade, from_s, to_s] = config;
  if (!std::isfinite(per_decade)) refuse("creep per_decade = ", per_decade, ", expected a finite number");
  if (!std::isfinite(from_s) || from_s <= 0.0)
    refuse("creep from_s = ", from_s, ", expected a positive number");
  if (!std::isfinite(to_s) || to_s < from_s)
    refuse("creep to_s = ", to_s, ", expected a finite number, at least from_s = ", from_s);
  const double lags = 1.0 + std::round(lags_per_decade * std::log10(to_s / from_s));
  if (lags > static_cast<double>(OutputCreep::most_lags))
    refuse("creep from_s = ", from_s, " to to_s = ", to_s, " makes ", lags, " lags, expected at most ",
           OutputCreep::most_lags);
  return static_cast<std::size_t>(lags);
}

}  // namespace

OutputCreep::OutputCreep(const Config& config) : weight_(config.per_decade / lags_per_decade) {
  const std::size_t lags = lags_of(config);
  at_once_ = 1.0 - static_cast<double>(lags) * weight_;
  if (at_once_ < 0.5)
    refuse("creep per_decade = ", config.per_decade, " with ", lags,
           " first-order lags leaves a share without lag of ", at_once_,
           " in the output, expected at least 0.5: lower per_decade or to_s");
  rates_per_s_.reserve(lags);
  for (std::size_t i = 0; i < lags; ++i)
    rates_per_s_.push_back(std::pow(10.0, -static_cast<double>(i) / lags_per_decade) / config.from_s);
}

double OutputCreep::late(const State& state) const {
  double sum = 0.0;
  for (const double y : state) sum += y;
  return weight_ * sum;
}

double OutputCreep::output(const State& state, double h) const { return at_once_ * h + late(state); }

double OutputCreep::inverse(const State& state, double x) const { return (x - late(state)) / at_once_; }

double OutputCreep::amplitude_at(double frequency_Hz) const {
  std::complex<double> x = at_once_;
  for (const double rate : rates_per_s_)
    x += weight_ / std::complex<double>(1.0, 2.0 * std::numbers::pi * frequency_Hz / rate);
  return std::abs(x);
}

void OutputCreep::advance(State& state, double h, double dt_s) const {
  if (!std::isfinite(h)) return;
  for (std::size_t i = 0; i < rates_per_s_.size(); ++i)
    state[i] -= std::expm1(-rates_per_s_[i] * dt_s) * (h - state[i]);
}

HeldCreep::HeldCreep(OutputCreep creep, std::optional<State> start)
    : creep_(std::move(creep)), state_(std::move(start)) {}

void HeldCreep::hold_until(double time_s) {
  if (state_ && state_->time_s) creep_.advance(state_->creep, state_->h, time_s - *state_->time_s);
  now_s_ = time_s;
}

double HeldCreep::inverse(double x) const { return state_ ? creep_.inverse(state_->creep, x) : x; }

double HeldCreep::follow(double h) {
  if (!state_) state_ = State{.creep = creep_.settled(h)};
  state_->h = h;
  state_->time_s = now_s_;
  return creep_.output(state_->creep, h);
}

}  // namespace hystcan::model
