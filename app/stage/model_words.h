// Command-line options for the order, the curves and the creep of a model to be identified.
#pragma once

#include <string>

#include "identification/search.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

/// The values of the options as text. With "auto", the identification chooses from the datasets.
struct ModelWords {
  std::string order = "auto";   ///< degree of the polynomial curves, or "auto"
  std::string curves = "auto";  ///< "auto", "polynomial" or "spline"
  std::string creep = "auto";   ///< "auto", "none", or creep per decade of time as a share of the output

  void apply_to(identification::IdentifyOptions& options) const;
};

/// Adds the options to `command`. Their values are stored in `words`, which must outlive `command`.
void add_model_options(CLI::App& command, ModelWords& words);

}  // namespace hystcan::app
