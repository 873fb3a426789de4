// A cache of the contents of files. A file is read again only if it changed.
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
  /// Returns the result of load(file), from the cache if the file did not change. Passes on the exceptions of
  /// `load`. The returned reference is valid until the file is read again or drop_unused() removes it.
  template <class Content>
  const Content& get(const std::filesystem::path& file, Content (*load)(const std::filesystem::path&)) const {
    Read& read = files_[{file, typeid(Content)}];
    read.is_used = true;
    if (const auto stamp = stamp_of(file); !read.content || !stamp || stamp != read.stamp)
      read = {std::make_shared<const Content>(load(file)), stamp};
    return *static_cast<const Content*>(read.content.get());
  }
  /// Removes all contents from the cache that get() did not return since the last call of drop_unused().
  void drop_unused() const {
    for (auto file = files_.begin(); file != files_.end();)
      file = std::exchange(file->second.is_used, false) ? std::next(file) : files_.erase(file);
  }

 private:
  /// The time of the last write to a file, and the size of the file in bytes.
  using Stamp = std::pair<std::filesystem::file_time_type, std::uintmax_t>;
  struct Read {
    std::shared_ptr<const void> content;
    std::optional<Stamp> stamp;
    bool is_used = true;
  };
  /// Returns time and size of the file, to detect a change. Returns nullopt if the file was written in the
  /// last two seconds. Another write could then get the same time, and the change would not be detected. A
  /// file without a stamp is therefore read again.
  static std::optional<Stamp> stamp_of(const std::filesystem::path& file) {
    // The coarsest time resolution of all file systems: the resolution of FAT.
    constexpr auto coarsest_clock = std::chrono::seconds(2);
    std::error_code error;
    const auto written = std::filesystem::last_write_time(file, error);
    if (error || decltype(written)::clock::now() - written <= coarsest_clock) return std::nullopt;
    return Stamp(written, std::filesystem::file_size(file, error));
  }

  mutable std::map<std::pair<std::filesystem::path, std::type_index>, Read> files_;
};

}  // namespace hystcan::config
