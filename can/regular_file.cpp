#include "can/regular_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "can/descriptor.h"

namespace hystcan::can {
namespace {

[[noreturn]] void refuse_file(int error) { throw FileError(std::generic_category().message(error)); }

void require_regular(int descriptor) {
  struct stat found {};
  if (::fstat(descriptor, &found) != 0) refuse_file(errno);
  if (S_ISDIR(found.st_mode)) refuse_file(EISDIR);
  if (!S_ISREG(found.st_mode)) throw FileError("it is a pipe or a device");
}

}  // namespace

std::string read_regular_file(const std::filesystem::path& file, std::size_t largest) {
  constexpr std::size_t chunk = 65'536;
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (descriptor.get() < 0) refuse_file(errno);
  require_regular(descriptor.get());
  std::string text;
  while (true) {
    const std::size_t before = text.size();
    text.resize(before + std::min(chunk, largest + 1 - before));
    const ssize_t received = ::read(descriptor.get(), text.data() + before, text.size() - before);
    if (received < 0 && errno != EINTR) refuse_file(errno);
    text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(received, 0)));
    if (received == 0) return text;
    if (text.size() > largest) throw FileError(fmt::format("it has more than {} bytes", largest));
  }
}

}  // namespace hystcan::can
