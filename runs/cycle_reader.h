// Reads a CSV of cycles (controller/cycle_record.h) row by row in constant memory. Columns are found by their names: a
// file of an older version may lack some, and one of a newer version may have more.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "controller/cycle_record.h"

namespace hystcan::runs {

class CycleReader {
 public:
  static constexpr std::size_t longest_line = 65'536;  ///< bytes

  /// Throws Error if the file cannot be read or is no CSV of cycles.
  explicit CycleReader(std::filesystem::path file);

  /// In the order of the file.
  const std::vector<std::string>& header() const { return header_; }
  /// Asks for one more column, by its name. False: the file does not have it. Throws Error at a name that no
  /// column of cycles has.
  bool add(std::string_view column);

  /// The columns asked for, and the name of the row's axis. False at the end of the file, and at a last line without its
  /// end, which a killed program leaves. Throws Error at a line that is no row: FILE:LINE: what, expected what.
  bool next(std::vector<double>& row, std::string_view& axis);

 private:
  struct Wanted {
    const controller::CycleColumn* column;
    std::size_t field;
    std::vector<std::string> words;
  };
  bool next_line();
  void split();
  std::optional<std::size_t> field_of(std::string_view column) const;
  double value(const Wanted& wanted) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::filesystem::path file_;
  std::ifstream stream_;
  std::vector<char> block_;
  std::size_t begin_ = 0, end_ = 0;  ///< what of the block is not read yet
  std::size_t line_number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> fields_;
  std::vector<std::string> header_;
  std::vector<Wanted> wanted_;
  std::size_t axis_field_ = 0;
};

}  // namespace hystcan::runs
