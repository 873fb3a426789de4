#include "node/analogue/comedi_card.h"

#include <comedilib.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "node/analogue/lock_byte.h"

namespace hystcan::node {
namespace {

struct Close {
  void operator()(comedi_t* device) const { comedi_close(device); }
};
using Device = std::shared_ptr<comedi_t>;

static_assert(AREF_GROUND == static_cast<int>(VoltageReference::ground) &&
              AREF_COMMON == static_cast<int>(VoltageReference::common) &&
              AREF_DIFF == static_cast<int>(VoltageReference::differential));

/// A channel of a card, and the conversion between volts and raw values.
struct Converter {
  Device device;
  unsigned subdevice = 0;
  unsigned channel = 0;
  unsigned range_index = 0;
  unsigned reference = AREF_GROUND;
  comedi_range* range = nullptr;  ///< voltage range of the channel; owned by comedilib
  lsampl_t largest = 0;
  VoltageRange volts{};
};

class ComediOutput final : public VoltageOutput {
 public:
  explicit ComediOutput(Converter converter) : converter_(std::move(converter)) {}
  const VoltageRange& range() const override { return converter_.volts; }
  bool write(double volts) override {
    const Converter& c = converter_;
    return comedi_data_write(c.device.get(), c.subdevice, c.channel, c.range_index, c.reference,
                             comedi_from_phys(volts, c.range, c.largest)) == 1;
  }

 private:
  Converter converter_;
};

class ComediInput final : public VoltageInput {
 public:
  explicit ComediInput(Converter converter) : converter_(std::move(converter)) {}
  const VoltageRange& range() const override { return converter_.volts; }
  std::optional<double> read() override {
    const Converter& c = converter_;
    lsampl_t data = 0;
    if (comedi_data_read(c.device.get(), c.subdevice, c.channel, c.range_index, c.reference, &data) != 1)
      return std::nullopt;
    return std::lerp(c.volts.lo, c.volts.hi, static_cast<double>(data) / c.largest);
  }

 private:
  Converter converter_;
};

class ComediLineOutput final : public LineOutput {
 public:
  ComediLineOutput(Device device, const CardChannel& place) : device_(std::move(device)), place_(place) {}
  bool write(bool on) override {
    return comedi_dio_write(device_.get(), place_.subdevice, place_.channel, on ? 1 : 0) == 1;
  }

 private:
  Device device_;
  CardChannel place_;
};

class ComediLineInput final : public LineInput {
 public:
  ComediLineInput(Device device, const CardChannel& place) : device_(std::move(device)), place_(place) {}
  std::optional<bool> read() override {
    unsigned bit = 0;
    if (comedi_dio_read(device_.get(), place_.subdevice, place_.channel, &bit) != 1) return std::nullopt;
    return bit != 0;
  }

 private:
  Device device_;
  CardChannel place_;
};

std::string text_of(const comedi_range& range) { return fmt::format("{:g}..{:g} V", range.min, range.max); }

class ComediCard final : public Card {
 public:
  explicit ComediCard(const std::string& file) : file_(file), device_(comedi_open(file.c_str()), Close{}) {
    if (!device_) fail_to_open(errno);
  }

  std::unique_ptr<VoltageOutput> output(const CardChannel& place) override {
    Converter found = converter(place, COMEDI_SUBD_AO, "analogue outputs");
    own(place);
    return std::make_unique<ComediOutput>(std::move(found));
  }
  std::unique_ptr<VoltageInput> input(const CardChannel& place) override {
    return std::make_unique<ComediInput>(converter(place, COMEDI_SUBD_AI, "analogue inputs"));
  }
  std::unique_ptr<LineOutput> line_output(const CardChannel& place) override {
    check_line_output(place);
    direct(place, COMEDI_OUTPUT);
    return std::make_unique<ComediLineOutput>(device_, place);
  }
  std::unique_ptr<LineInput> line_input(const CardChannel& place) override {
    check_line_input(place);
    direct(place, COMEDI_INPUT);
    return std::make_unique<ComediLineInput>(device_, place);
  }
  VoltageRange check_output(const CardChannel& place) override {
    return converter(place, COMEDI_SUBD_AO, "analogue outputs").volts;
  }
  void check_line_output(const CardChannel& place) override {
    check_line(place, COMEDI_SUBD_DO, "digital outputs");
  }
  void check_line_input(const CardChannel& place) override {
    check_line(place, COMEDI_SUBD_DI, "digital inputs");
  }

 private:
  [[noreturn]] void fail_to_open(int error) const {
    if (error == EACCES || error == EPERM)
      throw Error(
          file_, "no permission to open the device",
          {.remedy = "add the user to the group of the file (sudo adduser USER iocard), then log in again"});
    if (error == EBUSY)
      throw Error(file_, "another program is using the device", {.remedy = "stop that program"});
    if (error == ENOENT || error == ENXIO || error == ENODEV || error == ENOTDIR)
      throw Error(file_, "card not found",
                  {.remedy = "load the driver of the card, or set device to another file (ls /dev/comedi*)"});
    if (error == ENOTTY || error == EISDIR || error == EINVAL)
      throw Error(file_, "not a comedi device",
                  {.remedy = "set device to a comedi device file (ls /dev/comedi*)"});
    throw Error(file_, comedi_strerror(comedi_errno()),
                {.remedy = "set device to another card (ls /dev/comedi*)"});
  }

  /// Lists the subdevices of these types, for example "1, 3".
  std::string subdevices(std::initializer_list<int> types) const {
    std::vector<int> found;
    for (int i = 0; i < comedi_get_n_subdevices(device_.get()); ++i)
      if (std::ranges::find(types, comedi_get_subdevice_type(device_.get(), static_cast<unsigned>(i))) !=
          types.end())
        found.push_back(i);
    return fmt::format("{}", fmt::join(found, ", "));
  }

  [[noreturn]] void fail_without(const CardChannel& place, std::string_view kind,
                                 std::initializer_list<int> types) const {
    const std::string others = subdevices(types);
    throw ChannelError(
        "subdevice", Error(file_, fmt::format("subdevice {} has no {}", place.subdevice, kind),
                           {.remedy = others.empty() ? fmt::format("set device to a card with {}", kind)
                                                     : fmt::format("set subdevice to one of: {}", others)}));
  }

  /// Refuses an output that another process drives: locks one byte of the device file for each channel. A
  /// child process shares the lock.
  void own(const CardChannel& place) const {
    const auto byte = static_cast<off_t>(place.subdevice) * 65'536 + place.channel;
    if (!lock_byte(comedi_fileno(device_.get()), byte))
      throw ChannelError("channel",
                         Error(file_,
                               fmt::format("another process already drives channel {} of subdevice {}",
                                           place.channel, place.subdevice),
                               {.remedy = "stop that process (`hystcan doctor` lists running nodes)"}));
  }

  void check_channel(const CardChannel& place, std::string_view key, std::string_view kind) const {
    const int channels = comedi_get_n_channels(device_.get(), place.subdevice);
    if (channels <= 0 || place.channel >= static_cast<unsigned>(channels))
      throw ChannelError(
          key, Error(file_, fmt::format("subdevice {} has no {} {}", place.subdevice, key, place.channel),
                     {.remedy = fmt::format("the subdevice has {} {}, numbered from 0", std::max(channels, 0),
                                            kind)}));
  }

  void check_line(const CardChannel& place, int only, std::string_view kind) const {
    const int type = comedi_get_subdevice_type(device_.get(), place.subdevice);
    if (type != only && type != COMEDI_SUBD_DIO) fail_without(place, kind, {only, COMEDI_SUBD_DIO});
    check_channel(place, "line", "lines");
  }

  void direct(const CardChannel& place, unsigned direction) {
    comedi_t* const device = device_.get();
    if (comedi_get_subdevice_type(device, place.subdevice) == COMEDI_SUBD_DIO &&
        comedi_dio_config(device, place.subdevice, place.channel, direction) < 0)
      throw ChannelError("line",
                         Error(file_,
                               fmt::format("line {} of subdevice {} cannot be used as an {}", place.channel,
                                           place.subdevice, direction == COMEDI_OUTPUT ? "output" : "input"),
                               {.remedy = "choose another line"}));
  }

  Converter converter(const CardChannel& place, int type, std::string_view kind) const {
    comedi_t* const device = device_.get();
    if (comedi_get_subdevice_type(device, place.subdevice) != type) fail_without(place, kind, {type});
    check_channel(place, "channel", kind);
    Converter found{.device = device_, .subdevice = place.subdevice, .channel = place.channel};
    found.range_index = range_index(place);
    found.reference = static_cast<unsigned>(place.reference);
    found.range = comedi_get_range(device, place.subdevice, place.channel, found.range_index);
    found.largest = comedi_get_maxdata(device, place.subdevice, place.channel);
    const double steps = found.largest;
    found.volts = {found.range->min, found.range->max, (found.range->max - found.range->min) / steps};
    return found;
  }

  unsigned range_index(const CardChannel& place) const {
    const int count = comedi_get_n_ranges(device_.get(), place.subdevice, place.channel);
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) {
      const comedi_range* const range =
          comedi_get_range(device_.get(), place.subdevice, place.channel, static_cast<unsigned>(i));
      if (range == nullptr || range->unit != UNIT_volt) continue;
      names.push_back(text_of(*range));
      if (place.range.empty() || names.back() == place.range) return static_cast<unsigned>(i);
    }
    if (names.empty())
      throw ChannelError("channel", Error(file_,
                                          fmt::format("channel {} of subdevice {} has no range in volts",
                                                      place.channel, place.subdevice),
                                          {.remedy = "choose another channel"}));
    throw ChannelError("range",
                       Error(file_,
                             fmt::format("channel {} of subdevice {} has no range \"{}\"", place.channel,
                                         place.subdevice, place.range),
                             {.remedy = fmt::format("available ranges: {}", fmt::join(names, ", "))}));
  }

  std::string file_;
  Device device_;
};

}  // namespace

std::unique_ptr<Card> open_comedi_card(const std::string& file) { return std::make_unique<ComediCard>(file); }

}  // namespace hystcan::node
