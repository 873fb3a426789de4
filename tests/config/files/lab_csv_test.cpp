// Datasets in the formats of laboratories.
#include <gtest/gtest.h>

#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "base/error.h"
#include "config/files/dataset_file.h"
#include "tests/support/refusal.h"
#include "tests/support/scratch.h"

namespace hystcan::config::lab_csv_test {
namespace {

std::filesystem::path written(const std::string& text) {
  const auto file = support::scratch_file("scope.csv");
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

DatasetFile load(const std::string& text, const DatasetLayout& layout = {}) {
  return load_dataset(written(text), layout);
}

std::string refusal(const std::string& text, const DatasetLayout& layout = {}) {
  const auto file = written(text);
  const std::string message = support::refusal_of([&] { load_dataset(file, layout); });
  return message == "accepted" ? message : message.substr(file.string().size());
}

struct Format {
  const char* name;
  std::string text;
  const char* taken;
  const char* input_unit = "";
  const char* output_unit = "";

  friend void PrintTo(const Format& format, std::ostream* out) { *out << format.name; }
};

class LabCsv : public testing::TestWithParam<Format> {};

// Every file contains the rows (0, 1.5, 2.25), (0.001, -1, 3), (0.002, 0, 4).
TEST_P(LabCsv, IsReadWithItsUnits) {
  const DatasetFile loaded = load(GetParam().text);
  const std::vector<double> time_s{0.0, 0.001, 0.002}, input{1.5, -1.0, 0.0}, output{2.25, 3.0, 4.0};
  ASSERT_EQ(loaded.dataset.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(loaded.dataset.time_s[i], time_s[i], 1e-15);
    EXPECT_NEAR(loaded.dataset.input[i], input[i], 1e-15);
    EXPECT_EQ(loaded.dataset.output[i], output[i]);
  }
  EXPECT_EQ(loaded.taken, GetParam().taken);
  EXPECT_EQ(loaded.dataset.input_unit, GetParam().input_unit);
  EXPECT_EQ(loaded.dataset.output_unit, GetParam().output_unit);
}

INSTANTIATE_TEST_SUITE_P(
    , LabCsv,
    testing::Values(
        Format{"OurOwn", "time_s,input,output\n0,1.5,2.25\n0.001,-1,3\n0.002,0,4\n", ""},
        Format{"ShortNames", "t, V, x\n0,1.5,2.25\n0.001,-1,3\n0.002,0,4\n",
               "time from t, input from V, output from x"},
        Format{"UnitsInParentheses",
               "\"Time (ms)\",\"Drive (mV)\",\"Position (nm)\"\r\n0,1500,2.25\r\n1,-1000,3\r\n2,0,4\r\n",
               "time from Time (ms) in ms, input from Drive (mV) in mV, output from Position (nm) in nm", "V",
               "nm"},
        Format{"UnitsInWords",
               "Zeit in ms;Piezospannung in V;Istwert in \xC2\xB5m\n0;1,5;2,25\n1;-1;3\n2;0;4\n",
               "time from Zeit in ms in ms, input from Piezospannung in V in V, output from Istwert in "
               "\xC2\xB5m in um",
               "V", "um"},
        Format{"UnitsBehindASlash", "t/ms,Ansteuerung/V,Sensorspannung/V\n0,1.5,2.25\n1,-1,3\n2,0,4\n",
               "time from t/ms in ms, input from Ansteuerung/V in V, output from Sensorspannung/V in V", "V",
               "V"},
        Format{"GermanSpreadsheet",
               "Zeit [s];Spannung [V];Weg [\xC2\xB5m]\n0;1,5;2,25\n0,001;-1;3\n0,002;0;4\n",
               "time from Zeit [s] in s, input from Spannung [V] in V, output from Weg [\xC2\xB5m] in um",
               "V", "um"},
        Format{"InstrumentAndALineOfUnits",
               "Model: X-100, serial "
               "7\nDate\t2026-11-22\n\nTime\tCurrent\tDisp\ns\tA\tum\n0\t1.5\t2.25\n0.001\t-1\t3\n"
               "0.002\t0\t4\n",
               "time from Time in s, input from Current in A, output from Disp in um", "A", "um"},
        Format{"MoreColumnsInAnotherOrder",
               "temperature,position_um,drive_V,time_us\n20,2.25,1.5,0\n20,3,-1,1000\n20,4,0,2000\n",
               "time from time_us in us, input from drive_V in V, output from position_um in um", "V", "um"},
        Format{"Blanks",
               "# from numpy.savetxt\n# output_unit = \"mm\"\n t  u  y\n 0 1.5 2.25\n1e-3 -1 3\n2e-3  0\t4\n",
               "time from t, input from u, output from y", "", "mm"},
        Format{"ASeparatorAtTheEnd", "t;u;y;\n0;1,5;2,25;\n0,001;-1;3;\n0,002;0;4;\n",
               "time from t, input from u, output from y"}),
    [](const auto& test) { return test.param.name; });

TEST(LabCsvColumns, AreSelectedByTheUser) {
  const std::string text = "a,b,c,d\n9,0,1.5,2.25\n9,0.001,-1,3\n";
  EXPECT_EQ(load(text, {.columns = "b,c,d"}).dataset.output, (std::vector<double>{2.25, 3.0}));
  EXPECT_EQ(load(text, {.columns = "2, 3, a"}).dataset.output, (std::vector<double>{9.0, 9.0}));
  EXPECT_EQ(load("0,1.5,2.25\n0.001,-1,3\n", {.columns = "1,2,3"}).dataset.input,
            (std::vector<double>{1.5, -1.0}));
}

TEST(LabCsvColumns, HaveNoValueThatAFitCannotSquare) {
  for (const char* value : {"1e160", "-1e300", "1.1e12"})
    EXPECT_THROW(load(std::string("time_s,input,output\n0,1,2\n1,3,") + value + "\n", {}), Error) << value;
  EXPECT_EQ(load("time_s,input,output\n0,1,2\n1,3,1e12\n", {}).dataset.output.back(), 1e12);
}

TEST(LabCsvColumns, NeedNoTimeIfARateIsGiven) {
  const std::string text = "V,x\n1,2\n3,4\n5,6\n";
  EXPECT_EQ(load(text, {.rate_Hz = 500.0}).dataset.time_s, (std::vector<double>{0.0, 0.002, 0.004}));
  EXPECT_EQ(load(text, {.columns = "x,V", .rate_Hz = 500.0}).dataset.output,
            (std::vector<double>{1.0, 3.0, 5.0}));
  EXPECT_EQ(load("sample,V,x\n7,1,2\n8,3,4\n", {.rate_Hz = 500.0}).dataset.time_s,
            (std::vector<double>{7 * 0.002, 8 * 0.002}));
}

TEST(LabCsvColumns, UseTheRateAboveTheHeader) {
  for (const char* above :
       {"Messung 3\nAbtastrate: 5000 Hz\n", "# sample rate = 5 kHz\n", "\"Sampling Rate\";5000\n",
        "Abtastrate;5;kHz\n", "Abtastrate [Hz]: 5000\n", "Abtastrate: 5e3 Hz\n", "sample rate: 5 kS/s\n",
        "sample rate: 5000 1/s\n", "Sampling frequency: 5,0 kHz\n"}) {
    const DatasetFile numbered = load(above + std::string("Nr;V;x\n0;1;2\n1;3;4\n2;5;6\n"), {});
    ASSERT_EQ(numbered.dataset.size(), 3U) << above;
    EXPECT_NEAR(numbered.dataset.time_s[2], 0.0004, 1e-12) << above;
    EXPECT_NE(numbered.taken.find("5000 Hz from"), std::string::npos) << numbered.taken;
    EXPECT_NEAR(load(above + std::string("V;x\n1;2\n3;4\n"), {}).dataset.time_s[1], 0.0002, 1e-12) << above;
  }
  EXPECT_EQ(load("Abtastrate: 5000 Hz\nNr;V;x\n0;1;2\n1;3;4\n", {.rate_Hz = 500.0}).dataset.time_s[1], 0.002)
      << "--rate overrides it";
}

TEST(LabCsvColumns, IgnoreAnAmbiguousRate) {
  for (const char* above :
       {"Abtastrate: 5.000 Hz\n", "Sample rate: 5,000 Hz\n", "Abtastrate: 5000 Hz\nsample rate: 1000 Hz\n",
        "Abtastrate: 0 Hz\n", "Abtastrate: -5 Hz\n"})
    EXPECT_NE(refusal(above + std::string("Nr;V;x\n0;1;2\n1;3;4\n"), {}).find("or --rate with"),
              std::string::npos)
        << above;
}

TEST(LabCsvColumns, MayHaveRoundedTimes) {
  const DatasetFile file =
      load("Abtastrate: 3000 Hz\nt (s);V;x\n0;1;2\n0,0003;3;4\n0,0007;5;6\n0,001;7;8\n", {});
  EXPECT_EQ(file.dataset.time_s, (std::vector<double>{0.0, 0.0003, 0.0007, 0.001}));
  EXPECT_EQ(refusal("t (ms),V,x\n0,1,2\n0.22,3,4\n0.44,5,6\n", {.rate_Hz = 5000.0}),
            ": t (ms) contradicts the rate, expected 0.0002 s from row to row at --rate 5000")
      << "a tenth is no rounding";
}

TEST(LabCsvColumns, AreRefusedIfTimesContradictTheRate) {
  EXPECT_EQ(refusal("Abtastrate: 5000 Hz\nt (ms);V;x\n0;1;2\n1;3;4\n", {}),
            ":4: t (ms) increases by 0.001 s, expected 0.0002 s at \"Abtastrate: 5000 Hz\" (--rate overrides "
            "it), or whole numbers that count the samples; --columns 2,3 --rate HZ reads the file without "
            "its time column");
}

TEST(LabCsvColumns, MayContainTimesOrSampleNumbersBesideARate) {
  const std::vector<double> expected{0.0, 0.0002, 0.0004};
  for (const char* text : {"t,V,x\n0,1,2\n1,3,4\n2,5,6\n", "t,V,x\n0,1,2\n0.0002,3,4\n0.0004,5,6\n",
                           "t (ms),V,x\n0,1,2\n0.2,3,4\n0.4,5,6\n"}) {
    const std::vector<double> time_s = load(text, {.rate_Hz = 5000.0}).dataset.time_s;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(time_s[i], expected[i], 1e-12) << text;
  }
  EXPECT_EQ(refusal("t,V,x\n0,1,2\n0.001,3,4\n", {.rate_Hz = 5000.0}),
            ":3: t increases by 0.001 s, expected 0.0002 s at --rate 5000, or whole numbers that count "
            "the samples; --columns 2,3 reads the file without its time column");
  EXPECT_EQ(refusal("t (ms),V,x\n0,1,2\n1,3,4\n", {.rate_Hz = 5000.0}),
            ":3: t (ms) increases by 0.001 s, expected 0.0002 s at --rate 5000, or whole numbers that count "
            "the samples; --columns 2,3 reads the file without its time column");
}

TEST(LabCsvColumns, AreScaledFromVoltageToLength) {
  const DatasetFile loaded = load("t,drive (V),sensor (V)\n0,1,2\n1,3,-4\n", {.output_scale = 12.5});
  EXPECT_EQ(loaded.dataset.output, (std::vector<double>{25.0, -50.0}));
  EXPECT_EQ(loaded.dataset.output_unit, "um");
}

TEST(LabCsvRefusal, NamesAnAmbiguousTime) {
  EXPECT_EQ(refusal("Timestamp (ticks),V,x\n0,1,2\n1,3,4\n"),
            ":1:1: the unit of Timestamp (ticks) is not known, expected one of s, ms, us, ns, min, h");
  EXPECT_EQ(refusal("Zeit in Millisekunden;Spannung;Weg\n0;1;2\n1;3;4\n"),
            ":1:1: the unit of Zeit in Millisekunden is not known, expected one of s, ms, us, ns, min, h");
  EXPECT_EQ(refusal("Index,V,x\n0,1,2\n1,3,4\n"),
            ":1:1: Index is a sample number, expected a time, or --rate with the samples per second");
  EXPECT_EQ(load("Nr,V,x\n1,1,2\n11,3,4\n", {.rate_Hz = 1000.0}).dataset.time_s,
            (std::vector<double>{0.001, 0.011}));
}

TEST(LabCsvRefusal, NamesALengthThatIsScaled) {
  EXPECT_EQ(refusal("t,V,Weg [um]\n0,1,2\n1,3,4\n", {.output_scale = 2.0}),
            ":1:1: Weg [um] is a length in um: --output-scale is not allowed");
}

TEST(LabCsvRefusal, ListsThePresentAndMissingColumns) {
  EXPECT_EQ(
      refusal("t,V1 (V),V2 (V),x\n0,1,2,3\n1,2,3,4\n"),
      ":1:1: more than one column among t, V1 (V), V2 (V), x can be the input, expected columns named "
      "time_s, input and output, or --columns TIME,INPUT,OUTPUT with column names or numbers from 1 to 4");
  EXPECT_EQ(refusal("t,V\n0,1\n1,2\n"),
            ":1:1: two columns of numbers, expected time, input and output: --output-from FILE reads the "
            "output from another file, and --rate HZ reads a file without time");
  EXPECT_EQ(
      refusal("t,V,z\n0,1,2\n1,2,3\n"),
      ":1:1: no column among t, V, z can be the output, expected columns named time_s, input and output, or "
      "--columns TIME,INPUT,OUTPUT with column names or numbers from 1 to 3");
  EXPECT_EQ(
      refusal("0,1,2\n1,2,3\n"),
      ":1:1: no header row, expected column names, or --columns with the column numbers of time, input and "
      "output, 1 to 3");
  EXPECT_EQ(refusal("t,V,x\n0,1,2\n", {.columns = "t,V,z"}),
            ":1:1: no column z, expected one of t, V, x, or a number from 1 to 3");
  EXPECT_EQ(refusal("t,V,x\n0,1,2\n", {.columns = "t,V,4"}),
            ":1:1: no column 4, expected one of t, V, x, or a number from 1 to 3");
}

TEST(LabCsvRefusal, HasThePlaceOfABadRow) {
  EXPECT_EQ(refusal("Lab 3\nt;V;x\n0;1;2\n1;2\n"), ":4:1: the row has 2 fields, expected 3 as in the header");
  EXPECT_EQ(refusal("t;V;x\n0;1;2\n1;abc;3\n"), ":3:3: V is \"abc\", expected a finite number");
  EXPECT_EQ(refusal("t;V;x\n0;1;2\n1;;3\n"), ":3:3: V is empty, expected a number");
  EXPECT_EQ(
      refusal("t,V,x\n0,1,2\n0.5,1,2\n0.5,1,2\n"),
      ":4: t is 0.5 after 0.5, expected an increasing time: if the time is rounded, --columns 2,3 --rate HZ "
      "reads the file without its time column");
  EXPECT_EQ(refusal("t,V,t\n0,1,2\n1,1,2\n"),
            ":1:1: column t occurs twice, expected each name once, or --columns with numbers from 1 to 3");
}

TEST(LabCsvColumns, HaveTheUnitsOfTheSettingsAboveThem) {
  const DatasetFile file = load(
      "Horizontal Units,ms,,Horizontal Units,ms\nVertical Units,V,,Vertical Units,mV\n"
      "TIME,CH1,,TIME,CH2\n0,1,,0,2000\n1,2,,1,3000\n",
      {.columns = "1,2,5", .output_scale = 10.0});
  EXPECT_EQ(file.dataset.output, (std::vector<double>{20.0, 30.0}));
  EXPECT_EQ(file.dataset.time_s, (std::vector<double>{0.0, 0.001}));
}

TEST(LabCsvColumns, UseTheIntervalOfTheInstrument) {
  for (const char* head :
       {"Sample Interval,2e-4\nNr,V,x\n", "Delta_X,0.0002,0.0002\nNr,V,x\n",
        "# SAMPLE_TIME: 0.2 ms\nNr,V,x\n", "Sample Interval,CH1:0.0002 CH2:0.0002\nNr,V,x\n"})
    EXPECT_NEAR(load(head + std::string("0,1,2\n1,3,4\n")).dataset.time_s[1], 0.0002, 1e-12) << head;
  EXPECT_NEAR(load("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-3.0,2e-4\n0,1,2,,\n1,3,4,,\n",
                   {.columns = "1,2,3"})
                  .dataset.time_s[1],
              0.0002, 1e-12);
}

TEST(LabCsvSigns, AreDecidedOnceForTheWholeFile) {
  EXPECT_EQ(
      refusal("t;V;x\n0,5;1;2.000\n0,6;1;31.250\n"),
      ": 2.000 (2:7) and 0,5 (2:1) cannot be read with the same decimal sign, expected one decimal sign and "
      "no thousands separators");
  EXPECT_EQ(
      refusal("t\tV\tx\n0.5\t1,5\t2\n"),
      ": 0.5 (2:1) and 1,5 (2:5) cannot be read with the same decimal sign, expected one decimal sign and no "
      "thousands separators");
  EXPECT_EQ(load("t;V;x\n0,5;1;1.002.000,5\n0,6;1;31.250\n").dataset.output,
            (std::vector<double>{1002000.5, 31250.0}));
  EXPECT_EQ(load("t;V;x\n0,5;1;2.000\n0,6;1;31\n").dataset.output, (std::vector<double>{2000.0, 31.0}));
  EXPECT_EQ(load("t_s;V;x\n1;1,500;2\n2;1,250;3\n").notes,
            (std::vector<std::string>{
                "1,500 (2:3): the comma is taken as the decimal sign, though it can separate thousands"}));
  EXPECT_EQ(
      refusal("t;V;x\n1;1.500;2\n2;500;3\n"),
      ": 1.500 (2:3): its point can be the decimal sign or separate thousands, expected one decimal sign and "
      "no thousands separators");
  EXPECT_EQ(
      refusal("t,V,x\n0,0100,1,5,2,25\n0,0200,1,5,2,25\n", {.columns = "2,4,6"}),
      ":2:3: commas are decimal signs and also separators, expected semicolons between the fields or quotes "
      "around the numbers");
}

TEST(LabCsvHead, IsNotReadAsRows) {
  const std::string head =
      "Samples\t600\t600\nY_Unit_Label\tVolts\tmicrons\nX_Dimension\tTime\tTime\nX0\t0.0\t0.0\n"
      "Delta_X\t0.010000\t0.010000\n***End_of_Header***\t\t\nX_Value\tVoltage\tPosition\tComment\n";
  std::string rows, timed;
  for (int n = 0; n < 100; ++n) {
    const std::string row = "\t" + std::to_string(n) + ".5\t" + std::to_string(n + 1) + ".25\n";
    rows += row;
    timed += std::to_string(0.01 * n) + row;
  }
  for (const std::string& text : {head + rows, head + timed}) {
    const DatasetFile file = load(text, {.columns = "2,3", .rate_Hz = 100.0});
    EXPECT_EQ(file.dataset.size(), 100U);
    EXPECT_EQ(file.dataset.output.front(), 1.25);
    EXPECT_EQ(load(text).dataset.time_s.back(), 0.99);
    EXPECT_EQ(load(text).dataset.output_unit, "um");
  }
  std::string paused = "t,V,x\n0,1,2\n1,2,3\npause,pause,pause\n";
  for (int n = 2; n < 100; ++n) paused += std::to_string(n) + ",1,2\n";
  EXPECT_EQ(refusal(paused), ":4:1: t is \"pause\", expected a finite number") << "these rows are no head";
}

TEST(LabCsvColumns, HaveTheUnitsAboveTheirNames) {
  const DatasetFile file = load("ms,V,nm\nTime,Drive,Position\n0,1,2\n1,2,3\n");
  EXPECT_EQ(file.dataset.time_s, (std::vector<double>{0.0, 0.001}));
  EXPECT_EQ(file.dataset.output_unit, "nm");
}

TEST(LabCsvColumns, HaveUnitsEvenWithoutATimeColumn) {
  const DatasetFile file = load(
      "\"TraceName\",\"CH1\",\"CH2\"\n\"VUnit\",\"V\",\"mV\"\n\"SampleRate\",100,100\n"
      "\"BlockSize\",600\n1.5,2000\n2.5,3000\n3.5,4000\n",
      {.columns = "1,2", .output_scale = 10.0});
  EXPECT_EQ(file.dataset.output, (std::vector<double>{20.0, 30.0, 40.0}));
  EXPECT_EQ(file.dataset.time_s, (std::vector<double>{0.0, 0.01, 0.02}));
}

TEST(LabCsvColumns, MayBeginWithAnIndexWithoutAName) {
  EXPECT_EQ(load(",t,V,x\n0,0.5,1,2\n1,0.6,2,3\n").dataset.time_s, (std::vector<double>{0.5, 0.6}));
}

TEST(LabCsvColumns, MayHaveAUnitAfterASpace) {
  EXPECT_EQ(load("Zeit ms;Kanal A;Weg nm\n0;1,5;2\n10;2,5;3\n", {.columns = "1,2,3"}).dataset.time_s,
            (std::vector<double>{0.0, 0.01}));
}

TEST(LabCsvSigns, HaveApostrophesAndNarrowBlanksBetweenThousands) {
  EXPECT_EQ(load("t;V;x\n0.5;1;1'002.5\n0.6;1;31'250\n").dataset.output,
            (std::vector<double>{1002.5, 31250.0}));
  EXPECT_EQ(load("t;V;x\n0,5;1;1\xE2\x80\xAF"
                 "002,5\n0,6;1;\xE2\x88\x92"
                 "7,5\n")
                .dataset.output,
            (std::vector<double>{1002.5, -7.5}));
}

TEST(LabCsvRefusal, NamesAnOutputThatIsATime) {
  EXPECT_EQ(refusal("Time,Drive,Time,Sensor\ns,V,s,V\n0,1,0,2\n1,2,1,3\n", {.columns = "1,2,3"}),
            ":1:1: Time is a time in s, expected the output: select the column of the output with --columns");
}

TEST(LabCsvRefusal, NamesAnInputThatIsAPosition) {
  EXPECT_EQ(
      refusal("Time (s),Setpoint (um),Position (um)\n0,1,2\n1,2,3\n"),
      ":1:1: Setpoint (um) is a position in um, expected the drive of the actuator in V or A as the input: "
      "select the column of the drive with --columns");
}

TEST(LabCsvRefusal, NamesTheKindOfABinaryFile) {
  EXPECT_EQ(refusal("PK\x03\x04 zip"),
            ":1:1: this is an Excel file or another archive, expected text: save the file as CSV");
}

TEST(LabCsvRows, AreNotCheckedOutsideTheInterval) {
  const std::string text = "t,V,x\noff,off,off\n0,nan,\n1,2,3\n2,3,4\n3,,5\nshut down\n0,1,2\n";
  EXPECT_EQ(load(text, {.from_s = 1.0, .to_s = 2.0}).dataset.output, (std::vector<double>{3.0, 4.0}));
  EXPECT_EQ(load(text, {.from_s = 1.0, .to_s = 2.5}).dataset.output, (std::vector<double>{3.0, 4.0}));
}

}  // namespace
}  // namespace hystcan::config::lab_csv_test
