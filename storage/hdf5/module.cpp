// The entry of hystcan_hdf5.so.
#include <string_view>

#include "storage/hdf5/handle.h"

namespace hystcan::storage {
namespace {

/// The innermost description: "unable to open file: ... errno = 2, error message = 'No such file or directory'".
herr_t take_description(unsigned, const H5E_error2_t* error, void* into) {
  if (error->desc != nullptr && error->desc[0] != '\0') *static_cast<std::string*>(into) = error->desc;
  return 0;
}

std::unique_ptr<Hdf5Writer> create(const std::filesystem::path& file) {
  keep_quiet();
  return make_writer(file);
}
std::unique_ptr<Hdf5Reader> open(const std::filesystem::path& file) {
  keep_quiet();
  return make_reader(file);
}

/// "No space left on device" out of "file write failed: time = ..., errno = 28, error message = '...', ...".
std::string in_short(const std::string& reason) {
  constexpr std::string_view before = "error message = '";
  const auto at = reason.find(before);
  if (at == std::string::npos) return reason;
  const auto begin = at + before.size();
  return reason.substr(begin, reason.find('\'', begin) - begin);
}

}  // namespace

std::string last_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* error, void* into) -> herr_t {
        return static_cast<std::string*>(into)->empty() ? take_description(n, error, into) : 0;
      },
      &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "the library gives no reason" : in_short(reason);
}

void keep_quiet() {
  thread_local const bool once = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  static_cast<void>(once);
}

}  // namespace hystcan::storage

extern "C" __attribute__((visibility("default"))) const hystcan::storage::Hdf5Library* hystcan_hdf5() {
  H5dont_atexit();  // its end would write once more what a full disk has refused, and crash
  static const hystcan::storage::Hdf5Library library{&hystcan::storage::create, &hystcan::storage::open};
  return &library;
}
