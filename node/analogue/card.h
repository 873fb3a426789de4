// A card with converters and digital lines, or the converters of a Raspberry Pi's HAT.
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
  /// False: the conversion has failed.
  virtual bool write(double volts) = 0;
};

class VoltageInput {
 public:
  VoltageInput() = default;
  VoltageInput(const VoltageInput&) = delete;
  VoltageInput& operator=(const VoltageInput&) = delete;
  virtual ~VoltageInput() = default;
  virtual const VoltageRange& range() const = 0;
  /// Converts now; empty: the conversion has failed.
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

/// Against what a voltage is measured.
enum class VoltageReference : std::uint8_t { ground, common, differential };
constexpr auto words(VoltageReference) {
  return std::to_array<std::string_view>({"ground", "common", "differential"});
}

/// A place on a card.
struct CardChannel {
  std::string device{};  ///< DeviceName; empty: that of the axis
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

  /// Each throws Error, with what the card has, if the card lacks the channel, its direction or its range.
  virtual std::unique_ptr<VoltageOutput> output(const CardChannel& place) = 0;
  virtual std::unique_ptr<VoltageInput> input(const CardChannel& place) = 0;
  virtual std::unique_ptr<LineOutput> line_output(const CardChannel& place) = 0;
  virtual std::unique_ptr<LineInput> line_input(const CardChannel& place) = 0;
  /// Each throws as its counterpart does; drives, sets and locks nothing.
  virtual VoltageRange check_output(const CardChannel& place) = 0;
  virtual void check_line_output(const CardChannel& place) = 0;
  virtual void check_line_input(const CardChannel& place) = 0;
};

/// Opens a real card, by its name (device_name.h). Throws Error if that fails, or if this program lacks the
/// library.
std::unique_ptr<Card> open_card(const std::string& device);

/// The card lacks what a key of [axis.analogue] names.
class ChannelError : public Error {
 public:
  ChannelError(std::string_view lacking_key, const Error& error) : Error(error), key(lacking_key) {}
  std::string key;  ///< "drive_output.range"; of a Card: within the channel, "range"
};

/// Returns what `open` returns; an Error becomes that of the key, or of the key within it.
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
