// The entry of hystcan_hdf5.so.
#include <cerrno>
#include <system_error>

#include "storage/hdf5/handle.h"

namespace hystcan::storage {
namespace {

/// The innermost description: "unable to open file: ... errno = 2, error message = 'No such file or directory'".
herr_t take_description(unsigned, const H5E_error2_t* error, void* into) {
  if (error->desc != nullptr && error->desc[0] != '\0') *static_cast<std::string*>(into) = error->desc;
  return 0;
}

std::unique_ptr<Hdf5Writer> create(const std::filesystem::path& file) { return make_writer(file); }
std::unique_ptr<Hdf5Reader> open(const std::filesystem::path& file) { return make_reader(file); }

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
  return reason.empty() ? "the library gives no reason" : reason;
}

}  // namespace hystcan::storage

extern "C" __attribute__((visibility("default"))) const hystcan::storage::Hdf5Library* hystcan_hdf5() {
  static const hystcan::storage::Hdf5Library library{&hystcan::storage::create, &hystcan::storage::open};
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are told by exceptions
  return &library;
}
