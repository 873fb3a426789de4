#include "controller/excitation_dataset.h"

#include <utility>

namespace hystcan::controller {

std::optional<ExcitationRow> ExcitationDataset::add(const CycleRecord& record) {
  const std::optional<CycleRecord> before = std::exchange(before_, record);
  const AxisReport& report = record.report;
  if (report.state != AxisState::tracking || report.point.finished) return std::nullopt;
  if (!start_s_) start_s_ = record.time_s;
  if (record.time_s - *start_s_ < lead_s_) return std::nullopt;
  if (report.sample_missing || !before || before->cycle + 1 != record.cycle) {
    ++left_out_;
    return std::nullopt;
  }
  if (rows_++ == 0) first_s_ = record.time_s;
  return ExcitationRow{record.time_s - first_s_, before->report.drive, report.position_um};
}

}  // namespace hystcan::controller
