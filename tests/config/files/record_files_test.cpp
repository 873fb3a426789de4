// One record of 600 rows in the formats of many instruments: each file gives its stroke, or one helpful
// sentence.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <ostream>
#include <string>

#include "base/error.h"
#include "config/files/clock_time.h"
#include "config/files/dataset_file.h"
#include "tests/support/scratch.h"

namespace hystcan::config::record_files_test {
namespace {

struct RecordFile {
  const char* name;
  DatasetLayout layout{};
  const char* refusal = "";  ///< empty: the file gives the stroke
  std::size_t rows = 600;

  friend void PrintTo(const RecordFile& file, std::ostream* out) { *out << file.name; }
};

std::filesystem::path path_of(const std::string& name) {
  return std::filesystem::path(HYSTCAN_SOURCE_DIR "/tests/config/files/records") / name;
}

class RecordFiles : public testing::TestWithParam<RecordFile> {};

/// Expects the stroke, or the refusal without the name of the file.
void expect_stroke(const std::filesystem::path& file, DatasetLayout layout, const std::string& refusal,
                   std::size_t rows) {
  layout.has_interval_options = true;
  try {
    const identification::Dataset dataset = load_dataset(file, layout).dataset;
    EXPECT_EQ(refusal, "") << "accepted";
    EXPECT_EQ(dataset.size(), rows);
    const auto [least, most] = std::ranges::minmax(dataset.output);
    EXPECT_NEAR((most - least) * (dataset.output_unit == "nm" ? 1e-3 : 1.0), 30.266, 5e-4) << "um";
    EXPECT_NEAR(dataset.time_s[1] - dataset.time_s[0], 0.01, 1e-9) << "s";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).substr(file.string().size()), refusal);
  }
}

TEST_P(RecordFiles, GiveTheStrokeOrASentence) {
  expect_stroke(path_of(GetParam().name), GetParam().layout, GetParam().refusal, GetParam().rows);
}

const DatasetLayout by_number{.columns = "1,2,3"};
const DatasetLayout scaled{.columns = "1,2,3", .output_scale = 10.0};

INSTANTIATE_TEST_SUITE_P(
    , RecordFiles,
    testing::Values(
        RecordFile{"base_accepted.csv"}, RecordFile{"base_accepted.csv", by_number},
        RecordFile{"base_accepted.csv", scaled,
                   ":3:1: output_unit is \"um\" in the file: --output-scale is not allowed"},
        RecordFile{
            "01_keysight_two_header_lines.csv",
            {},
            ":1:1: more than one column among x-axis, 1 [V], 2 [V] can be the input, expected columns named "
            "time_s, input and output, or --columns TIME,INPUT,OUTPUT with column names or numbers from 1 to "
            "3"},
        RecordFile{"01_keysight_two_header_lines.csv", scaled},
        RecordFile{"02_rigol_two_header_lines.csv", scaled},
        RecordFile{"03_siglent_source_second_volt.csv", scaled},
        RecordFile{"04_tek_two_channels_metadata.csv", {.columns = "1,2,5", .output_scale = 10.0}},
        RecordFile{"04_tek_two_channels_metadata.csv", by_number,
                   ":14:23: column 3 is empty, expected a number"},
        RecordFile{"04_tek_two_channels_metadata.csv", {.columns = "1,2,4,5", .output_scale = 10.0}},
        RecordFile{
            "05_tek_one_channel_per_file_CH1.csv",
            {},
            ":1:1: two columns of numbers, expected time, input and output: --output-from FILE reads the "
            "output from another file, and --rate HZ reads a file without time"},
        RecordFile{"05_tek_one_channel_per_file_CH1.csv",
                   {.output_scale = 10.0, .output_from = path_of("05_tek_one_channel_per_file_CH2.csv")}},
        RecordFile{"05_tek_one_channel_per_file_CH1.csv",
                   {.columns = "4,5",
                    .output_scale = 10.0,
                    .output_from = path_of("05_tek_one_channel_per_file_CH2.csv")}},
        RecordFile{"06_picoscope_mV.csv", scaled},
        RecordFile{"10_each_channel_its_time.csv", {.output_scale = 10.0}},
        RecordFile{"10_each_channel_its_time.csv", {.columns = "1,2,4", .output_scale = 10.0}},
        RecordFile{"12_numpy_savetxt_header.txt"}, RecordFile{"12_numpy_savetxt_header.txt", by_number},
        RecordFile{"13_blanks_in_names.txt"}, RecordFile{"14_unit_words.csv"},
        RecordFile{
            "15_nan_at_the_ends.csv",
            {},
            ":2:3: V is \"NaN\", expected a finite number; --from 0.01 selects only the rows after the "
            "damage"},
        RecordFile{
            "15_nan_at_the_ends.csv",
            {.from_s = 0.01},
            ":600:16: x is \"NaN\", expected a finite number; --to 5.97 selects only the rows before the "
            "damage"},
        RecordFile{"15_nan_at_the_ends.csv", {.from_s = 0.01, .to_s = 5.97}, "", 597},
        RecordFile{"16_text_at_the_end.csv"}, RecordFile{"17_cut_in_the_last_row.csv", {}, "", 599},
        RecordFile{
            "19_time_restarts.csv",
            {},
            ":602: t is 0 after 5.99, expected an increasing time: --to 5.99 selects only the rows before "
            "the time goes back"},
        RecordFile{"19_time_restarts.csv", {.to_s = 5.99}}, RecordFile{"20_clock_time.csv"},
        RecordFile{"20_clock_time.csv", {.columns = "2,3", .rate_Hz = 100.0}}, RecordFile{"23_epoch_ms.csv"},
        RecordFile{"24_decimal_commas_in_quotes.csv"},
        RecordFile{
            "25_time_rounded.csv",
            {},
            ":3: Time (s) is 200 after 200, expected an increasing time: if the time is rounded, --columns "
            "2,3 --rate HZ reads the file without its time column"},
        RecordFile{"25_time_rounded.csv", {.columns = "2,3", .rate_Hz = 100.0}}));

/// A row number, a time in s, a drive in V, a position in um.
using Line = std::string (*)(int, double, double, double);

struct WornDress {
  const char* name;
  std::string head;
  Line line;
  DatasetLayout layout{};
  const char* refusal = "";
  const char* foot = "";

  friend void PrintTo(const WornDress& dress, std::ostream* out) { *out << dress.name; }
};

class OtherInstruments : public testing::TestWithParam<WornDress> {};

TEST_P(OtherInstruments, GiveTheStrokeOrASentence) {
  const WornDress& dress = GetParam();
  const identification::Dataset base = load_dataset(path_of("base_accepted.csv")).dataset;
  std::string text = dress.head;
  for (std::size_t i = 0; i < base.size(); ++i)
    text += dress.line(static_cast<int>(i), base.time_s[i], base.input[i], base.output[i]);
  const auto file = support::scratch_file("dress.txt");
  std::ofstream(file, std::ios::binary) << text << dress.foot;
  expect_stroke(file, dress.layout, dress.refusal, base.size());
}

std::string with_comma(std::string text) {
  std::ranges::replace(text, '.', ',');
  return text;
}
/// Six decimals, a comma, and a mark between thousands.
std::string with_thousands(double value, const std::string& mark) {
  std::string text = with_comma(fmt::format("{:.6f}", value));
  if (value >= 1000.0) text.insert(text.find(',') - 3, mark);
  return text;
}
std::string plain(int, double t, double v, double x) {
  return fmt::format("{:.2f},{:.5f},{:.5f}\n", t, v, x);
}
std::string counted_by(int unit, double v, double x) { return fmt::format("{},{:.5f},{:.5f}\n", unit, v, x); }

INSTANTIATE_TEST_SUITE_P(
    , OtherInstruments,
    testing::Values(
        WornDress{
            "Yokogawa: settings with numbers in the columns of the rows",
            "\"TraceName\",\"CH1\",\"CH2\"\n\"BlockSize\",600,600\n\"VUnit\",\"V\",\"V\"\n\"HResolution\","
            "1.0000000E-02,1.0000000E-02\n\"DisplayBlockSize\",600,600\n\"DisplayPointNo.\",1,1\n\n",
            [](int, double, double v, double x) { return fmt::format(",{:.5E},{:.6E}\n", v, x / 10.0); },
            {.columns = "2,3", .output_scale = 10.0}},
        WornDress{"LabVIEW: a remark behind the first row",
                  "Y_Unit_Label\tVolts\tVolts\nDelta_X\t0,010000\t0,010000\n***End_of_Header***\t\t\t\n"
                  "X_Value\tDrive\tPosition\tComment\n",
                  [](int i, double, double v, double x) {
                    return with_comma(
                        fmt::format("\t{:.6f}\t{:.6f}{}\r\n", v, x / 10.0, i == 0 ? "\tstart" : ""));
                  },
                  {.output_scale = 10.0}},
        WornDress{
            "TwinCAT Scope: SampleTime[ms], and times in ms without a unit",
            "Name\tfDrive\tName\tfPosition\nSampleTime[ms]\t10\tSampleTime[ms]\t10\nPort\t851\tPort\t851\n\n",
            [](int i, double, double v, double x) {
              return with_comma(fmt::format("{}\t{:.6f}\t{}\t{:.6f}\r\n", 10 * i, v, 10 * i, x));
            },
            {.columns = "1,2,4"}},
        WornDress{
            "PicoScope: an overflow in the first row", "Time,Channel A,Channel B\n(ms),(V),(V)\n\n",
            [](int i, double time, double v, double x) {
              return fmt::format("{:.5f},{:.5f},{}\n", 1e3 * time, v,
                                 i == 0 ? "\u221e" : fmt::format("{:.6f}", x));
            },
            by_number,
            ":4:17: Channel B is \"\u221e\", expected a finite number; --from 0.01 selects only the rows "
            "after the damage"},
        WornDress{"PI: a GCS array",
                  "# REM E-709\n# SAMPLE_TIME = 0.010000\n# NAME0 = Control Voltage\n# END_HEADER\n",
                  [](int, double, double v, double x) { return fmt::format("{:.6f} {:.6f} \n", v, x); },
                  {.columns = "1,2"}},
        WornDress{"attocube: pm", "Time [s],Drive [V],Position [pm]\n",
                  [](int, double time, double v, double x) {
                    return fmt::format("{:.2f},{:.5f},{:.0f}\n", time, v, 1e6 * x);
                  }},
        WornDress{"MATLAB: dates with names of months", "Time,Drive (V),Position (um)\n",
                  [](int, double time, double v, double x) {
                    return fmt::format("04-Mar-2026 14:07:{:05.2f},{:.5f},{:.5f}\n", 50.0 + time, v, x);
                  }},
        WornDress{"a spreadsheet with blanks between thousands", "Zeit (ms);U (V);Weg (nm)\n",
                  [](int, double time, double v, double x) {
                    return fmt::format("{};{};{}\n", with_thousands(1e3 * time, " "), with_thousands(v, " "),
                                       with_thousands(1e3 * x, " "));
                  }},
        WornDress{"line ends CR CR LF", "t [s],U [V],x [um]\r\r\n",
                  [](int i, double time, double v, double x) {
                    std::string text = plain(i, time, v, x);
                    return text.insert(text.size() - 1, "\r\r");
                  }},
        WornDress{"units as names", "ms,V,um\n",
                  [](int i, double, double v, double x) { return counted_by(10 * i, v, x); }},
        WornDress{"names behind a semicolon", "; t[s] u[V] x[um]\n",
                  [](int, double time, double v, double x) {
                    return fmt::format("{:.2f} {:.5f} {:.5f}\n", time, v, x);
                  }},
        WornDress{"means below a blank line", "t (s),u (V),x (um)\n", plain, {}, "", "\n600,50.1,15.2\n"},
        WornDress{
            "a further number in the first row",
            "t (s),u (V),x (um)\n",
            [](int i, double time, double v, double x) {
              return fmt::format("{:.2f},{:.5f},{:.5f}{}\n", time, v, x, i == 0 ? ",5" : "");
            },
            {},
            ":2:1: the row has 4 fields, expected 3 as in the header; --from 0.01 selects only the rows "
            "after the damage"},
        WornDress{
            "times in whole numbers without a unit",
            "time,drive,position\n",
            [](int i, double, double v, double x) { return counted_by(10 * i, v, x); },
            {},
            ":3: time increases by 10 and has no unit, expected a unit in the name of the column (as in "
            "t_ms), or --rate with the rows per second"},
        WornDress{"times in whole numbers beside a rate",
                  "time,drive,position\n",
                  [](int i, double, double v, double x) { return counted_by(10 * i, v, x); },
                  {.rate_Hz = 100.0}}));

TEST(RecordNotes, NameUnknownUnits) {
  const auto notes = [](const std::string& head, const DatasetLayout& layout = {}) {
    const auto file = support::scratch_file("units.csv");
    std::ofstream(file) << head << "\n0.5,1,2\n0.6,2,3\n";
    return load_dataset(file, layout).notes;
  };
  using Notes = std::vector<std::string>;
  EXPECT_EQ(notes("t (s),U (V),x (um)"), Notes{});
  EXPECT_EQ(notes("t,U (V),x (um)"), Notes{"t has no unit: it is taken as a time in s"});
  EXPECT_EQ(notes("t (s),U (cV),x (um)"),
            Notes{"the unit cV of U (cV) is unknown, so its numbers are not converted"});
  EXPECT_EQ(notes("t (s),U (V),x (digits)", {.output_scale = 0.5}),
            Notes{"--output-scale 0.5 is taken as um per digits of x (digits)"});
  EXPECT_EQ(notes("t (s),U (V),x", {.output_scale = 0.5}),
            Notes{"--output-scale 0.5 is taken as um per 1 of x"});
  EXPECT_EQ(notes("t (s),U (V),x (mV)", {.output_scale = 0.5}), Notes{}) << "um per V";
}

// The sanitizers detect an access beyond the text.
TEST(ClockTime, HasNoDateOfDigitsAlone) { EXPECT_FALSE(clock_time("123456789 1:02:03")); }

}  // namespace
}  // namespace hystcan::config::record_files_test
