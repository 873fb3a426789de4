#include "app/stage/shipped.h"

#include <algorithm>
#include <system_error>

namespace hystcan::app {
namespace {

std::filesystem::path shipped_folder() {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const auto& folder : {program / "../share/hystcan", program / "../../config"})
    if (std::filesystem::exists(folder / "piezo.toml")) return folder.lexically_normal();
  return "config";
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
