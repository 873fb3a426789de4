// All that a controller's cycle records feed for those who command and watch it: the newest of each axis, the stream, and
// the recording of runs.
#pragma once

#include <algorithm>

#include "app/live/cycle_samples.h"
#include "app/live/sample_board.h"
#include "app/live/status_board.h"
#include "config/schema/config.h"
#include "runs/recorder.h"
#include "storage/hdf5.h"

namespace hystcan::app {

struct CycleOutlets {
  CycleOutlets(const config::Config& config, runs::RunInfo info, const can::BusHealthLog::Sink& sink)
      : board(config.axes.size()),
        samples(streamed_columns.size(), samples_of_a_second(config)),
        converter("/proc/self/exe", sink),
        recorder(config, std::move(info), sink, conversion(config.record)) {}

  void put(const controller::CycleRecord& record) {
    board.put(record);
    if (samples.is_listening()) samples.put(sample_of(record));
    recorder.add(record);
  }

  StatusBoard board;
  SampleBoard samples;
  runs::PartConverter converter;
  runs::Recorder recorder;

 private:
  runs::RunWriter::OnPart conversion(const config::RecordConfig& record) {
    if (!record.hdf5 || !storage::has_hdf5()) return {};
    return [this](const std::filesystem::path& part) { converter.convert(part); };
  }

  /// More never waits: a batch is taken every 20 ms.
  static std::size_t samples_of_a_second(const config::Config& config) {
    return config.axes.size() * static_cast<std::size_t>(std::max(config.controller.rate_Hz, 1.0));
  }
};

}  // namespace hystcan::app
