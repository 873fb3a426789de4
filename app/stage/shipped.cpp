#include "app/stage/shipped.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "base/error.h"

namespace hystcan::app {
namespace {

std::filesystem::path shipped_folder() {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const auto installed = (program / "../share/hystcan").lexically_normal();
  const auto of_the_tree = (program / "../../config").lexically_normal();
  for (const auto& folder : {installed, of_the_tree})
    if (std::filesystem::exists(folder / "piezo.toml")) return folder;
  throw Error(fmt::format("the shipped configurations are neither in {} nor in {}", installed.string(),
                          of_the_tree.string()),
              expect("piezo.toml in one of these folders"));
}

}  // namespace

std::filesystem::path shipped_file(const std::string& name) { return shipped_folder() / name; }

std::vector<std::string> shipped_configurations() {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(shipped_folder(), none)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() == ".toml" && file.stem().extension().empty()) names.push_back(file.stem().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace hystcan::app
