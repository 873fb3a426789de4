// Coupling between two axes of a stage: the motion of another axis changes the position of this axis. A
// Coupling is one entry of the stage's coupling matrix.
//
//   y = own + um_per_um * d
//
//   y      position of this axis
//   own    position of this axis without coupling
//   d      displacement of the other axis, um
#pragma once

#include <cstddef>
#include <string>

namespace hystcan::model {

struct Coupling {
  std::string from;  ///< name of the other axis
  double um_per_um = 0.0;
  std::size_t index = 0;  ///< index of the other axis in the list of axes
};

}  // namespace hystcan::model
