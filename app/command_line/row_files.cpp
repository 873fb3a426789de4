#include "app/command_line/row_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/python_module.h"
#include "base/text.h"
#include "config/files/csv.h"
#include "storage/hdf5.h"

namespace hystcan::app {
namespace {

class CsvRows final : public RowInput {
 public:
  CsvRows(const std::filesystem::path& file, const std::string& column)
      : file_(file),
        reader_(file, {column}),
        timed_(reader_.add_if_present("time_s")),
        unit_(reader_.comment(column + "_unit")) {
    std::error_code unknown;
    const auto size = std::filesystem::file_size(file, unknown);
    size_ = unknown ? 0 : size;
  }

  bool next(SampleBlock& block) override {
    block.time_s.clear();
    block.given.clear();
    while (block.given.size() < SampleBlock::most && reader_.next(row_)) {
      const double time_s = timed_ ? row_[1] : static_cast<double>(rows_);
      if (time_s < previous_s_)
        throw Error({file_, reader_.line_number()}, fmt::format("time_s is {} after {}", time_s, previous_s_),
                    expect("an increasing time"));
      previous_s_ = time_s;
      ++rows_;
      block.time_s.push_back(time_s);
      block.given.push_back(row_[0]);
    }
    return !block.given.empty();
  }
  std::string unit() const override { return unit_; }
  bool timed() const override { return timed_; }
  std::vector<std::string> notes() const override { return reader_.notes(); }
  std::uint64_t done() const override { return reader_.bytes_read(); }
  std::uint64_t size() const override { return size_; }

 private:
  std::filesystem::path file_;
  config::CsvReader reader_;
  bool timed_;
  std::string unit_;
  std::uint64_t size_ = 0;
  std::uint64_t rows_ = 0;
  double previous_s_ = -std::numeric_limits<double>::infinity();
  std::vector<double> row_;
};

/// Reads rows from an HDF5 file. The file is opened by a Python process with h5py (python/hystcan/hdf5.py).
class Hdf5Rows final : public RowInput {
 public:
  Hdf5Rows(const std::filesystem::path& file, std::string column)
      : file_(file),
        column_(std::move(column)),
        python_("hdf5", {"read", file.string(), column_, fmt::format("{}", SampleBlock::most)},
                storage::hdf5_package) {
    std::vector<double> sizes(3);
    read(sizes);
    rows_ = static_cast<std::uint64_t>(sizes[0]);
    timed_ = sizes[1] != 0.0;
    unit_.resize(static_cast<std::size_t>(sizes[2]));
    if (!python_.read(unit_)) fail();
  }

  bool next(SampleBlock& block) override {
    const std::size_t count = std::min<std::uint64_t>(SampleBlock::most, rows_ - read_);
    block.given.resize(count);
    block.time_s.resize(count);
    if (count == 0) return false;
    read(block.given);
    if (timed_) read(block.time_s);
    for (std::size_t i = 0; i < count; ++i) {
      if (!timed_) block.time_s[i] = static_cast<double>(read_ + i);
      require(std::isfinite(block.given[i]), column_, i, block.given[i], "a finite number");
      require(block.time_s[i] >= previous_s_, "time_s", i, block.time_s[i], "an increasing time");
      previous_s_ = block.time_s[i];
    }
    read_ += count;
    return true;
  }
  std::string unit() const override { return unit_; }
  bool timed() const override { return timed_; }
  std::uint64_t done() const override { return read_; }
  std::uint64_t size() const override { return rows_; }

 private:
  void read(std::vector<double>& values) {
    if (!python_.read({reinterpret_cast<char*>(values.data()), values.size() * sizeof(double)})) fail();
  }
  [[noreturn]] void fail() {
    throw Error(file_, python_.finish().value_or("ends before the last row, expected a complete file"));
  }
  void require(bool is_right, const std::string& column, std::size_t i, double value,
               const char* expected) const {
    if (!is_right)
      throw Error(file_, fmt::format("{}[{}] is {}", column, read_ + i, value), {.expected = expected});
  }

  std::filesystem::path file_;
  std::string column_;
  PythonModule python_;
  bool timed_ = false;
  std::string unit_;
  std::uint64_t rows_ = 0;
  std::uint64_t read_ = 0;
  double previous_s_ = -std::numeric_limits<double>::infinity();
};

class CsvRowOutput final : public RowOutput {
 public:
  explicit CsvRowOutput(const std::filesystem::path& file) : file_(file) {
    file_.write("time_s,input,output\n");
  }

  void write(const SampleBlock& block) override {
    text_.clear();
    for (std::size_t i = 0; i < block.input.size(); ++i) {
      append_shortest(text_, block.time_s[i]);
      text_ += ',';
      append_shortest(text_, block.input[i]);
      text_ += ',';
      append_shortest(text_, block.output[i]);
      text_ += '\n';
    }
    file_.write(text_);
  }
  void commit() override { file_.commit(); }

 private:
  OutputFile file_;
  std::string text_;
};

class Hdf5RowOutput final : public RowOutput {
 public:
  Hdf5RowOutput(const std::filesystem::path& file, const std::string& input_unit,
                const std::string& output_unit)
      : file_(file), writer_(file_.written()), columns_(3) {
    table_ = writer_.add_table(
        "/", {{"time_s", "s", {}}, {"input", input_unit, {}}, {"output", output_unit, {}}}, false);
  }

  void write(const SampleBlock& block) override {
    const std::array from{&block.time_s, &block.input, &block.output};
    for (std::size_t i = 0; i < columns_.size(); ++i)
      columns_[i].insert(columns_[i].end(), from.at(i)->begin(), from.at(i)->end());
    if (columns_.front().size() >= storage::Hdf5Writer::chunk_rows) append();
  }
  void commit() override {
    append();
    writer_.close();
    file_.commit();
  }

 private:
  void append() {
    writer_.append(table_, columns_);
    for (std::vector<double>& column : columns_) column.clear();
  }

  OutputFile file_;
  storage::Hdf5Writer writer_;
  std::size_t table_;
  std::vector<std::vector<double>> columns_;
};

/// Returns true if the file begins with the signature of HDF5. (A file with an HDF5 user block begins
/// differently and is not recognised.)
bool is_hdf5(const std::filesystem::path& file) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::array<char, signature.size()> first{};
  std::ifstream(file, std::ios::binary).read(first.data(), first.size());
  return std::string_view(first.data(), first.size()) == signature;
}

}  // namespace

bool has_hdf5_name(const std::filesystem::path& file) {
  const auto ending = file.extension();
  return ending == ".h5" || ending == ".hdf5";
}

std::unique_ptr<RowInput> open_rows(const std::filesystem::path& file, const std::string& column) {
  if (is_hdf5(file)) return std::make_unique<Hdf5Rows>(file, column);
  return std::make_unique<CsvRows>(file, column);
}

std::unique_ptr<RowOutput> make_rows(const std::filesystem::path& file, const std::string& input_unit,
                                     const std::string& output_unit) {
  if (has_hdf5_name(file)) return std::make_unique<Hdf5RowOutput>(file, input_unit, output_unit);
  return std::make_unique<CsvRowOutput>(file);
}

}  // namespace hystcan::app
