// The message about a refused file must contain, in one line, the place and what is expected or not allowed.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "config/schema/config.h"
#include "tests/fuzz/demand.h"

namespace hystcan::fuzz {

/// A temporary file with these bytes.
class File {
 public:
  File(const std::uint8_t* data, std::size_t size)
      : path_(std::filesystem::temp_directory_path() / ("hystcan_fuzz_" + std::to_string(getpid()))) {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  }
  ~File() { std::filesystem::remove(path_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs `read`. If it refuses the file, the message must have the form above.
template <class Read>
void read_or_refuse(const File& file, Read read) {
  try {
    read();
  } catch (const Error& error) {
    const std::string_view what = error.what();
    demand(what.starts_with(file.path().string() + ":"));
    demand_advice(what);
    demand(what.find('\n') == std::string_view::npos);
  }
}

}  // namespace hystcan::fuzz
