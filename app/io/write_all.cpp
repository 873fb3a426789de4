#include "app/io/write_all.h"

#include <sys/types.h>
#include <unistd.h>

#include <cerrno>

namespace hystcan::app {

int write_all(int descriptor, std::string_view text, std::size_t& done) {
  for (done = 0; done < text.size();) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    done += static_cast<std::size_t>(count);
  }
  return 0;
}

}  // namespace hystcan::app
