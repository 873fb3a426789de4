// Handles and errors of the C library.
#pragma once

#include <fmt/format.h>
#include <hdf5.h>

#include <filesystem>
#include <string>
#include <utility>

#include "storage/hdf5.h"

namespace hystcan::storage {

/// Errors are told by exceptions: keeps the library from printing them too. It remembers that for each thread.
void keep_quiet();

/// The reason that the library gives for its last failure, and an empty stack of errors.
std::string last_reason();

[[noreturn]] inline void refuse(const std::filesystem::path& file, const std::string& what) {
  throw Hdf5Error(fmt::format("{}: {}: {}", file.string(), what, last_reason()));
}

/// Closes what it holds.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close how) : id_(id), close_(how) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() { close(); }

  hid_t get() const { return id_; }
  bool is_valid() const { return id_ >= 0; }
  herr_t close() { return id_ >= 0 ? close_(std::exchange(id_, H5I_INVALID_HID)) : 0; }

 private:
  hid_t id_;
  Close close_;
};

/// Throws where the call has failed.
inline Handle checked(hid_t id, Handle::Close how, const std::filesystem::path& file,
                      const std::string& what) {
  if (id < 0) refuse(file, what);
  return {id, how};
}

std::unique_ptr<Hdf5Writer> make_writer(const std::filesystem::path& file);
std::unique_ptr<Hdf5Reader> make_reader(const std::filesystem::path& file);

}  // namespace hystcan::storage
