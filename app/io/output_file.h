// A file that is complete or not there.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string_view>

namespace hystcan::app {

/// Written beside its place, under a name that nothing else has, and moved there by commit(); gone where that
/// is never called. A link to a file is followed. What is there and is no ordinary file (a device, a pipe) is
/// written to as it is. Throws RunError where it can't be written, config::Error where the path is empty.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  void open_beside();
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  std::filesystem::path written_;  ///< empty where it is path_ itself, and once it has been moved
  std::FILE* file_ = nullptr;
};

/// An output that is one of the inputs would be lost while it is read. Throws config::Error.
void refuse_to_overwrite(const std::filesystem::path& output, const std::filesystem::path& input);

/// Two outputs in one file. Throws config::Error.
void refuse_to_share(const std::filesystem::path& one, const std::filesystem::path& other);

}  // namespace hystcan::app
