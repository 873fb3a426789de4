// Makes HDF5 of the finished CSVs of a run, each in a process of its own: a controller neither waits for it nor holds its
// memory. The process has the low priority of the thread that starts it, and goes on if the controller ends.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "can/bus_health_log.h"

namespace hystcan::runs {

/// The name of the HDF5 file beside a CSV: cycles_0001.h5.
std::filesystem::path hdf5_of(std::filesystem::path part);

class PartConverter {
 public:
  using Sink = can::BusHealthLog::Sink;

  /// `program`: hystcan, whose `export` is called.
  PartConverter(std::filesystem::path program, Sink sink)
      : program_(std::move(program)), sink_(std::move(sink)) {}

  /// Returns at once.
  void convert(const std::filesystem::path& part);

 private:
  struct Child {
    pid_t pid;
    std::filesystem::path part;
  };
  void warn(const std::filesystem::path& part);
  bool has_ended(const Child& child);

  std::filesystem::path program_;
  Sink sink_;
  std::vector<Child> children_;
};

}  // namespace hystcan::runs
