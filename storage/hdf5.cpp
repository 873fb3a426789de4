#include "storage/hdf5.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace hystcan::storage {
namespace {

constexpr const char* module_name = "hystcan_hdf5.so";

using Loaded = std::pair<const Hdf5Library*, std::string>;  ///< null with the reason why there is none

/// Beside the program where it was built, in PREFIX/lib/hystcan where it is installed; the same for the
/// Python module.
std::vector<std::filesystem::path> places() {
  std::vector<std::filesystem::path> places;
  std::error_code ignored;
  if (const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored); !ignored)
    for (const char* place : {".", "../lib/hystcan"}) places.push_back(program.parent_path() / place);
  Dl_info binary{};
  if (::dladdr(reinterpret_cast<const void*>(&has_hdf5), &binary) != 0 && binary.dli_fname != nullptr)
    for (const char* place : {"../..", "../../../hystcan"})
      places.push_back(std::filesystem::path(binary.dli_fname).parent_path() / place);
  return places;
}

/// Empty if it is nowhere.
std::filesystem::path module_file() {
  std::error_code ignored;
  for (const std::filesystem::path& place : places())
    if (auto file = (place / module_name).lexically_normal(); std::filesystem::exists(file, ignored))
      return file;
  return {};
}

Loaded load() {
  const std::filesystem::path file = module_file();
  if (file.empty()) return {nullptr, std::string("there is no ") + module_name};
  void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const entry = module == nullptr ? nullptr : ::dlsym(module, "hystcan_hdf5");
  if (entry != nullptr) return {reinterpret_cast<Hdf5Entry*>(entry)(), ""};
  const char* const why = ::dlerror();
  return {nullptr, why == nullptr ? file.string() : why};
}

const Loaded& loaded() {
  static const Loaded once = load();
  return once;
}

const Hdf5Library& library_for(const std::filesystem::path& file) {
  if (loaded().first == nullptr)
    throw Hdf5Error(
        fmt::format("{}: HDF5 is not at hand: {}; install libhdf5-dev and build again, or use CSV",
                    file.string(), loaded().second));
  return *loaded().first;
}

}  // namespace

bool has_hdf5() { return !module_file().empty(); }

std::unique_ptr<Hdf5Writer> create_hdf5(const std::filesystem::path& file) {
  return library_for(file).create(file);
}

std::unique_ptr<Hdf5Reader> open_hdf5(const std::filesystem::path& file) {
  return library_for(file).open(file);
}

}  // namespace hystcan::storage
