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
// iio:ad5791            IIO device, by its name, label or id
// simulated:12          simulated stage of [axis.twin] with 12-bit converters; without a number: 16 bits

struct DeviceName {
  static constexpr unsigned least_bits = 2, most_bits = 24;
  static constexpr std::string_view expected =
      "comedi:/dev/comedi0, iio:ad5791, simulated or simulated:BITS with 2 to 24 bits";

  CardKind kind = CardKind::simulated;
  std::string name{};  ///< name of the device file or of the IIO device
  unsigned bits = 16;  ///< resolution of simulated converters

  /// Parses a device name. Returns `nullopt` if the text is not valid.
  static std::optional<DeviceName> parsed(std::string_view text);
};

/// Parses a device name. Throws Error if the text is not valid.
DeviceName device_named(std::string_view text);

/// Returns an identity that is the same for all names of one card. A comedi card is identified by its board
/// in /sys, because links and subdevice files are other names of the same board. An IIO device is identified
/// by its id. `root` contains /sys.
std::string identity_of(const DeviceName& device, const std::filesystem::path& root = "/");

}  // namespace hystcan::node
