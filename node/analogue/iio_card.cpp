#include "node/analogue/iio_card.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "node/analogue/lock_byte.h"

namespace hystcan::node {
namespace {

struct DestroyContext {
  void operator()(iio_context* context) const {
    if (context != nullptr) iio_context_destroy(context);
  }
};
using IioContext = std::shared_ptr<iio_context>;

struct RawRange {
  double lo = 0.0;
  double hi = 0.0;
};

/// A scale and an offset, in the text form of the driver.
struct IioScale {
  std::string scale_mV;
  std::string offset;

  /// Returns the number in the text; NaN if the text is not a number.
  static double number(const std::string& text) { return parsed_number<double>(text).value_or(NAN); }
  double step_V() const { return 1e-3 * number(scale_mV); }
  double volts(double raw) const { return step_V() * (raw + number(offset)); }
};

/// A channel, and the conversion between volts and raw values.
struct IioConverter {
  IioContext context;  ///< owns the channel
  iio_channel* channel = nullptr;
  VoltageRange volts{};
  double offset = 0.0;  ///< offset that is added to each raw value before the conversion to volts
};

/// Returns the value of an attribute of the channel; an empty text if the channel has no such attribute.
std::string attribute(const iio_channel* channel, const char* name) {
  std::array<char, 4096> text{};
  if (iio_channel_find_attr(channel, name) == nullptr) return {};
  const auto length = iio_channel_attr_read(channel, name, text.data(), text.size());
  if (length <= 0) return {};
  std::string value(text.data());
  while (!value.empty() && std::isspace(static_cast<unsigned char>(value.back())) != 0) value.pop_back();
  return value;
}

std::vector<std::string> words_of(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '[' || c == ']'; }, ' ');
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(std::move(word));
  return words;
}

/// Returns the range of the raw values of a channel; `nullopt` if the driver does not provide the range.
std::optional<RawRange> raw_range(const iio_channel* channel) {
  const std::vector<std::string> stated = words_of(attribute(channel, "raw_available"));  // [lo step hi]
  if (stated.size() == 3) {
    const auto lo = parsed_number<double>(stated[0]), hi = parsed_number<double>(stated[2]);
    if (lo && hi && *lo < *hi) return RawRange{*lo, *hi};
  }
  if (!iio_channel_is_scan_element(channel)) return std::nullopt;
  const iio_data_format& format = *iio_channel_get_data_format(channel);
  const double values = std::exp2(format.bits);
  return format.is_signed ? RawRange{-0.5 * values, 0.5 * values - 1.0} : RawRange{0.0, values - 1.0};
}

class IioOutput final : public VoltageOutput {
 public:
  IioOutput(IioConverter converter, Descriptor lock)
      : converter_(std::move(converter)),
        lock_(std::move(lock)),
        is_down_(iio_channel_find_attr(converter_.channel, "powerdown") != nullptr) {}

  const VoltageRange& range() const override { return converter_.volts; }
  bool write(double volts) override {
    const VoltageRange& range = converter_.volts;
    const auto raw = std::llround(std::clamp(volts, range.lo, range.hi) / range.step - converter_.offset);
    if (iio_channel_attr_write_longlong(converter_.channel, "raw", raw) < 0) return false;
    if (!is_down_) return true;
    is_down_ = iio_channel_attr_write_bool(converter_.channel, "powerdown", false) < 0;
    return !is_down_;
  }

 private:
  IioConverter converter_;
  Descriptor lock_;
  /// True while the chip may be powered down. Many chips with the attribute `powerdown` start powered down.
  /// write() powers the chip up after it has written the first value. Always false without this attribute.
  bool is_down_;
};

class IioInput final : public VoltageInput {
 public:
  explicit IioInput(IioConverter converter) : converter_(std::move(converter)) {}
  const VoltageRange& range() const override { return converter_.volts; }
  std::optional<double> read() override {
    long long raw = 0;
    if (iio_channel_attr_read_longlong(converter_.channel, "raw", &raw) < 0) return std::nullopt;
    return converter_.volts.step * (static_cast<double>(raw) + converter_.offset);
  }

 private:
  IioConverter converter_;
};

class IioCard final : public Card {
 public:
  explicit IioCard(const std::string& name)
      : name_("iio:" + name), context_(iio_create_local_context(), DestroyContext{}) {
    if (context_) device_ = iio_context_find_device(context_.get(), name.c_str());
    if (device_ == nullptr)
      throw Error(
          name_, "IIO device not found",
          {.remedy = devices().empty() ? "load the driver of the chip (for a HAT: its device-tree overlay)"
                                       : fmt::format("available devices: {}", fmt::join(devices(), ", "))});
  }

  std::unique_ptr<VoltageOutput> output(const CardChannel& place) override {
    iio_channel* const found = channel(place, true);
    Descriptor lock = own(found, place);
    return std::make_unique<IioOutput>(converter(found, place), std::move(lock));
  }
  std::unique_ptr<VoltageInput> input(const CardChannel& place) override {
    return std::make_unique<IioInput>(converter(channel(place, false), place));
  }
  std::unique_ptr<LineOutput> line_output(const CardChannel&) override { refuse_lines(); }
  std::unique_ptr<LineInput> line_input(const CardChannel&) override { refuse_lines(); }
  VoltageRange check_output(const CardChannel& place) override {
    iio_channel* const found = channel(place, true);
    return range_of(chosen_scale(found, place), found, place);
  }
  void check_line_output(const CardChannel&) override { refuse_lines(); }
  void check_line_input(const CardChannel&) override { refuse_lines(); }

 private:
  [[noreturn]] void refuse_lines() const {
    throw Error(name_, "IIO devices have no digital lines",
                {.remedy = "remove the line, or set its device to a card with digital lines"});
  }

  std::vector<std::string> devices() const {
    std::vector<std::string> names;
    for (unsigned i = 0; context_ && i < iio_context_get_devices_count(context_.get()); ++i)
      if (const char* const name = iio_device_get_name(iio_context_get_device(context_.get(), i)))
        names.emplace_back(name);
    return names;
  }

  iio_channel* channel(const CardChannel& place, bool is_output) const {
    if (place.subdevice != 0)
      throw ChannelError("subdevice", Error(name_, "an IIO device has no subdevices",
                                            {.remedy = "remove the key subdevice"}));
    const std::string channel_id = fmt::format("voltage{}", place.channel);
    std::vector<std::string> names;
    for (unsigned i = 0; i < iio_device_get_channels_count(device_); ++i) {
      iio_channel* const candidate = iio_device_get_channel(device_, i);
      if (iio_channel_is_output(candidate) != is_output || iio_channel_find_attr(candidate, "raw") == nullptr)
        continue;
      names.emplace_back(iio_channel_get_id(candidate));
      const bool is_it = place.reference == VoltageReference::differential
                             ? names.back().starts_with(channel_id + "-")
                             : names.back() == channel_id;
      if (is_it) return candidate;
    }
    throw ChannelError(
        "channel",
        Error(name_,
              fmt::format("the device has no {}{} channel {}",
                          place.reference == VoltageReference::differential ? "differential " : "",
                          is_output ? "output" : "input", channel_id),
              {.remedy = names.empty()
                             ? fmt::format("set device to a chip with {}s", is_output ? "output" : "input")
                             : fmt::format("available channels: {}", fmt::join(names, ", "))}));
  }

  /// Refuses an output that another process drives: locks the sysfs attribute of the output. A child process
  /// shares the lock.
  Descriptor own(const iio_channel* output, const CardChannel& place) const {
    const std::string file = fmt::format("/sys/bus/iio/devices/{}/{}", iio_device_get_id(device_),
                                         iio_channel_attr_get_filename(output, "raw"));
    Descriptor raw(open(file.c_str(), O_WRONLY | O_CLOEXEC));
    if (raw.get() < 0 && (errno == EACCES || errno == EPERM))
      throw Error(file, "no permission to write the file",
                  {.remedy = "add a udev rule that gives the file to the group iocard, then log in again"});
    if (raw.get() < 0) throw Error(file, std::strerror(errno), {.remedy = "reload the driver of the chip"});
    if (!lock_byte(raw.get(), 0))
      throw ChannelError("channel",
                         Error(name_, fmt::format("another process already drives channel {}", place.channel),
                               {.remedy = "stop that process (`hystcan doctor` lists running nodes)"}));
    return raw;
  }

  IioConverter converter(iio_channel* channel, const CardChannel& place) {
    const IioScale scale = chosen_scale(channel, place);
    if (const auto raw = raw_range(channel)) set(channel, scale, range_name(scale, *raw), place);
    return {.context = context_,
            .channel = channel,
            .volts = range_of(scale, channel, place),
            .offset = IioScale::number(scale.offset)};
  }

  static VoltageRange range_of(const IioScale& scale, const iio_channel* channel, const CardChannel& place) {
    VoltageRange volts{};
    if (const auto raw = raw_range(channel))
      volts = {.lo = scale.volts(raw->lo), .hi = scale.volts(raw->hi)};
    else
      volts = parsed_range(place.range).value();
    volts.step = scale.step_V();
    return volts;
  }

  static std::string range_name(const IioScale& scale, const RawRange& raw) {
    return fmt::format("{:.4g}..{:.4g} V", scale.volts(raw.lo) + 0.0, scale.volts(raw.hi) + 0.0);
  }

  /// Returns the scale for the range in `place`, or the present scale if `place` has no range.
  IioScale chosen_scale(const iio_channel* channel, const CardChannel& place) const {
    const IioScale present = present_scale(channel);
    if (!(present.step_V() > 0.0))
      throw ChannelError("channel",
                         Error(name_, fmt::format("channel {} has no positive scale", place.channel),
                               {.remedy = "choose a voltage channel"}));
    const auto raw = raw_range(channel);
    if (!raw && !parsed_range(place.range))
      throw ChannelError(
          "range",
          Error(name_, fmt::format("the driver does not report the range of channel {}", place.channel),
                {.remedy = "set range to the voltage range of the channel (example: \"0..10 V\")"}));
    if (!raw) return present;
    std::vector<std::string> names;
    for (const IioScale& candidate : scales(channel, present)) {
      std::string range = range_name(candidate, *raw);
      if (place.range.empty() || range == place.range) return candidate;
      if (std::ranges::find(names, range) == names.end()) names.push_back(std::move(range));
    }
    throw ChannelError("range",
                       Error(name_, fmt::format("channel {} has no range \"{}\"", place.channel, place.range),
                             {.remedy = fmt::format("available ranges: {}", fmt::join(names, ", "))}));
  }

  static IioScale present_scale(const iio_channel* channel) {
    const std::string offset = attribute(channel, "offset");
    return {attribute(channel, "scale"), offset.empty() ? "0" : offset};
  }

  /// Returns all available scales, the present one first.
  static std::vector<IioScale> scales(const iio_channel* channel, const IioScale& present) {
    std::vector<IioScale> all{present};
    std::vector<std::string> offsets = words_of(attribute(channel, "offset_available"));
    if (offsets.empty()) offsets = {present.offset};
    for (const std::string& scale : words_of(attribute(channel, "scale_available")))
      for (const std::string& offset : offsets) all.push_back({scale, offset});
    return all;
  }

  /// Sets scale and offset of a channel, for the voltage range `range`. Several channels can share one scale
  /// attribute, and must then have the same range. Throws ChannelError if another channel with the same scale
  /// attribute has a different range.
  void set(iio_channel* channel, const IioScale& scale, const std::string& range, const CardChannel& place) {
    const char* const file = iio_channel_attr_get_filename(channel, "scale");
    const std::string& first = ranges_.try_emplace(file == nullptr ? "" : file, range).first->second;
    if (first != range)
      throw ChannelError(
          "range",
          Error(name_,
                fmt::format("channel {} shares its range with another channel, which is set to \"{}\"",
                            place.channel, first),
                {.remedy = "set the same range for both channels"}));
    const auto is_set = [&] {
      const IioScale now = present_scale(channel);
      return now.volts(0.0) == scale.volts(0.0) && now.step_V() == scale.step_V();
    };
    // The driver may reject the scale while the old offset is set. So the scale is written again after the
    // offset.
    for (const auto& [name, value] : {std::pair("scale", &scale.scale_mV), std::pair("offset", &scale.offset),
                                      std::pair("scale", &scale.scale_mV)})
      if (!is_set()) iio_channel_attr_write(channel, name, value->c_str());
    if (!is_set())
      throw ChannelError(
          "range",
          Error(name_,
                fmt::format("the driver rejects the range \"{}\" for channel {}", range, place.channel),
                {.remedy = "make the scale of the channel in /sys writable, or remove the key range"}));
  }

  std::string name_;
  IioContext context_;
  iio_device* device_ = nullptr;
  std::map<std::string, std::string> ranges_;  ///< key: file of a scale attribute; value: its range
};

}  // namespace

std::unique_ptr<Card> open_iio_card(const std::string& name) { return std::make_unique<IioCard>(name); }

}  // namespace hystcan::node
