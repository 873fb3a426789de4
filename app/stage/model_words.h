// Options for the order, curves and creep of a model that is to be identified.
#pragma once

#include <string>

#include "identification/search.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

/// The values of the options; "auto" lets the identification choose from the datasets.
struct ModelWords {
  std::string order = "auto";   ///< degree of polynomials
  std::string curves = "auto";  ///< auto, polynomial or spline
  std::string creep = "auto";   ///< auto, none, or a share of the output per decade of time

  void apply_to(identification::IdentifyOptions& options) const;
};

/// `words` must outlive the command.
void add_model_options(CLI::App& command, ModelWords& words);

}  // namespace hystcan::app
