#include "can/socketcan/interface.h"

#include <gtest/gtest.h>

#include <utility>

#include <boost/asio/io_context.hpp>

#include "can/socketcan/socketcan_bus.h"
#include "tests/support/refusal.h"

namespace hystcan::can::interface_test {
namespace {

/// If the kernel has no CAN, the message states this first, because then no interface can help.
void expect_refused(const char* name, const std::string& what) {
  const std::string reason = support::refusal_of<RunError>([name] { require_can_interface(name); });
  EXPECT_TRUE(reason == what || reason.starts_with("this kernel has no CAN support (AF_CAN: ")) << reason;
}

TEST(Interface, IsRefusedIfAbsentWithTheCommandThatCreatesIt) {
  expect_refused(
      "vcan97",
      "interface vcan97 does not exist; create it with: ip link add dev vcan97 type vcan && ip link "
      "set vcan97 up");
  const std::string list = " does not exist; list the existing interfaces with: ip -brief link show type can";
  expect_refused("can97", "interface can97" + list);
  expect_refused("a-name-longer-than-the-kernel-has", "interface a-name-longer-than-the-kernel-has" + list);
  expect_refused("", "interface " + list);
}

TEST(Interface, IsRefusedIfItIsNotCan) {
  if (!query_interface("lo")) GTEST_SKIP() << "no loopback interface here";
  expect_refused("lo", "interface lo is not a CAN interface");
}

TEST(Interface, IsNeitherVirtualNorRealIfItIsAbsent) {
  EXPECT_THROW(is_virtual_interface("vcan97"), RunError);
}

TEST(SocketCanBus, IsRefusedIfTheInterfaceIsAbsentOrTheKernelHasNoCan) {
  boost::asio::io_context context;
  const std::string what = support::refusal_of<RunError>([&] { SocketCanBus bus(context, "vcan97", {}); });
  EXPECT_TRUE(what.starts_with("this kernel has no CAN support (AF_CAN: ") ||
              what.starts_with("interface vcan97 does not exist; "))
      << what;
}

}  // namespace
}  // namespace hystcan::can::interface_test
