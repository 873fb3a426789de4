#include "node/analogue/device_name.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <fstream>
#include <system_error>

#include "base/error.h"
#include "base/text.h"

namespace hystcan::node {
namespace {

/// Returns the rest of the text after the prefix; empty if the text does not begin with the prefix.
std::string_view behind(std::string_view text, std::string_view prefix) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : std::string_view();
}

std::string comedi_identity(const std::filesystem::path& file, const std::filesystem::path& root) {
  std::error_code none;
  struct stat found {};
  if (stat(file.c_str(), &found) != 0 || !S_ISCHR(found.st_mode)) {
    const std::filesystem::path real = std::filesystem::weakly_canonical(file, none);
    return "comedi:" + (none ? file.lexically_normal() : real).string();
  }
  const std::string number = fmt::format("{}:{}", major(found.st_rdev), minor(found.st_rdev));
  const auto board = std::filesystem::read_symlink(root / "sys/dev/char" / number, none).filename().string();
  if (board.empty()) return "comedi:" + number;
  return "comedi:" + board.substr(0, board.find("_subd"));
}

std::string iio_identity(const std::string& name, const std::filesystem::path& root) {
  const auto line_of = [](const std::filesystem::path& file) {
    std::string line;
    std::ifstream stream(file);
    std::getline(stream, line);
    return line.substr(0, line.find('\0'));
  };
  std::string least;  // smallest id of the matching devices: libiio searches in the order of the ids
  std::error_code none;
  for (const auto& device : std::filesystem::directory_iterator(root / "sys/bus/iio/devices", none)) {
    const std::string id = device.path().filename().string();
    if (!id.starts_with("iio:device")) continue;
    const bool is_it =
        id == name || line_of(device.path() / "name") == name || line_of(device.path() / "label") == name;
    if (is_it && (least.empty() || id < least)) least = id;
  }
  return "iio:" + (least.empty() ? name : least);
}

}  // namespace

std::optional<DeviceName> DeviceName::parsed(std::string_view text) {
  constexpr std::size_t longest = 255;
  if (text.size() > longest) return std::nullopt;
  if (const auto file = behind(text, "comedi:"); file.starts_with('/'))
    return DeviceName{CardKind::comedi, std::string(file)};
  if (const auto name = behind(text, "iio:"); !name.empty())
    return DeviceName{CardKind::iio, std::string(name)};
  if (text == "simulated") return DeviceName{};
  const auto digits = behind(text, "simulated:");
  const auto bits = digits.starts_with('+') ? std::nullopt : parsed_number<unsigned>(digits);
  if (!bits || *bits < least_bits || *bits > most_bits) return std::nullopt;
  return DeviceName{CardKind::simulated, {}, *bits};
}

DeviceName device_named(std::string_view text) {
  if (auto device = DeviceName::parsed(text)) return *std::move(device);
  constexpr std::size_t shown = 60;
  throw Error(fmt::format("device is \"{}\"{}", text.substr(0, shown), text.size() > shown ? "..." : ""),
              expect("{}", DeviceName::expected));
}

std::string identity_of(const DeviceName& device, const std::filesystem::path& root) {
  switch (device.kind) {
    case CardKind::comedi:
      return comedi_identity(device.name, root);
    case CardKind::iio:
      return iio_identity(device.name, root);
    case CardKind::simulated:
      break;
  }
  return fmt::format("simulated:{}", device.bits);
}

}  // namespace hystcan::node
