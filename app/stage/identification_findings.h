// The observations and decisions of an identification, in sentences for the engineer.
#pragma once

#include <string>
#include <vector>

#include "identification/identify.h"

namespace hystcan::app {

std::vector<std::string> findings(const std::vector<identification::Dataset>& datasets,
                                  const identification::Identified& identified);

}  // namespace hystcan::app
