#include "node/shared_connection.h"

#include <algorithm>
#include <utility>

namespace hystcan::node {

class SharedConnection::Part final : public can::Bus {
 public:
  explicit Part(SharedConnection& owner) : owner_(owner) {}

  bool send(const can::Frame& frame) override {
    if (!owner_.is_delivering_) return owner_.bus_->send(frame);
    waiting_.push_back(frame);
    return true;
  }
  void on_frame(FrameHandler handler) override { on_frame_ = std::move(handler); }
  bool on_sent(FrameHandler) override { return false; }
  void on_state(StateHandler handler) override { on_state_ = std::move(handler); }
  can::BusState state() const override { return owner_.bus_->state(); }
  can::Refusal refusal() const override { return owner_.bus_->refusal(); }
  std::optional<can::ErrorCounters> error_counters() const override { return owner_.bus_->error_counters(); }
  const can::BusCounters& counters() const override {
    static const can::BusCounters none{};
    return owner_.parts_.front() == this ? owner_.bus_->counters() : none;
  }

  void deliver(const can::Frame& frame, can::Time received) const {
    if (on_frame_) on_frame_(frame, received);
  }
  void enter(can::BusState state) const {
    if (on_state_) on_state_(state);
  }
  void send_waiting() {
    for (const can::Frame& frame : waiting_) owner_.bus_->send(frame);
    waiting_.clear();
  }

 private:
  SharedConnection& owner_;
  FrameHandler on_frame_;
  StateHandler on_state_;
  std::vector<can::Frame> waiting_;
};

SharedConnection::SharedConnection() = default;
SharedConnection::~SharedConnection() = default;

std::unique_ptr<can::Bus> SharedConnection::attach(std::span<const can::Filter> filters) {
  for (const can::Filter& filter : filters)
    if (std::ranges::none_of(filters_, [&](const can::Filter& other) {
          return other.id == filter.id && other.extended == filter.extended;
        }))
      filters_.push_back(filter);
  auto part = std::make_unique<Part>(*this);
  parts_.push_back(part.get());
  return part;
}

void SharedConnection::open(const can::Attach& attach) {
  bus_ = attach(filters_);
  bus_->on_frame([this](const can::Frame& frame, can::Time received) { deliver(frame, received); });
  bus_->on_state([this](can::BusState state) {
    for (const Part* part : parts_) part->enter(state);
  });
}

void SharedConnection::deliver(const can::Frame& frame, can::Time received) {
  is_delivering_ = true;
  for (const Part* part : parts_) part->deliver(frame, received);
  is_delivering_ = false;
  std::for_each(parts_.rbegin(), parts_.rend(), [](Part* part) { part->send_waiting(); });
}

}  // namespace hystcan::node
