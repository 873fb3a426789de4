#include "can/interface.h"

#include <gtest/gtest.h>

#include <utility>

#include <boost/asio/io_context.hpp>

#include "can/socketcan_bus.h"

namespace hystcan::can {
namespace {

template <class Action>
std::string refusal(Action action) {
  try {
    action();
  } catch (const InterfaceError& error) {
    return error.what();
  }
  return "";
}

TEST(Interface, ThatIsAbsentIsRefusedWithTheCommandThatMakesIt) {
  EXPECT_EQ(refusal([] { require_can_interface("vcan97"); }),
            "interface vcan97 does not exist; create it with: ip link add dev vcan97 type vcan && ip link "
            "set vcan97 up");
  EXPECT_EQ(refusal([] { require_can_interface("can97"); }),
            "interface can97 does not exist; list those that do with: ip -brief link show type can");
  EXPECT_EQ(refusal([] { require_can_interface("a-name-longer-than-the-kernel-has"); }),
            "interface a-name-longer-than-the-kernel-has does not exist; list those that do with: ip -brief "
            "link show "
            "type can");
  EXPECT_EQ(refusal([] { require_can_interface(""); }).find("interface  does not exist"), 0U);
}

TEST(Interface, ThatIsNotCanIsRefused) {
  if (!query_interface("lo")) GTEST_SKIP() << "no loopback interface here";
  EXPECT_EQ(refusal([] { require_can_interface("lo"); }), "interface lo is not a CAN interface");
}

TEST(Interface, ThatIsAbsentIsNeitherVirtualNorReal) {
  EXPECT_THROW(is_virtual_interface("vcan97"), InterfaceError);
}

TEST(SocketCanBus, IsRefusedWhereTheInterfaceIsAbsentOrTheKernelHasNoCan) {
  boost::asio::io_context context;
  const std::string what = refusal([&] { SocketCanBus bus(context, "vcan97", {}); });
  EXPECT_TRUE(what.starts_with("this kernel has no CAN support (AF_CAN: ") ||
              what.starts_with("interface vcan97 does not exist; "))
      << what;
}

}  // namespace
}  // namespace hystcan::can
