#include "app/can_log.h"

#include <cerrno>
#include <system_error>

#include "config/config.h"

namespace hystcan::app {

std::ifstream open_can_log(const std::filesystem::path& path) {
  const auto refuse = [&](int error) {
    throw config::Error(path.string() + ": cannot be read: " + std::generic_category().message(error) +
                        ", expected a log of candump -L");
  };
  std::ifstream stream(path, std::ios::binary);
  if (!stream) refuse(errno);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) refuse(EISDIR);
  return stream;
}

}  // namespace hystcan::app
