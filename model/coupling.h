// One entry of a stage's coupling matrix: the motion of another axis changes the position of this one.
//
//   y = own + um_per_um * d          own: position without coupling; d: displacement of the other axis [um]
#pragma once

#include <cstddef>
#include <string>

namespace hystcan::model {

struct Coupling {
  std::string from;  ///< Name of the other axis.
  double um_per_um = 0.0;
  std::size_t index = 0;  ///< index of the other axis
};

}  // namespace hystcan::model
