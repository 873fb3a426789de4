#include "base/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <streambuf>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace hystcan {
namespace {

struct Input {
  const std::filesystem::path& file;
  const char* expected;

  [[noreturn]] void refuse(const std::string& reason = std::generic_category().message(errno)) const {
    throw Error(file, "cannot be read: " + reason, {.expected = expected});
  }
};

class DescriptorBuffer : public std::streambuf {
 public:
  explicit DescriptorBuffer(Descriptor descriptor) : descriptor_(std::move(descriptor)) {}

  /// Waits until a process has opened the FIFO for writing. Without this wait, the first read would report
  /// the end of the file at once.
  void await_writer(const Input& input, std::chrono::milliseconds timeout) {
    using WaitClock = std::chrono::steady_clock;
    constexpr int pause_ms = 10;
    const auto deadline = WaitClock::now() + timeout;
    while (true) {
      const ssize_t received = ::read(descriptor_.get(), data_.data(), data_.size());
      if (received > 0) return take(received);
      // A writer has opened the FIFO, but has written nothing yet.
      if (received < 0 && errno == EAGAIN) return;
      if (received < 0 && errno != EINTR) input.refuse();
      if (WaitClock::now() > deadline) input.refuse("the path names a pipe, and no program writes to it");
      ::poll(nullptr, 0, pause_ms);
    }
  }

 protected:
  int_type underflow() override {
    if (gptr() != egptr()) return traits_type::to_int_type(*gptr());
    pollfd input{.fd = descriptor_.get(), .events = POLLIN, .revents = 0};
    // Waits in poll() for data, so that Ctrl-C ends the wait: a signal always interrupts poll(), but the
    // system may restart read() after a signal.
    if (::poll(&input, 1, -1) < 0) fail();
    const ssize_t received = ::read(descriptor_.get(), data_.data(), data_.size());
    if (received < 0) fail();
    if (received == 0) return traits_type::eof();
    take(received);
    return traits_type::to_int_type(*gptr());
  }

 private:
  [[noreturn]] static void fail() { throw std::system_error(errno, std::generic_category()); }
  void take(ssize_t received) { setg(data_.data(), data_.data(), data_.data() + received); }

  Descriptor descriptor_;
  std::array<char, 65'536> data_{};
};

class InputStream : public std::istream {
 public:
  explicit InputStream(Descriptor descriptor) : std::istream(nullptr), buffer_(std::move(descriptor)) {
    rdbuf(&buffer_);
  }
  void await_writer(const Input& of, std::chrono::milliseconds timeout) { buffer_.await_writer(of, timeout); }

 private:
  DescriptorBuffer buffer_;
};

std::size_t size_of_regular(int descriptor, const Input& input) {
  struct stat found {};
  if (::fstat(descriptor, &found) != 0) input.refuse();
  if (S_ISDIR(found.st_mode)) input.refuse(std::generic_category().message(EISDIR));
  if (!S_ISREG(found.st_mode)) input.refuse("the path names a pipe or a device");
  return static_cast<std::size_t>(found.st_size);
}

}  // namespace

std::string read_regular_file(const std::filesystem::path& file, std::size_t largest, const char* expected) {
  const Input input{file, expected};
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (descriptor.get() < 0) input.refuse();
  std::string text;
  // One byte more than the file may have, so that a file that is too long is detected.
  text.reserve(std::min(size_of_regular(descriptor.get(), input), largest) + 1);
  while (true) {
    const std::size_t before = text.size();
    text.resize(std::min(std::max(text.capacity(), before + 1), largest + 1));
    const ssize_t received = ::read(descriptor.get(), text.data() + before, text.size() - before);
    if (received < 0 && errno != EINTR) input.refuse();
    text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(received, 0)));
    if (received == 0) return text;
    if (text.size() > largest) input.refuse(fmt::format("the file has more than {} bytes", largest));
  }
}

std::unique_ptr<std::istream> open_input(const std::filesystem::path& file, const char* expected,
                                         std::chrono::milliseconds timeout) {
  const Input input{file, expected};
  Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  const int number = descriptor.get();
  if (number < 0) input.refuse();
  struct stat found {};
  if (::fstat(number, &found) != 0) input.refuse();
  if (S_ISDIR(found.st_mode)) input.refuse(std::generic_category().message(EISDIR));
  auto stream = std::make_unique<InputStream>(std::move(descriptor));
  if (S_ISFIFO(found.st_mode)) stream->await_writer(input, timeout);
  if (::fcntl(number, F_SETFL, ::fcntl(number, F_GETFL) & ~O_NONBLOCK) != 0) input.refuse();
  return stream;
}

}  // namespace hystcan
