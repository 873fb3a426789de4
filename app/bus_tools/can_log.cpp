#include "app/bus_tools/can_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "config/schema/config.h"

namespace hystcan::app {

std::ifstream open_can_log(const std::filesystem::path& path) {
  const auto refuse = [&](int error) {
    throw config::Error(path.string() + ": cannot be read: " + std::generic_category().message(error) +
                        ", expected a log of candump -L");
  };
  std::error_code ignored;
  if (std::filesystem::is_character_file(path, ignored))
    throw config::Error(path.string() + ": is a device, expected a log of candump -L");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) refuse(errno);
  if (std::filesystem::is_directory(path, ignored)) refuse(EISDIR);
  return stream;
}

void require_frames(const std::string& name, std::uint64_t frames) {
  if (frames == 0) throw config::Error(name + ": no frames, expected a log of candump -L");
}

void print_parse_warnings(const can::Database& database) {
  constexpr std::size_t printed_max = 10;
  const std::size_t printed = std::min(printed_max, database.warnings.size());
  for (std::size_t i = 0; i < printed; ++i) fmt::print(stderr, "warning: {}\n", database.warnings[i]);
  if (printed < database.warnings.size())
    fmt::print(stderr, "warning: and {} more\n", database.warnings.size() - printed);
}

}  // namespace hystcan::app
