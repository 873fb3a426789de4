// What a refused file must say: its place and what was expected, in one line.
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

/// The bytes as a file of their own, removed again.
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

/// Runs `read`; where it refuses the file, it must say so as promised.
template <class Read>
void read_or_refuse(const File& file, Read read) {
  try {
    read();
  } catch (const config::Error& error) {
    const std::string_view what = error.what();
    demand(what.starts_with(file.path().string() + ":"));
    demand(what.find("expected ") != std::string_view::npos);
    demand(what.find('\n') == std::string_view::npos);
  }
}

}  // namespace hystcan::fuzz
