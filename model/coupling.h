// One entry of a stage's coupling matrix. Where another axis moves, this one's position changes too:
//
//   y = own + um_per_um * d          d: how far the other axis moves [um]
#pragma once

#include <cstddef>
#include <string>

namespace hystcan::model {

struct Coupling {
  std::string from;  ///< Name of the other axis.
  double um_per_um = 0.0;
  std::size_t index = 0;  ///< Of the other axis.
};

}  // namespace hystcan::model
