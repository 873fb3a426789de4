// A cache of file contents. A file is read again only after it changed.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <typeindex>
#include <utility>

namespace hystcan::config {

class ReadFiles {
 public:
  /// Returns the result of `load` for the file; throws what `load` throws. The reference is valid until
  /// drop_unused().
  template <class Content>
  const Content& get(const std::filesystem::path& file, Content (*load)(const std::filesystem::path&)) const {
    Read& read = files_[{file, typeid(Content)}];
    read.is_used = true;
    if (const auto stamp = stamp_of(file); !read.content || !stamp || stamp != read.stamp)
      read = {std::make_shared<const Content>(load(file)), stamp};
    return *static_cast<const Content*>(read.content.get());
  }
  /// Removes all contents that were not requested since the last call.
  void drop_unused() const {
    for (auto file = files_.begin(); file != files_.end();)
      file = std::exchange(file->second.is_used, false) ? std::next(file) : files_.erase(file);
  }

 private:
  using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;  ///< time and size in bytes
  struct Read {
    std::shared_ptr<const void> content;
    std::optional<Stamp> stamp;
    bool is_used = true;
  };
  /// Returns nullopt if the file was written so recently that another write may get the same time stamp.
  static std::optional<Stamp> stamp_of(const std::filesystem::path& file) {
    constexpr auto coarsest_clock = std::chrono::seconds(2);  // coarsest time resolution of a file system:
                                                              // FAT
    std::error_code error;
    const auto written = std::filesystem::last_write_time(file, error);
    if (error || decltype(written)::clock::now() - written <= coarsest_clock) return std::nullopt;
    return Stamp(written, std::filesystem::file_size(file, error));
  }

  mutable std::map<std::pair<std::filesystem::path, std::type_index>, Read> files_;
};

}  // namespace hystcan::config
