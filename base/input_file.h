// Functions that read the input files of a command, and a class that owns a file descriptor.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <utility>

namespace hystcan {

/// Owns an open file descriptor. The destructor closes the descriptor.
class Descriptor {
 public:
  /// `number`: the file descriptor. If it is negative, the object owns no descriptor.
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

/// Returns the content of a regular file. Refuses a pipe, a terminal and a device, because reading them could
/// wait forever. Throws Error, with `expected` as the advice, if the file cannot be opened, is not a regular
/// file, or has more than `largest` bytes.
std::string read_regular_file(const std::filesystem::path& file, std::size_t largest,
                              const char* expected = "");

/// Maximum time that open_input() waits until another process opens a FIFO for writing.
inline constexpr std::chrono::seconds fifo_open_timeout{3};

/// Opens a file for one reading from beginning to end; the file may be a pipe (/dev/stdin, a FIFO). Throws
/// Error, with `expected` as the advice, if the file cannot be opened, is a directory, or is a FIFO that no
/// program opens for writing within `timeout`. If a signal interrupts a wait for data, the stream becomes
/// bad().
std::unique_ptr<std::istream> open_input(const std::filesystem::path& file, const char* expected,
                                         std::chrono::milliseconds timeout = fifo_open_timeout);

}  // namespace hystcan
