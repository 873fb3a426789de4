// The table of what a search has tried: which parts of a model lower the error of what is held out.
#pragma once

#include <string>

#include "app/stage/identification_report.h"

namespace hystcan::app {

/// HTML; empty if nothing was held out.
std::string structures_of(const IdentificationReport& report);

}  // namespace hystcan::app
