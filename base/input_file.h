// Files that a command reads, and a class that owns a file descriptor.
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

/// An open file descriptor that closes with its scope.
class Descriptor {
 public:
  /// `number`: the descriptor; negative: none is open.
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

/// Returns the content of a regular file. Never waits for another process: a pipe or a terminal would wait
/// for its other end, and a device never ends. Throws Error, with `expected`, if the file cannot be opened,
/// is not a regular file, or has more than `largest` bytes.
std::string read_regular_file(const std::filesystem::path& file, std::size_t largest,
                              const char* expected = "");

/// How long opening a FIFO waits for a process that opens it for writing.
inline constexpr std::chrono::seconds fifo_open_timeout{3};

/// Opens a file that is read once from its beginning. It may be a pipe (/dev/stdin, a FIFO). Throws Error,
/// with `expected`, if the file cannot be opened, is a directory, or is a FIFO that no program opens for
/// writing. A signal that interrupts a wait for data makes the stream bad().
std::unique_ptr<std::istream> open_input(const std::filesystem::path& file, const char* expected,
                                         std::chrono::milliseconds timeout = fifo_open_timeout);

}  // namespace hystcan
