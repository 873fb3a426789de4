// The greeting of a controller with two axes and the columns that captures need.
#pragma once

#include "app/live/samples.h"

namespace hystcan::app {

inline StreamGreeting two_axes() {
  return {.columns = {{"time_s"},
                      {"axis"},
                      {"state"},
                      {"fault"},
                      {"reference_um"},
                      {"scan_line"},
                      {"turnaround_us"},
                      {"lateness_us"},
                      {"position_um"},
                      {"sample_missing"}},
          .axes = {{"x"}, {"y"}}};
}

}  // namespace hystcan::app
