// The kernel's description of an interface, byte for byte on a little-endian machine, and its parsed form.
#include "can/socketcan/interface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "can/socketcan/socketcan_bus.h"
#include "tests/support/refusal.h"
#include "tests/support/shows.h"

namespace hystcan::can::link_message_test {
namespace {

using Octets = std::vector<std::uint8_t>;

void append(Octets& to, const Octets& what) { std::ranges::copy(what, std::back_inserter(to)); }

Octets words(const std::vector<std::uint32_t>& values) {
  Octets bytes;
  for (const std::uint32_t value : values)
    append(bytes, {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U),
                   static_cast<std::uint8_t>(value >> 16U), static_cast<std::uint8_t>(value >> 24U)});
  return bytes;
}

Octets text(const std::string& value) {
  Octets bytes(value.begin(), value.end());
  bytes.push_back(0);
  return bytes;
}

/// struct rtattr: length and type as u16, then the value, padded to four bytes.
Octets attribute(std::uint8_t type, const Octets& value) {
  Octets bytes{static_cast<std::uint8_t>(value.size() + 4), 0, type, 0};
  append(bytes, value);
  while (bytes.size() % 4 != 0) bytes.push_back(0);
  return bytes;
}

Octets joined(const std::vector<Octets>& parts) {
  Octets bytes;
  for (const Octets& part : parts) append(bytes, part);
  return bytes;
}

/// nlmsghdr of type 16 (RTM_NEWLINK), ifinfomsg of type 280 (ARPHRD_CAN), index 3, flags 1 (IFF_UP).
Octets new_link(const Octets& attributes) {
  Octets bytes = words({static_cast<std::uint32_t>(32 + attributes.size()), 16, 0, 0});
  append(bytes, {0, 0, 0x18, 0x01});
  append(bytes, words({3, 1, 0}));
  append(bytes, attributes);
  return bytes;
}

std::optional<Interface> parsed(const Octets& bytes) {
  return parse_link_message(std::as_bytes(std::span(bytes)));
}

// A passive controller at 500 kbit/s. The numbers are from linux/if_link.h and linux/can/netlink.h, part of
// the ABI.
const Octets controller = new_link(joined({
    attribute(4, words({72})),         // IFLA_MTU
    attribute(13, words({10})),        // IFLA_TXQLEN
    attribute(6, text("pfifo_fast")),  // IFLA_QDISC
    attribute(
        18,
        joined({
            // IFLA_LINKINFO
            attribute(1, text("can")),  //   IFLA_INFO_KIND
            attribute(
                2, joined({
                       //   IFLA_INFO_DATA
                       attribute(1, words({500'000, 875, 125, 6, 7, 2, 1, 8})),   // IFLA_CAN_BITTIMING
                       attribute(4, words({2})),                                  // IFLA_CAN_STATE
                       attribute(5, words({0x3F, 0x2A})),                         // IFLA_CAN_CTRLMODE
                       attribute(6, words({100})),                                // IFLA_CAN_RESTART_MS
                       attribute(8, {136, 0, 7, 0}),                              // IFLA_CAN_BERR_COUNTER
                       attribute(9, words({4'000'000, 800, 25, 3, 4, 2, 1, 4})),  // IFLA_CAN_DATA_BITTIMING
                   })),
            attribute(3, words({1, 2, 3, 4, 5, 6})),  //   IFLA_INFO_XSTATS
        })),
}));

TEST(LinkMessage, GivesTheSettingsAndTheStateOfAController) {
  const auto interface = parsed(controller);
  ASSERT_TRUE(interface);
  EXPECT_EQ(interface->index, 3);
  EXPECT_TRUE(interface->up);
  EXPECT_TRUE(interface->is_can);
  EXPECT_EQ(interface->kind, "can");
  EXPECT_EQ(interface->bus_state, BusState::passive);
  EXPECT_EQ(interface->bitrate_bit_per_s, 500'000U);
  EXPECT_EQ(interface->data_bitrate_bit_per_s, 4'000'000U);
  EXPECT_DOUBLE_EQ(interface->sample_point.value(), 0.875);
  EXPECT_EQ(interface->restart_ms, 100U);
  EXPECT_TRUE(interface->listen_only);
  EXPECT_FALSE(interface->loopback);
  EXPECT_TRUE(interface->one_shot);
  EXPECT_TRUE(interface->fd);
  EXPECT_EQ(interface->error_counters, (ErrorCounters{.transmit = 136, .receive = 7}));
  EXPECT_EQ(interface->transmit_queue_frames, 10U);
  EXPECT_EQ(interface->queue_discipline, "pfifo_fast");
  EXPECT_EQ(interface->bus_offs, 4U);
}

TEST(LinkMessage, GivesNoControllerSettingsForAVirtualInterface) {
  const auto interface = parsed(new_link(joined({
      attribute(4, words({16})),
      attribute(13, words({1000})),
      attribute(6, text("noqueue")),
      attribute(18, attribute(1, text("vcan"))),
  })));
  ASSERT_TRUE(interface);
  EXPECT_EQ(interface->bus_state, std::nullopt);
  EXPECT_EQ(interface->bitrate_bit_per_s, std::nullopt);
  EXPECT_EQ(interface->restart_ms, std::nullopt);
  EXPECT_FALSE(interface->bus_offs);
  EXPECT_FALSE(interface->fd);
  EXPECT_EQ(describe("vcan0", *interface), "vcan0: vcan, no bit rate, qdisc noqueue, 1000 frames");
  EXPECT_TRUE(find_warnings("vcan0", *interface).empty());
  EXPECT_NO_THROW(require_able_to_send("vcan0", *interface));
}

TEST(LinkMessage, IsReadUpToItsEndIfItIsCutShort) {
  for (std::size_t size = 0; size < controller.size(); ++size) {
    const auto interface = parsed(Octets(controller.begin(), controller.begin() + static_cast<long>(size)));
    EXPECT_EQ(interface.has_value(), size >= 32) << size;
  }
}

TEST(LinkMessage, GivesNoInterfaceForAnotherMessageType) {
  Octets error = controller;
  error[4] = 2;  // NLMSG_ERROR
  EXPECT_FALSE(parsed(error));
}

Interface sound() {
  Interface interface;
  interface.kind = "can";
  interface.bitrate_bit_per_s = 1'000'000;
  interface.sample_point = 0.75;
  interface.restart_ms = 100;
  interface.transmit_queue_frames = 10;
  interface.queue_discipline = "pfifo_fast";
  return interface;
}

TEST(InterfaceLine, NamesBitRateModesAndQueue) {
  EXPECT_EQ(describe("can0", sound()),
            "can0: 1000 kbit/s, sample point 75 %, restart-ms 100, qdisc pfifo_fast, 10 frames");
  EXPECT_EQ(describe("can0", *parsed(controller)),
            "can0: 500 kbit/s, sample point 87.5 %, restart-ms 100, one-shot, listen-only, FD with "
            "4000 kbit/s in the data phase, passive, qdisc pfifo_fast, 10 frames");
}

TEST(InterfaceWarnings, AreEmptyIfAllIsAsConfigured) { EXPECT_TRUE(find_warnings("can0", sound()).empty()); }

TEST(InterfaceWarnings, NameAMissingRestart) {
  Interface interface = sound();
  interface.restart_ms = 0;
  EXPECT_EQ(find_warnings("can0", interface),
            (std::vector<std::string>{
                "can0 has restart-ms 0: bus-off lasts until a user runs ip link set can0 type can restart"}));
}

TEST(InterfaceWarnings, NameTheModesInWhichFramesAreLost) {
  Interface interface = sound();
  interface.loopback = true;
  interface.one_shot = true;
  EXPECT_EQ(find_warnings("can0", interface).size(), 2U);
}

TEST(InterfaceThatIsUpAgain, IsRefusedIfItHasChangedSinceTheStart) {
  shows("S-005");
  const Interface before = sound();
  EXPECT_EQ(refusal_of(before, before), Refusal::none);
  Interface now = before;
  now.listen_only = true;
  EXPECT_EQ(refusal_of(now, before), Refusal::listen_only);
  now = before;
  now.bitrate_bit_per_s = 500'000;
  EXPECT_EQ(refusal_of(now, before), Refusal::other_bit_rate);
  Interface with_fd = before;
  with_fd.data_bitrate_bit_per_s = 5'000'000;
  now = with_fd;
  now.data_bitrate_bit_per_s = 4'000'000;
  EXPECT_EQ(refusal_of(now, with_fd), Refusal::other_bit_rate);
  with_fd = before;
  with_fd.fd = true;
  EXPECT_EQ(refusal_of(before, with_fd), Refusal::no_fd);
  EXPECT_EQ(refusal_of(with_fd, before), Refusal::none);
}

TEST(InterfaceMode, IsRefusedWithItsRemedyIfItIsListenOnly) {
  shows("S-162");
  Interface interface = sound();
  interface.listen_only = true;
  const std::string refusal = support::refusal_of<RunError>([&] { require_able_to_send("can0", interface); });
  EXPECT_EQ(refusal,
            "interface can0 is listen-only; take it down and set: ip link set can0 type can listen-only off");
}

TEST(InterfaceMode, IsRefusedWithItsRemedyIfItsBitRateDiffers) {
  shows("S-162");
  const auto refusal = [](const Interface& interface, std::uint32_t configured) -> std::string {
    return support::refusal_of<RunError>(
        [&] { require_bit_rate("can0", interface, {.nominal_bit_per_s = configured}); });
  };
  EXPECT_EQ(refusal(sound(), 500'000),
            "interface can0 has a bit rate of 1000000 bit/s, expected 500000 bit/s; take it down and set: ip "
            "link set can0 type can bitrate 500000, or correct bitrate_bit_per_s");
  EXPECT_EQ(refusal(sound(), 1'000'000), "accepted");
  EXPECT_EQ(refusal(sound(), 995'000), "accepted") << "a clock that the rate does not divide";
  EXPECT_EQ(refusal(Interface{}, 500'000), "accepted") << "it has no bit rate";
}

std::string refusal_of_fd(const std::string& name, const Interface& interface,
                          const std::vector<std::string>& messages, const BitRates& rates = {}) {
  return support::refusal_of<RunError>([&] { require_able_to_carry_fd(name, interface, messages, rates); });
}

TEST(InterfaceMode, IsRefusedWithItsRemedyIfItHasNoFdAndAMessageNeedsFd) {
  shows("S-162");
  EXPECT_EQ(
      refusal_of_fd("can0", sound(), {"AmpSet", "SensPos"}),
      "interface can0 does not accept CAN FD frames, expected CAN FD for AmpSet, SensPos; take it down and "
      "set: ip link set can0 type can bitrate 1000000 dbitrate 4000000 fd on");
  Interface virtual_one;
  virtual_one.kind = "vcan";
  EXPECT_EQ(
      refusal_of_fd("vcan0", virtual_one, {"AmpSet"}),
      "interface vcan0 does not accept CAN FD frames, expected CAN FD for AmpSet; take it down and set: ip "
      "link set vcan0 mtu 72");
  EXPECT_EQ(refusal_of_fd("vcan0", virtual_one, {}), "accepted") << "classical frames need no FD";
  virtual_one.fd = true;
  EXPECT_EQ(refusal_of_fd("vcan0", virtual_one, {"AmpSet"}), "accepted");
}

TEST(InterfaceMode, IsRefusedWithItsRemedyIfItsDataBitRateDiffers) {
  shows("S-162");
  const BitRates rates{.nominal_bit_per_s = 1'000'000, .data_bit_per_s = 5'000'000};
  Interface interface = sound();
  interface.fd = true;
  EXPECT_EQ(
      refusal_of_fd("can0", interface, {"AmpSet"}, rates),
      "interface can0 has no data bit rate, expected 5000000 bit/s for AmpSet; take it down and set: ip link "
      "set can0 type can bitrate 1000000 dbitrate 5000000 fd on");
  interface.data_bitrate_bit_per_s = 4'000'000;
  EXPECT_EQ(refusal_of_fd("can0", interface, {"AmpSet"}, rates).substr(0, 80),
            "interface can0 has a data bit rate of 4000000 bit/s, expected 5000000 bit/s for ");
  EXPECT_EQ(refusal_of_fd("can0", interface, {}, rates), "accepted") << "classical frames have no data phase";
  EXPECT_EQ(refusal_of_fd("can0", interface, {"AmpSet"}), "accepted") << "frames without bit-rate switch";
  interface.data_bitrate_bit_per_s = 5'000'000;
  EXPECT_EQ(refusal_of_fd("can0", interface, {"AmpSet"}, rates), "accepted");
  Interface virtual_one;
  virtual_one.fd = true;
  EXPECT_EQ(refusal_of_fd("vcan0", virtual_one, {"AmpSet"}, rates), "accepted") << "it has no bit rate";
}

}  // namespace
}  // namespace hystcan::can::link_message_test
