// From the cycles of an axis in open loop to the rows of a record: what was applied and what came of it.
//
// The command that answers SYNC(n) takes effect at SYNC(n+1), and the position is sampled at the SYNC (see
// docs/protocol.md, "One cycle"). A row is one SYNC:
//
//   time_s   of SYNC(n), from 0 at the first row
//   input    drive of the command that answered SYNC(n-1): in force from SYNC(n) on, until SYNC(n+1)
//   output   position at SYNC(n), sampled as that drive takes over: it answers to the rows before
//
// One row for every cycle while the excitation runs, the ramps in and out not among them. Left out are cycles
// whose sample was missing, and such as follow a cycle whose record was lost, since their input is not known.
#pragma once

#include <cstdint>
#include <optional>

#include "controller/cycle_record.h"

namespace hystcan::controller {

struct ExcitationRow {
  double time_s = 0.0;
  double input = 0.0;   ///< drive units
  double output = 0.0;  ///< um
};

class ExcitationDataset {
 public:
  /// Every cycle's record, in order, from before tracking began.
  std::optional<ExcitationRow> add(const CycleRecord& record);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t left_out() const { return left_out_; }

 private:
  std::optional<CycleRecord> before_;
  double first_s_ = 0.0;
  std::uint64_t rows_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace hystcan::controller
