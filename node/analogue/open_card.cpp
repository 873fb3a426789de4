#include "base/error.h"
#include "node/analogue/card.h"
#include "node/analogue/device_name.h"
#ifdef HYSTCAN_COMEDI
#include "node/analogue/comedi_card.h"
#endif
#ifdef HYSTCAN_IIO
#include "node/analogue/iio_card.h"
#endif

namespace hystcan::node {

std::unique_ptr<Card> open_card(const std::string& device) {
  const DeviceName named = device_named(device);
  switch (named.kind) {
    case CardKind::comedi:
#ifdef HYSTCAN_COMEDI
      return open_comedi_card(named.name);
#else
      throw Error(device, "this hystcan was built without libcomedi",
                  {.remedy = "install libcomedi-dev and rebuild hystcan"});
#endif
    case CardKind::iio:
#ifdef HYSTCAN_IIO
      return open_iio_card(named.name);
#else
      throw Error(device, "this hystcan was built without libiio",
                  {.remedy = "install libiio-dev and rebuild hystcan"});
#endif
    case CardKind::simulated:
      break;
  }
  throw Error(device, "not a real card",
              {.remedy = "set device to a card (example: comedi:/dev/comedi0 or iio:ad5791)"});
}

}  // namespace hystcan::node
