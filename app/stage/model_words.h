// Order, curves and creep of a model that is to be identified, as options of a command name them.
#pragma once

#include <string>

#include "identification/search.h"

namespace CLI {
class App;
}  // namespace CLI

namespace hystcan::app {

/// "auto": as the datasets show it.
struct ModelWords {
  std::string order = "auto";   ///< of a polynomial
  std::string curves = "auto";  ///< or polynomial, spline
  std::string creep = "auto";   ///< or none, or a share of the output in each decade of time

  void apply_to(identification::IdentifyOptions& asked) const;
};

/// `words` must outlive the command.
void add_model_options(CLI::App& command, ModelWords& words);

}  // namespace hystcan::app
