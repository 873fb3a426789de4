// One record of 600 rows as many instruments write it: each file gives its figure, or one sentence that
// helps.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "base/error.h"
#include "config/files/dataset_file.h"

namespace hystcan::config::record_files_test {
namespace {

struct RecordFile {
  const char* name;
  DatasetLayout layout{};
  const char* refusal = "";  ///< empty: the figure
  std::size_t rows = 600;

  friend void PrintTo(const RecordFile& file, std::ostream* out) { *out << file.name; }
};

std::filesystem::path path_of(const std::string& name) {
  return std::filesystem::path(HYSTCAN_SOURCE_DIR "/tests/config/files/records") / name;
}

class RecordFiles : public testing::TestWithParam<RecordFile> {};

TEST_P(RecordFiles, GiveTheStrokeOrASentence) {
  DatasetLayout layout = GetParam().layout;
  layout.has_interval_options = true;
  const std::filesystem::path file = path_of(GetParam().name);
  try {
    const identification::Dataset dataset = load_dataset(file, layout).dataset;
    EXPECT_STREQ(GetParam().refusal, "") << "accepted";
    EXPECT_EQ(dataset.size(), GetParam().rows);
    const auto [least, most] = std::ranges::minmax(dataset.output);
    EXPECT_NEAR(most - least, 30.266, 5e-4) << "um";
    EXPECT_NEAR(dataset.time_s[1] - dataset.time_s[0], 0.01, 1e-9) << "s";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).substr(file.string().size()), GetParam().refusal);
  }
}

const DatasetLayout by_number{.columns = "1,2,3"};
const DatasetLayout scaled{.columns = "1,2,3", .output_scale = 10.0};

INSTANTIATE_TEST_SUITE_P(
    , RecordFiles,
    testing::Values(
        RecordFile{"base_accepted.csv"}, RecordFile{"base_accepted.csv", by_number},
        RecordFile{"base_accepted.csv", scaled,
                   ":3:1: the file says output_unit = \"um\", expected no --output-scale"},
        RecordFile{
            "01_keysight_two_header_lines.csv",
            {},
            ":1:1: more than one column is the input among x-axis, 1 [V], 2 [V], expected time_s, input, "
            "output, or --columns TIME,INPUT,OUTPUT by names or numbers from 1 to 3"},
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
            "output from another file, and --rate a file without time"},
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
        RecordFile{"15_nan_at_the_ends.csv",
                   {},
                   ":2:3: V is \"NaN\", expected a finite number; --from 0.01 begins behind it"},
        RecordFile{"15_nan_at_the_ends.csv",
                   {.from_s = 0.01},
                   ":600:16: x is \"NaN\", expected a finite number; --to 5.97 ends before it"},
        RecordFile{"15_nan_at_the_ends.csv", {.from_s = 0.01, .to_s = 5.97}, "", 597},
        RecordFile{"16_text_at_the_end.csv"}, RecordFile{"17_cut_in_the_last_row.csv", {}, "", 599},
        RecordFile{"19_time_restarts.csv",
                   {},
                   ":602: t is 0 after 5.99, expected time to increase: --to 5.99 keeps the rows before"},
        RecordFile{"19_time_restarts.csv", {.to_s = 5.99}}, RecordFile{"20_clock_time.csv"},
        RecordFile{"20_clock_time.csv", {.columns = "2,3", .rate_Hz = 100.0}}, RecordFile{"23_epoch_ms.csv"},
        RecordFile{"24_decimal_commas_in_quotes.csv"},
        RecordFile{
            "25_time_rounded.csv",
            {},
            ":3: Time (s) is 200 after 200, expected time to increase: if it is rounded, --columns 2,3 "
            "--rate HZ reads the file without it"},
        RecordFile{"25_time_rounded.csv", {.columns = "2,3", .rate_Hz = 100.0}}));

}  // namespace
}  // namespace hystcan::config::record_files_test
