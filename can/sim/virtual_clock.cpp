#include "can/sim/virtual_clock.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace hystcan::can {

struct VirtualClock::Alarm {
  static constexpr std::size_t idle = std::numeric_limits<std::size_t>::max();
  std::function<void()> on_expiry;
  std::size_t place = idle;  ///< index in the heap; `idle` if the alarm is not set
};

/// A binary heap of the alarms that are set. The alarm that expires next is the first element. Each alarm
/// stores its index in the heap, so that the queue can change the deadline of an alarm or remove the alarm.
class VirtualClock::Queue {
 public:
  Time now() const { return now_; }

  std::unique_ptr<Alarm> create(std::function<void()> on_expiry) {
    heap_.reserve(++alarms_);
    return std::make_unique<Alarm>(Alarm{std::move(on_expiry)});
  }

  void destroy(std::unique_ptr<Alarm> alarm) {
    disarm(*alarm);
    --alarms_;
    if (alarm.get() == ringing_) doomed_ = std::move(alarm);
  }

  void arm(Alarm& alarm, Time deadline) {
    if (alarm.place == Alarm::idle) {
      alarm.place = heap_.size();
      heap_.push_back({deadline, 0, &alarm});
    }
    heap_[alarm.place].deadline = std::max(deadline, now_);
    heap_[alarm.place].order = next_order_++;
    settle(alarm.place);
  }

  void disarm(Alarm& alarm) {
    const std::size_t hole = std::exchange(alarm.place, Alarm::idle);
    if (hole == Alarm::idle) return;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (hole == heap_.size()) return;
    put(hole, last);
    settle(hole);
  }

  void run_until(Time end) {
    while (!heap_.empty() && heap_.front().deadline <= end) {
      const Entry due = heap_.front();
      now_ = due.deadline;
      ringing_ = due.alarm;
      due.alarm->on_expiry();
      // The expired alarm is still the first element of the heap, because no alarm can be set to a time
      // before now. Remove it, unless its handler has set it again, with a new number `order`, or has
      // cancelled it.
      if (!heap_.empty() && heap_.front().order == due.order) disarm(*due.alarm);
      ringing_ = nullptr;
      doomed_.reset();
    }
    now_ = std::max(now_, end);
  }

 private:
  struct Entry {
    Time deadline;
    std::uint64_t order;
    Alarm* alarm;

    bool operator<(const Entry& other) const {
      return deadline != other.deadline ? deadline < other.deadline : order < other.order;
    }
  };

  void put(std::size_t place, const Entry& entry) {
    heap_[place] = entry;
    entry.alarm->place = place;
  }

  void settle(std::size_t place) {
    const Entry entry = heap_[place];
    while (place > 0 && entry < heap_[(place - 1) / 2]) {
      put(place, heap_[(place - 1) / 2]);
      place = (place - 1) / 2;
    }
    for (std::size_t child; (child = 2 * place + 1) < heap_.size(); place = child) {
      if (child + 1 < heap_.size() && heap_[child + 1] < heap_[child]) ++child;
      if (!(heap_[child] < entry)) break;
      put(place, heap_[child]);
    }
    put(place, entry);
  }

  Time now_{};
  std::vector<Entry> heap_;
  std::size_t alarms_ = 0;
  std::uint64_t next_order_ = 0;
  Alarm* ringing_ = nullptr;
  std::unique_ptr<Alarm> doomed_;  ///< alarm whose handler destroyed its timer; kept until the handler ends
};

VirtualClock::VirtualClock() : queue_(std::make_shared<Queue>()) {}
VirtualClock::~VirtualClock() = default;

Time VirtualClock::now() const { return queue_->now(); }

std::unique_ptr<Timer> VirtualClock::make_timer(std::function<void()> on_expiry) {
  class VirtualTimer final : public Timer {
   public:
    VirtualTimer(std::shared_ptr<Queue> queue, std::function<void()> handler)
        : queue_(std::move(queue)), alarm_(queue_->create(std::move(handler))) {}
    ~VirtualTimer() override { queue_->destroy(std::move(alarm_)); }
    VirtualTimer(const VirtualTimer&) = delete;
    VirtualTimer& operator=(const VirtualTimer&) = delete;

    void expire_at(Time deadline) override { queue_->arm(*alarm_, deadline); }
    void cancel() override { queue_->disarm(*alarm_); }

   private:
    std::shared_ptr<Queue> queue_;
    std::unique_ptr<Alarm> alarm_;
  };
  return std::make_unique<VirtualTimer>(queue_, std::move(on_expiry));
}

void VirtualClock::run_until(Time end) { queue_->run_until(end); }

}  // namespace hystcan::can
