#include "tests/can/socketcan/serial_adapter.h"

#include <fcntl.h>
#include <linux/tty.h>
#include <net/if.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <sstream>

namespace hystcan::can {

SerialAdapter::SerialAdapter() {
  own_end_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (own_end_ < 0 || ::grantpt(own_end_) != 0 || ::unlockpt(own_end_) != 0) return;
  driver_end_ = ::open(::ptsname(own_end_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios raw{};
  ::tcgetattr(driver_end_, &raw);
  ::cfmakeraw(&raw);
  ::tcsetattr(driver_end_, TCSANOW, &raw);
  const int discipline = N_SLCAN;
  std::array<char, IFNAMSIZ> name{};
  if (::ioctl(driver_end_, TIOCSETD, &discipline) != 0) return;
  if (::ioctl(driver_end_, SIOCGIFNAME, name.data()) != 0) return;
  name_ = name.data();
  reader_ = std::jthread([this](std::stop_token stop) { take(stop); });
}

SerialAdapter::~SerialAdapter() {
  reader_.request_stop();
  if (reader_.joinable()) reader_.join();
  if (own_end_ >= 0) ::close(own_end_);
  if (driver_end_ >= 0) ::close(driver_end_);
}

void SerialAdapter::send_to_driver(const std::string& message) const {
  const std::string line = message + "\r";
  ASSERT_EQ(::write(own_end_, line.data(), line.size()), static_cast<ssize_t>(line.size()));
}

void SerialAdapter::set_stalled(bool stalled) {
  const std::lock_guard lock(mutex_);
  stalled_ = stalled;
}

void SerialAdapter::take(std::stop_token stop) {
  while (!stop.stop_requested()) {
    {
      const std::lock_guard lock(mutex_);
      std::array<char, 256> bytes{};
      const ssize_t count = stalled_ ? 0 : ::read(own_end_, bytes.data(), bytes.size());
      if (count > 0) heard_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

std::vector<std::string> SerialAdapter::frames() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> frames;
  std::istringstream lines(heard_);
  for (std::string line; std::getline(lines, line, '\r');)
    if (line.starts_with("t") || line.starts_with("T")) frames.push_back(line);
  return frames;
}

}  // namespace hystcan::can
