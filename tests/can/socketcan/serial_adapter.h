// A CAN adapter for tests. The kernel's driver for serial adapters (slcan, Lawicel's ASCII protocol) has one
// end of a pseudo-terminal and the test has the other. The kernel treats it as a real adapter: it has a bit
// rate, can reach bus-off, can be too busy for further frames, and can be unplugged.
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
  /// `name()` is empty if the kernel has no such driver or does not permit its use.
  SerialAdapter();
  /// Unplugs the adapter: the interface disappears.
  ~SerialAdapter();
  SerialAdapter(const SerialAdapter&) = delete;
  SerialAdapter& operator=(const SerialAdapter&) = delete;

  const std::string& name() const { return name_; }

  /// Sends one message to the driver, for example:
  ///
  ///   t181210FF   a frame
  ///   sb000256    bus-off, receive counter 0, transmit counter 256
  ///   e1a         an error: not acknowledged
  void send_to_driver(const std::string& message) const;
  /// The frames that the driver has sent, for example `t201112`.
  std::vector<std::string> frames() const;

  /// Makes the adapter accept no more frames from the driver, as if no other node acknowledged its frames.
  void stall() { set_stalled(true); }
  void resume() { set_stalled(false); }

 private:
  void set_stalled(bool stalled);
  void take(std::stop_token stop);

  int own_end_ = -1;
  int driver_end_ = -1;
  std::string name_;
  mutable std::mutex mutex_;
  bool stalled_ = false;
  std::string heard_;
  std::jthread reader_;  ///< reads continuously, because the driver waits until its writes are read
};

}  // namespace hystcan::can
