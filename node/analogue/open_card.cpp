#include <fmt/format.h>

#include "base/error.h"
#include "node/analogue/card.h"
#ifdef HYSTCAN_COMEDI
#include "node/analogue/comedi_card.h"
#endif
#ifdef HYSTCAN_IIO
#include "node/analogue/iio_card.h"
#endif

namespace hystcan::node {

std::unique_ptr<Card> open_card(const std::string& device) {
  if (device.starts_with("comedi:/")) {
#ifdef HYSTCAN_COMEDI
    return open_comedi_card(device.substr(7));
#else
    throw Error(device, "this program was built without libcomedi",
                {.remedy = "install libcomedi-dev and build again"});
#endif
  }
  if (device.starts_with("iio:") && device != "iio:") {
#ifdef HYSTCAN_IIO
    return open_iio_card(device.substr(4));
#else
    throw Error(device, "this program was built without libiio",
                {.remedy = "install libiio-dev and build again"});
#endif
  }
  throw Error(fmt::format("device \"{}\" is not known", device),
              {.remedy = "name one as comedi:/dev/comedi0, iio:ad5791 or simulated"});
}

}  // namespace hystcan::node
