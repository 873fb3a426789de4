#include "config/files/record_words.h"

#include <algorithm>
#include <cctype>
#include <span>

namespace hystcan::config {
namespace {

using Words = std::span<const std::string_view>;

constexpr auto of_time = ColumnMeaning::time, of_input = ColumnMeaning::input,
               of_output = ColumnMeaning::output;

constexpr std::array<UnitWord, 27> unit_words{
    {{"s", "s", 1.0, of_time, " sec secs second seconds sekunde sekunden "},
     {"ms", "s", 1e-3, of_time, " msec msecs millisecond milliseconds "},
     {"us", "s", 1e-6, of_time, " usec usecs microsecond microseconds "},
     {"ns", "s", 1e-9, of_time, " nsec nsecs nanosecond nanoseconds "},
     {"min", "s", 60.0, of_time, " minute minutes minuten "},
     {"h", "s", 3600.0, of_time, " hour hours "},
     {"V", "V", 1.0, of_input, " volt volts "},
     {"mV", "V", 1e-3, of_input, " millivolt millivolts "},
     {"uV", "V", 1e-6, of_input, " microvolt microvolts "},
     {"kV", "V", 1e3, of_input, " kilovolt kilovolts "},
     {"A", "A", 1.0, of_input, " amp amps ampere amperes "},
     {"mA", "A", 1e-3, of_input, " milliamp milliamps milliampere milliamperes "},
     {"pm", "nm", 1e-3, of_output, " picometer picometers picometre picometres "},
     {"\xC3\x85", "nm", 0.1, of_output, " \xE2\x84\xAB angstrom angstroms "},
     {"mil", "um", 25.4, of_output, " mils thou "},
     {"inch", "um", 25'400.0, of_output, " inches "},
     {"nm", "nm", 1.0, of_output, " nanometer nanometers nanometre nanometres "},
     {"um", "um", 1.0, of_output,
      " micron microns micrometer micrometers micrometre micrometres mikrometer "},
     {"mm", "mm", 1.0, of_output, " millimeter millimeters millimetre millimetres "},
     {"m", "m", 1.0, of_output, " meter meters metre metres "},
     {"Hz", "Hz", 1.0, std::nullopt, " hertz "},
     {"kHz", "Hz", 1e3, std::nullopt, " kilohertz "},
     {"%", "%", 1.0, std::nullopt, " percent "},
     {"T", "T", 1.0, std::nullopt, " tesla "},
     {"K", "K", 1.0, std::nullopt, " kelvin "},
     {"N", "N", 1.0, std::nullopt, " newton "},
     {"deg", "deg", 1.0, std::nullopt, " degree degrees "}}};

// The usual column names of time, input and output, in lower case. The names of a time column
// from "sample" to "sequence" mean the sample number.
constexpr std::array<std::string_view, 13> time_words{
    "time",  "t", "zeit", "timestamp", "elapsed",   "seconds", "sample",
    "index", "n", "#",    "nr",        "messpunkt", "sequence"};
constexpr Words sample_words = Words(time_words).subspan(6);
constexpr std::array<std::string_view, 19> input_words{
    "input",       "drive",         "voltage",        "u",        "v",       "volt",  "current",
    "i",           "command",       "setpoint",       "h",        "field",   "strom", "excitation",
    "ansteuerung", "piezospannung", "steuerspannung", "sollwert", "spannung"};
constexpr std::array<std::string_view, 18> output_words{
    "output",         "position", "pos",        "x", "y",          "displacement", "disp",    "stroke",
    "sensor",         "strain",   "elongation", "b", "deflection", "measured",     "istwert", "wegsensor",
    "sensorspannung", "weg"};
constexpr std::array<Words, 3> usual_words{time_words, input_words, output_words};

// The words of instrument settings. The search takes the first word with which the text begins. So a longer
// word is listed before a shorter word with the same beginning: "xincrement" before "xinc".
constexpr std::array<std::string_view, 9> rate_words{"abtastrate",  "abtastfrequenz",     "sampling rate",
                                                     "sample rate", "sampling frequency", "sample frequency",
                                                     "samplerate",  "sampling_rate",      "sample_rate"};
constexpr std::array<std::string_view, 19> interval_words{
    "sample interval", "sampling interval", "sample_interval", "sample time",
    "sample_time",     "sampling time",     "sample period",   "sampling period",
    "sampletime",      "sampling_period",   "sample_period",   "hresolution",
    "increment",       "x increment",       "xincrement",      "xinc",
    "delta_x",         "delta x",           "abtastintervall"};
constexpr std::array<std::string_view, 2> time_unit_words{"horizontal units", "hunit"};
constexpr std::array<std::string_view, 4> value_unit_words{"vertical units", "y_unit_label", "y units",
                                                           "vunit"};
constexpr std::array<Words, 4> setting_words{rate_words, interval_words, time_unit_words, value_unit_words};

bool has(Words list, std::string_view word) { return std::ranges::find(list, word) != list.end(); }

bool has_word(const UnitWord& unit, std::string_view lower) {
  return lower.size() > 2 && unit.others.find(" " + std::string(lower) + " ") != std::string_view::npos;
}

}  // namespace

const UnitWord* find_unit(std::string_view text) {
  const std::string plain = with_u(text);
  if (const auto symbol = std::ranges::find(unit_words, plain, &UnitWord::symbol); symbol != unit_words.end())
    return &*symbol;
  const std::string lower = lower_case(plain);
  if (lower.find(' ') != std::string::npos) return nullptr;
  const auto word =
      std::ranges::find_if(unit_words, [&](const UnitWord& unit) { return has_word(unit, lower); });
  return word == unit_words.end() ? nullptr : &*word;
}

bool is_clock_form(std::string_view text) { return lower_case(text).find("h:mm") != std::string::npos; }

std::string listed_units(ColumnMeaning meaning) {
  std::string list;
  for (const UnitWord& unit : unit_words)
    if (unit.meaning == meaning) list.append(list.empty() ? "" : ", ").append(unit.symbol);
  return list;
}

int name_likeness(std::string_view name, ColumnMeaning meaning) {
  const Words words = usual_words[static_cast<std::size_t>(meaning)];
  if (has(words, name)) return 4;
  const auto is_part = [&](std::string_view word) {
    return word.size() > 2 && name.find(word) != std::string_view::npos;
  };
  return std::ranges::any_of(words, is_part) ? 2 : 0;
}

bool counts_samples(std::string_view name) { return has(sample_words, name); }

std::optional<FoundSetting> find_setting(std::string_view text) {
  for (std::size_t i = 0; i < setting_words.size(); ++i)
    for (const std::string_view words : setting_words[i])
      if (text.starts_with(words)) return FoundSetting{static_cast<RecordSetting>(i), words.size()};
  return std::nullopt;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return lower;
}

std::string with_u(std::string_view text) {
  std::string plain(text);
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC", "\xB5"})
    for (std::size_t at = plain.find(micro); at != std::string::npos; at = plain.find(micro))
      plain.replace(at, micro.size(), "u");
  return plain;
}

}  // namespace hystcan::config
