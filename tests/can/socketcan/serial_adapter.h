// A CAN adapter of the test's own: the kernel's driver for serial adapters (slcan, Lawicel's ASCII protocol)
// on one end of a pseudo-terminal, the test on the other. To the kernel it is a real one: it has a bit rate,
// can go bus-off, can be too busy to take frames, and can be unplugged.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace hystcan::can {

class SerialAdapter {
 public:
  /// `name()` is empty where the kernel has no such driver or lets us have none.
  SerialAdapter();
  /// Unplugged: the interface is no more.
  ~SerialAdapter();
  SerialAdapter(const SerialAdapter&) = delete;
  SerialAdapter& operator=(const SerialAdapter&) = delete;

  const std::string& name() const { return name_; }

  /// To the driver, one message: `t181210FF` a frame, `sb000256` bus-off at receive counter 0, transmit
  /// counter 256, `e1a` an error: not acknowledged.
  void say(const std::string& message) const;
  /// What the driver has sent, without its set-up: `t201112`.
  std::vector<std::string> frames() const;

  /// The adapter takes nothing more from the driver, as when nobody acknowledges what it sends.
  void stall() { set_stalled(true); }
  void go_on() { set_stalled(false); }

 private:
  void set_stalled(bool stalled);
  void take(std::stop_token stop);

  int own_end_ = -1;
  int driver_end_ = -1;
  std::string name_;
  mutable std::mutex mutex_;
  bool stalled_ = false;
  std::string heard_;
  std::jthread reader_;  ///< the driver waits for what it writes to be taken
};

}  // namespace hystcan::can
