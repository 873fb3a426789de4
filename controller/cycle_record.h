// The record of one cycle of one axis, from which log, CSV, black box and statistics are made. This file also
// defines the columns of such a record.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "can/scheduler.h"
#include "controller/control/axis.h"
#include "controller/remote_node.h"

namespace hystcan::controller {

struct CycleCounters {
  std::uint64_t cycles = 0;
  std::uint64_t missed_cycles = 0;    ///< SYNCs omitted because this computer was too slow
  std::uint64_t missing_samples = 0;  ///< cycles in which an axis in use had no sample in time
  std::uint64_t late_samples = 0;     ///< samples that arrived after their cycle
  /// Command frames that were replaced by a newer one before they were sent.
  std::uint64_t replaced_commands = 0;
};

/// Times within a cycle, measured from its SYNC.
struct CyclePhases {
  can::Duration period{};        ///< time from the last SYNC to this one
  can::Duration lateness{};      ///< delay of the SYNC after its deadline
  can::Duration sample_heard{};  ///< time of the sample's arrival after the SYNC; zero: no sample
  can::Duration command_sent{};
  can::Duration execution{};  ///< execution time of the axis's step

  /// Returns the time from the received sample to the sent command; zero if no sample arrived.
  can::Duration turnaround() const {
    return sample_heard == can::Duration::zero() ? sample_heard : command_sent - sample_heard;
  }
};

struct CycleRecord {
  std::uint64_t cycle = 0;
  double time_s = 0.0;  ///< time of the SYNC since the controller's start
  std::size_t axis = 0;
  AxisReport report;
  double amplifier_output = 0.0;  ///< output in the last received status, drive units
  /// Age of the last received status at the time `time_s`; NaN if no status has arrived.
  double amplifier_output_age_s = std::numeric_limits<double>::quiet_NaN();
  CyclePhases phases{};
  CycleCounters counters{};  ///< counters of the controller at the time of the record
  std::optional<NodeEvent> event{};
};
static_assert(std::is_trivially_copyable_v<CycleRecord>,
              "a CycleRecord must be trivially copyable, because it crosses threads");

// The columns of a cycle: one table for every CSV, HDF5 file and stream that stores cycles of an axis.
//
// A column is a number. If its values have words (a state, a cause), the number is the index of the word, and
// CSV contains the word instead. A missing value is NaN; in CSV its field is empty.

struct CycleColumn {
  enum class Kind : std::uint8_t {
    whole,   ///< an integer, without decimals
    number,  ///< a number with `decimals` digits after the point
    axis,    ///< the index of the axis; in CSV its name
    state,   ///< the number of an AxisState; in CSV its name
    cause,   ///< the number of a Cause; in CSV its name
    limits   ///< the bits of `limit`; in CSV their names, for example slew+model
  };
  std::string_view name;
  std::string_view unit;  ///< unit; "drive" means the drive unit of the axis; empty: no unit
  std::string_view meaning;
  Kind kind = Kind::number;
  int decimals = 0;
  double (*value)(const CycleRecord& record) = nullptr;
};

/// Returns the columns in the order of the CSV.
std::span<const CycleColumn> cycle_columns();
/// Returns the column with this name, or null.
const CycleColumn* find_cycle_column(std::string_view name);
/// Returns the words that the values of a column stand for. A value is the index of its word; a column of
/// kind `limits` has one word for each bit. Returns nothing if the column has no words.
std::vector<std::string> words_of(const CycleColumn& column);

/// The comment line above the header of a CSV file.
inline constexpr std::string_view cycle_units =
    "# drive and amplifier_output in the axis's drive unit; error = reference - position\n";
/// Appends the names of the columns to `text`, separated by commas, without an end of line.
void append_cycle_header(std::string& text);
/// Appends the values of the record to `text`, separated by commas, without an end of line.
void append_cycle_row(std::string& text, const CycleRecord& record, std::span<const std::string> axis_names);

/// Appends the value with this number of decimals to `text`. Appends nothing if the value is NaN.
void append_fixed(std::string& text, double value, int decimals);

}  // namespace hystcan::controller
