#include "model/held_creep.h"

#include <utility>

namespace hystcan::model {

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
