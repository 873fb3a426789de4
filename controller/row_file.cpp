#include "controller/row_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hystcan::controller {

RowFile::RowFile(const std::filesystem::path& file, const char* first_lines)
    : path_(file), file_(std::fopen(file.c_str(), "w")) {
  if (file_ == nullptr)
    throw std::runtime_error(
        fmt::format("{}: cannot be written: {}", file.string(), std::generic_category().message(errno)));
  std::fputs(first_lines, file_);
}

RowFile::~RowFile() { close(); }

void RowFile::write(std::string_view row) {
  if (file_ == nullptr || error_ != 0) return;
  if (std::fwrite(row.data(), 1, row.size(), file_) != row.size()) error_ = errno;
}

std::string RowFile::close() {
  if (file_ != nullptr && std::fclose(std::exchange(file_, nullptr)) != 0 && error_ == 0) error_ = errno;
  if (error_ == 0) return {};
  return fmt::format("{}: cannot be written: {}; later rows are lost", path_.string(),
                     std::generic_category().message(error_));
}

}  // namespace hystcan::controller
