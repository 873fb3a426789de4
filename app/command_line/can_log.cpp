#include "app/command_line/can_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "base/input_file.h"
#include "base/standard_streams.h"
#include "config/schema/config.h"

namespace hystcan::app {

std::unique_ptr<std::istream> open_can_log(const std::filesystem::path& path) {
  try {
    return open_input(path);
  } catch (const FileError& error) {
    throw Error(path.string() + ": cannot be read: " + error.what() + ", expected a log of candump -L");
  }
}

void require_frames(const std::string& name, std::uint64_t frames) {
  if (frames == 0) throw Error(name + ": no frames, expected a log of candump -L");
}

void print_parse_warnings(const can::Database& database) {
  constexpr std::size_t printed_max = 10;
  const std::size_t printed = std::min(printed_max, database.warnings.size());
  for (std::size_t i = 0; i < printed; ++i) note("warning: {}\n", database.warnings[i]);
  const std::size_t more = database.warnings.size() - printed + database.further_warnings;
  if (more > 0) note("warning: and {} more\n", more);
}

}  // namespace hystcan::app
