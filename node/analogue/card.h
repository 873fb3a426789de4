// The interface of a card. A card has converters, and it may have digital lines. The converters on a
// Raspberry Pi HAT also count as a card.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "node/analogue/voltage_range.h"

namespace hystcan::node {

class VoltageOutput {
 public:
  VoltageOutput() = default;
  VoltageOutput(const VoltageOutput&) = delete;
  VoltageOutput& operator=(const VoltageOutput&) = delete;
  virtual ~VoltageOutput() = default;
  virtual const VoltageRange& range() const = 0;
  /// Sets the output to this voltage. Returns false if the conversion failed.
  virtual bool write(double volts) = 0;
};

class VoltageInput {
 public:
  VoltageInput() = default;
  VoltageInput(const VoltageInput&) = delete;
  VoltageInput& operator=(const VoltageInput&) = delete;
  virtual ~VoltageInput() = default;
  virtual const VoltageRange& range() const = 0;
  /// Measures the voltage now, in volts. Returns `nullopt` if the conversion failed.
  virtual std::optional<double> read() = 0;
};

class LineOutput {
 public:
  LineOutput() = default;
  LineOutput(const LineOutput&) = delete;
  LineOutput& operator=(const LineOutput&) = delete;
  virtual ~LineOutput() = default;
  virtual bool write(bool on) = 0;
};

class LineInput {
 public:
  LineInput() = default;
  LineInput(const LineInput&) = delete;
  LineInput& operator=(const LineInput&) = delete;
  virtual ~LineInput() = default;
  virtual std::optional<bool> read() = 0;
};

/// The reference against which a voltage is measured.
enum class VoltageReference : std::uint8_t { ground, common, differential };
constexpr auto words(VoltageReference) {
  return std::to_array<std::string_view>({"ground", "common", "differential"});
}

/// The place of a channel on a card.
struct CardChannel {
  std::string device{};  ///< name of the card (forms: see DeviceName); empty: the card of the axis
  unsigned subdevice = 0;
  unsigned channel = 0;
  std::string range;  ///< "0..10 V"; empty: the first range of the channel
  VoltageReference reference = VoltageReference::ground;
};

class Card {
 public:
  Card() = default;
  Card(const Card&) = delete;
  Card& operator=(const Card&) = delete;
  virtual ~Card() = default;

  /// Each function opens a channel. If the card lacks the channel, its direction or its range, the function
  /// throws Error with a list of the available channels, directions or ranges.
  virtual std::unique_ptr<VoltageOutput> output(const CardChannel& place) = 0;
  virtual std::unique_ptr<VoltageInput> input(const CardChannel& place) = 0;
  virtual std::unique_ptr<LineOutput> line_output(const CardChannel& place) = 0;
  virtual std::unique_ptr<LineInput> line_input(const CardChannel& place) = 0;
  /// Each function checks a channel without opening it. It throws Error like the function above that opens
  /// such a channel, but drives no output, sets no line and locks nothing.
  virtual VoltageRange check_output(const CardChannel& place) = 0;
  virtual void check_line_output(const CardChannel& place) = 0;
  virtual void check_line_input(const CardChannel& place) = 0;
};

/// Opens a real card by its name (device_name.h). Throws Error if opening fails, or if this program was built
/// without the library for this kind of card (libcomedi or libiio).
std::unique_ptr<Card> open_card(const std::string& device);

/// The error if a card lacks a channel, line or range that a key of [axis.analogue] requires.
class ChannelError : public Error {
 public:
  ChannelError(std::string_view lacking_key, const Error& error) : Error(error), key(lacking_key) {}
  /// Path of the wrong key in [axis.analogue], for example "drive_output.range". In an error that a Card
  /// throws, the path contains only the key within the table of the channel, for example "range".
  std::string key;
};

/// Calls the function `open` and returns its result. If `open` throws Error, throws a ChannelError with the
/// path `key`. If `open` throws a ChannelError, puts `key` before its path: "range" becomes
/// "drive_output.range".
template <class Open>
decltype(auto) opened(std::string_view key, Open open) {
  try {
    return open();
  } catch (const ChannelError& error) {
    throw ChannelError(std::string(key) + "." + error.key, error);
  } catch (const Error& error) {
    throw ChannelError(key, error);
  }
}

}  // namespace hystcan::node
