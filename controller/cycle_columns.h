// The columns of a cycle: one table for every CSV, HDF5 file and stream in which cycles of an axis are kept.
//
// A column is a number. One that has words (a state, a cause) is the number of its word; in CSV the word stands in its
// place. A value that a cycle does not have is NaN; in CSV the field is empty.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "controller/cycle_record.h"

namespace hystcan::controller {

struct CycleColumn {
  enum class Kind : std::uint8_t {
    whole,   ///< an integer
    number,  ///< fixed point, with `decimals`
    axis,    ///< the index of the axis; in CSV its name
    state,   ///< an AxisState
    cause,   ///< a Cause
    limits   ///< the bits of `limit`; in CSV their names: slew+model
  };
  std::string_view name;
  std::string_view unit;  ///< "drive": the axis's drive unit; empty: none
  std::string_view meaning;
  Kind kind = Kind::number;
  int decimals = 0;
  double (*value)(const CycleRecord& record) = nullptr;
};

/// In the order of the CSV.
std::span<const CycleColumn> cycle_columns();
/// Null if there is none of that name.
const CycleColumn* find_cycle_column(std::string_view name);
/// The words of a column by their number; those of `limits` by their bit. Empty if it has none.
std::vector<std::string> words_of(const CycleColumn& column);

/// A comment above the header.
inline constexpr std::string_view cycle_units =
    "# drive and amplifier_output in the axis's drive unit; error = reference - position\n";
/// Appends the names of the columns, with commas, without an end of line.
void append_cycle_header(std::string& text);
/// Appends the row, with commas, without an end of line.
void append_cycle_row(std::string& text, const CycleRecord& record, std::span<const std::string> axis_names);

/// Appends the value with that many decimals; nothing if it is NaN.
void append_fixed(std::string& text, double value, int decimals);

}  // namespace hystcan::controller
