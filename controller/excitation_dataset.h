// Converts the cycle records of an axis in open loop to the rows of a dataset: applied drive and measured
// position.
//
// The command that answers SYNC(n) takes effect at SYNC(n+1), and the position is sampled at the SYNC (see
// docs/protocol/cycle.md, "One cycle"). A row is one SYNC:
//
//   time_s   time of SYNC(n), 0 at the first row
//   input    drive of the command that answered SYNC(n-1), in effect from SYNC(n) until SYNC(n+1)
//   output   position at SYNC(n), sampled when that drive takes effect: the response to earlier rows
//
// Every cycle of the excitation has a row, except the cycles of its first `lead_s` seconds. The ramps before
// and after the excitation have no rows. A cycle is omitted if its sample is missing, or if the record of the
// cycle before is lost, because the input of the row is then unknown.
#pragma once

#include <cstdint>
#include <optional>

#include "controller/cycle_record.h"

namespace hystcan::controller {

struct ExcitationRow {
  double time_s = 0.0;
  double input = 0.0;   ///< applied drive, drive units
  double output = 0.0;  ///< measured position, um
};

class ExcitationDataset {
 public:
  explicit ExcitationDataset(double lead_s = 0.0) : lead_s_(lead_s) {}

  /// Returns the row of this cycle; `nullopt` if the cycle has no row. Must be called with the records of all
  /// cycles in order, beginning before the axis tracks.
  std::optional<ExcitationRow> add(const CycleRecord& record);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  std::optional<CycleRecord> before_;
  double lead_s_;
  std::optional<double> start_s_;  ///< start time of the excitation
  double first_s_ = 0.0;
  std::uint64_t rows_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace hystcan::controller
