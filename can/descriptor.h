// An open file descriptor that closes with its scope.
#pragma once

#include <unistd.h>

#include <utility>

namespace hystcan::can {

class Descriptor {
 public:
  /// Below zero: none is open.
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&&) = delete;

  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

}  // namespace hystcan::can
