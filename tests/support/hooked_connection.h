// Intercepts the frames between a connection to a bus and its owner.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "can/bus.h"

namespace hystcan::support {

/// A connection with hooks. Each hook may change a frame; it returns false to remove the frame.
class HookedConnection final : public can::Bus {
 public:
  using Hook = std::function<bool(can::Frame& frame)>;
  explicit HookedConnection(std::unique_ptr<can::Bus> inner, Hook on_send = {}, Hook on_receive = {})
      : inner_(std::move(inner)), on_send_(std::move(on_send)), on_receive_(std::move(on_receive)) {}

  /// Reports this state to the owner instead of the true state of the bus; `nullopt` reports the true state.
  /// No frame passes while the reported state is `bus_off` or `down`.
  void pretend(std::optional<can::BusState> state) {
    pretended_ = state;
    if (on_state_) on_state_(this->state());
  }
  /// Called with the reception time after the owner has handled a frame.
  std::function<void(can::Time received)> after_frame;

  bool send(const can::Frame& frame) override {
    if (is_off()) return false;
    can::Frame copy = frame;
    return on_send_ && !on_send_(copy) ? true : inner_->send(copy);
  }
  void on_frame(FrameHandler handler) override {
    inner_->on_frame([this, handle = std::move(handler)](const can::Frame& frame, can::Time received) {
      if (is_off()) return;
      can::Frame copy = frame;
      if (on_receive_ && !on_receive_(copy)) return;
      handle(copy, received);
      if (after_frame) after_frame(received);
    });
  }
  bool on_sent(FrameHandler handler) override { return inner_->on_sent(std::move(handler)); }
  void on_state(StateHandler handler) override {
    on_state_ = std::move(handler);
    inner_->on_state([this](can::BusState state) {
      if (!pretended_ && on_state_) on_state_(state);
    });
  }
  can::BusState state() const override { return pretended_.value_or(inner_->state()); }
  const can::BusCounters& counters() const override { return inner_->counters(); }

 private:
  bool is_off() const { return pretended_ == can::BusState::down || pretended_ == can::BusState::bus_off; }

  std::unique_ptr<can::Bus> inner_;
  Hook on_send_;
  Hook on_receive_;
  StateHandler on_state_;
  std::optional<can::BusState> pretended_;
};

}  // namespace hystcan::support
