// A record in a random format (head, separator, decimal sign, units, clock, line ends, damage) is read to the
// digit, or refused in one line. It is never read wrongly.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "base/error.h"
#include "config/files/dataset_file.h"
#include "tests/support/long_run.h"
#include "tests/support/scratch.h"

namespace hystcan::config::dressed_record_test {
namespace {

/// The record in whole steps: 10 ms, 10 mV, 1 nm. A drive of 0 to 60 V, with loops.
struct Row {
  int t_10ms, drive_10mV, position_nm;
};

class Dress {
  static constexpr int day_10ms = 8'640'000;

 public:
  explicit Dress(unsigned seed) : random_(seed) {
    const int offset_nm = pick<int>({0, 0, 1000, -2500, 100'000});
    const int rows = range(12, 40);
    first_10ms_ = pick<int>({0, 0, 1, -300, 100});
    for (int n = 0; n < rows; ++n) {
      const int drive = 100 * (n % 14 < 7 ? n % 14 : 14 - n % 14) * 10 + range(0, 99);
      rows_.push_back({first_10ms_ + n, drive, offset_nm + 4 * drive + range(0, 999)});
    }
    choose();
    write();
    damage();
  }

  const std::string& text() const { return text_; }
  const std::vector<Row>& rows() const { return rows_; }
  const DatasetLayout& layout() const { return layout_; }

 private:
  int range(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
  bool chance(int percent) { return range(1, 100) <= percent; }
  template <class T>
  T pick(std::initializer_list<T> of) {
    return *(of.begin() + range(0, static_cast<int>(of.size()) - 1));
  }

  struct Unit {
    const char* word;
    int digits;  ///< number of digits after the decimal sign in whole steps; negative: zeros
  };

  void choose() {
    separator_ = pick<std::string>({",", ";", "\t", "  ", ", ", "; "});
    quotes_ = chance(15) && separator_.find(' ') == std::string::npos;
    has_comma_ = (separator_[0] != ',' || quotes_) && chance(50);
    thousands_ = chance(10) && (separator_[0] != ',' || quotes_);
    line_end_ = pick<std::string>({"\n", "\r\n"});
    time_ = pick<Unit>(
        {{"s", 2}, {"sec", 2}, {"Seconds", 2}, {"ms", -1}, {"msec", -1}, {"us", -4}, {"\xC2\xB5s", -4}});
    drive_ = pick<Unit>({{"V", 2}, {"Volt", 2}, {"volts", 2}, {"mV", -1}});
    position_ =
        pick<Unit>({{"um", 3}, {"\xC2\xB5m", 3}, {"\xCE\xBCm", 3}, {"microns", 3}, {"nm", 0}, {"mm", 6}});
    form_ = range(0, 4);
    if (chance(15)) wear_clock();
    extra_column_ = chance(20);
    by_number_ = form_ >= 3 || chance(40);
  }

  /// Times of day, counted from the first row; some pass midnight.
  void wear_clock() {
    clock_10ms_ = pick<int>({4'320'000, day_10ms - 10});
    for (Row& row : rows_) row.t_10ms -= first_10ms_;
  }

  std::string time_of(int t_10ms) const {
    if (!clock_10ms_) return digits_of(t_10ms, time_.digits);
    const int at = (*clock_10ms_ + t_10ms) % day_10ms;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%02d:%02d:%02d%c%02d", at / 360'000, at / 6000 % 60,
                  at / 100 % 60, has_comma_ ? ',' : '.', at % 100);
    return text.data();
  }

  std::string digits_of(int value, int digits) const {
    std::string text = std::to_string(std::abs(value));
    if (digits < 0) text = value == 0 ? "0" : text.append(static_cast<std::size_t>(-digits), '0');
    std::string fraction;
    if (digits > 0) {
      if (text.size() <= static_cast<std::size_t>(digits))
        text.insert(0, static_cast<std::size_t>(digits) + 1 - text.size(), '0');
      fraction = (has_comma_ ? "," : ".") + text.substr(text.size() - static_cast<std::size_t>(digits));
      text.resize(text.size() - static_cast<std::size_t>(digits));
    }
    if (thousands_)
      for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, has_comma_ ? "." : ",");
    return (value < 0 ? "-" : "") + text + fraction;
  }

  std::string field(const std::string& text) const { return quotes_ ? "\"" + text + "\"" : text; }

  void line(const std::vector<std::string>& fields) {
    for (std::size_t i = 0; i < fields.size(); ++i) text_ += (i == 0 ? "" : separator_) + field(fields[i]);
    text_ += line_end_;
  }

  void write() {
    if (chance(20)) text_ += "\xEF\xBB\xBF";
    if (chance(40)) {
      for (const char* setting :
           {"Model: X-100, serial 7", "# comment", "Date 2026-11-22", "Record Length,600", ""})
        if (chance(50)) text_ += setting + line_end_;
    }
    const std::array<std::string, 3> units{time_.word, drive_.word, position_.word};
    const std::vector<std::string> names{"Time", "Drive", "Position"};
    std::vector<std::string> title, below;
    for (std::size_t i = 0; i < 3; ++i) {
      title.push_back(i == 0 && clock_10ms_      ? names[i]
                      : form_ == 0 || form_ == 3 ? names[i] + " (" + units[i] + ")"
                      : form_ == 1               ? names[i] + "[" + units[i] + "]"
                                                 : names[i]);
      below.push_back(i == 0 && clock_10ms_ ? "hh:mm:ss" : form_ == 2 ? units[i] : "(" + units[i] + ")");
    }
    if (extra_column_) {
      title.emplace_back("Temperature");
      below.emplace_back("deg");
    }
    if (form_ == 3 && separator_ != "  ") text_ += "# ";
    line(title);
    if (form_ == 2 || form_ == 4) line(below);
    if (by_number_) layout_.columns = "1,2,3";
    for (const Row& row : rows_) {
      rows_at_.push_back(text_.size());
      std::vector<std::string> fields{time_of(row.t_10ms), digits_of(row.drive_10mV, drive_.digits),
                                      digits_of(row.position_nm, position_.digits)};
      if (extra_column_) fields.push_back(digits_of(2150 + row.t_10ms % 7, 2));
      line(fields);
    }
  }

  void damage() {
    const std::size_t at =
        rows_at_[static_cast<std::size_t>(range(1, static_cast<int>(rows_at_.size()) - 1))];
    switch (range(0, 9)) {
      case 0:
        text_.resize(
            static_cast<std::size_t>(range(static_cast<int>(rows_at_[3]), static_cast<int>(text_.size()))));
        break;
      case 1:
        text_ += std::string(static_cast<std::size_t>(range(1, 600)), '\0');
        break;
      case 2:
        text_ += "End of measurement" + line_end_;
        break;
      case 3:
        text_.insert(at, "pause" + line_end_);
        break;
      case 4:
        text_.insert(at, "nan" + separator_ + "nan" + separator_ + "nan" + line_end_);
        break;
      case 5:
        text_.erase(at, text_.find(separator_, at) + separator_.size() - at);
        break;
      case 6:
        text_ += text_.substr(rows_at_[0], rows_at_[2] - rows_at_[0]);
        break;
      default:
        break;
    }
  }

  std::mt19937 random_;
  std::vector<Row> rows_;
  int first_10ms_ = 0;
  std::optional<int> clock_10ms_;  ///< time of the first row; none: the time has a unit
  std::string separator_, line_end_, text_;
  bool quotes_ = false, has_comma_ = false, thousands_ = false, extra_column_ = false, by_number_ = false;
  Unit time_{}, drive_{}, position_{};
  int form_ = 0;
  std::vector<std::size_t> rows_at_;
  DatasetLayout layout_;
};

double um_of(const std::string& unit) {
  return unit == "nm" ? 1e-3 : unit == "mm" ? 1e3 : unit == "um" ? 1.0 : 0.0;
}

/// Every row that was read is a row of the record, in the order of the record.
bool is_part_of(const identification::Dataset& dataset, const std::vector<Row>& rows) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < dataset.size(); ++i) {
    const auto is_row = [&](const Row& row) {
      return std::abs(dataset.time_s[i] - 0.01 * row.t_10ms) < 1e-9 &&
             std::abs(dataset.input[i] - 0.01 * row.drive_10mV) < 1e-9 &&
             std::abs(dataset.output[i] * um_of(dataset.output_unit) - 1e-3 * row.position_nm) < 1e-9;
    };
    while (at < rows.size() && !is_row(rows[at])) ++at;
    if (at++ == rows.size()) return false;
  }
  return dataset.input_unit == "V";
}

TEST(DressedRecord, IsReadToTheDigitOrRefused) {
  const unsigned cases = support::long_run() ? 10'000 : 500;
  const auto file = support::scratch_file("dressed.csv");
  unsigned accepted = 0;
  for (unsigned seed = 0; seed < cases; ++seed) {
    const Dress dress(seed);
    std::ofstream(file, std::ios::binary) << dress.text();
    try {
      const identification::Dataset dataset = load_dataset(file, dress.layout()).dataset;
      ++accepted;
      ASSERT_TRUE(is_part_of(dataset, dress.rows())) << "case " << seed << ":\n" << dress.text();
    } catch (const Error& error) {
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      ASSERT_TRUE(std::string(error.what()).starts_with(file.string() + ":")) << error.what();
      if (std::getenv("HYSTCAN_SHOW") != nullptr) std::printf("case %u %s\n", seed, error.what());
    }
  }
  EXPECT_GT(accepted, cases / 2);
}

}  // namespace
}  // namespace hystcan::config::dressed_record_test
