// The name of a card in [axis.analogue].
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace hystcan::node {

enum class CardKind : std::uint8_t { comedi, iio, simulated };

// comedi:/dev/comedi0   device file of comedi
// iio:ad5791            device of IIO, by its name, label or id
// simulated:12          stage of [axis.twin] behind converters of 12 bits; 16 without a number

struct DeviceName {
  static constexpr unsigned least_bits = 2, most_bits = 24;
  static constexpr std::string_view expected =
      "comedi:/dev/comedi0, iio:ad5791, simulated or simulated:BITS with 2 to 24 bits";

  CardKind kind = CardKind::simulated;
  std::string name{};  ///< of the device file, or of the device of IIO
  unsigned bits = 16;  ///< of simulated converters

  /// Empty: the text is not the name of a card.
  static std::optional<DeviceName> parsed(std::string_view text);
};

/// Throws Error if the text is not the name of a card.
DeviceName device_named(std::string_view text);

/// All names of one card have the same identity: the device of a file, behind its links, and of its
/// subdevices; the id of a device of IIO. `root` has /sys.
std::string identity_of(const DeviceName& device, const std::filesystem::path& root = "/");

}  // namespace hystcan::node
