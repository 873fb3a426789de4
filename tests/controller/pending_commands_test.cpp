#include "controller/pending_commands.h"

#include <gtest/gtest.h>

namespace hystcan::controller::pending_commands_test {
namespace {

can::Frame command(std::uint8_t counter) { return {.id = 0x201, .length = 1, .data = {counter}}; }

PendingCommands counting() {
  PendingCommands pending;
  pending.begin_to_count();
  return pending;
}

TEST(PendingCommands, AreLateWhenTwoHaveNotLeft) {
  PendingCommands pending = counting();
  pending.add(command(1), false);
  EXPECT_FALSE(pending.are_late());
  pending.add(command(2), false);
  EXPECT_TRUE(pending.are_late());
  pending.confirm(command(1));
  EXPECT_FALSE(pending.are_late());
}

TEST(PendingCommands, HaveLeftWhenALaterOneHas) {
  PendingCommands pending = counting();
  for (std::uint8_t i = 1; i <= 5; ++i) pending.add(command(i), false);
  pending.confirm(command(4));
  EXPECT_FALSE(pending.are_late()) << "the echoes of the others were lost";
  pending.add(command(6), false);
  EXPECT_TRUE(pending.are_late());
}

TEST(PendingCommands, AreNotCountedWhereTheBusReportsNoEcho) {
  PendingCommands pending;
  for (std::uint8_t i = 1; i <= 5; ++i) pending.add(command(i), true);
  EXPECT_FALSE(pending.are_late());
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
}

TEST(PendingCommands, HoldBackASafeOneWhileAnotherIsOnItsWay) {
  PendingCommands pending = counting();
  pending.add(command(1), false);
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
  pending.add(command(2), true);
  EXPECT_TRUE(pending.is_safe_one_on_its_way());
  pending.confirm(command(2));
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
}

TEST(PendingCommands, CountAsLostAfterAHundredCycles) {
  PendingCommands pending = counting();
  pending.add(command(1), true);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(pending.is_safe_one_on_its_way());
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
}

TEST(PendingCommands, AreCountedAnewAfterTheyHaveCountedAsLost) {
  PendingCommands pending = counting();
  pending.add(command(1), true);
  for (int i = 0; i < 101; ++i) pending.is_safe_one_on_its_way();
  pending.add(command(2), true);
  EXPECT_FALSE(pending.are_late()) << "the first one is lost";
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(pending.is_safe_one_on_its_way());
}

TEST(PendingCommands, HoldBackSafeOnesForAHundredCyclesFromTheLatest) {
  PendingCommands pending = counting();
  pending.add(command(1), true);
  for (int i = 0; i < 60; ++i) pending.is_safe_one_on_its_way();
  pending.add(command(2), true);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(pending.is_safe_one_on_its_way());
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
}

TEST(PendingCommands, AreForgottenWithTheBus) {
  PendingCommands pending = counting();
  pending.add(command(1), false);
  pending.add(command(2), true);
  pending.forget();
  EXPECT_FALSE(pending.is_safe_one_on_its_way());
  pending.add(command(3), false);
  EXPECT_FALSE(pending.are_late());
}

TEST(PendingCommands, KeepTheirOrderWhereMoreArePendingThanTheyCanHold) {
  PendingCommands pending = counting();
  for (std::uint8_t i = 1; i <= 10; ++i) pending.add(command(i), false);
  pending.confirm(command(8));
  EXPECT_TRUE(pending.are_late()) << "9 and 10";
  pending.confirm(command(9));
  EXPECT_FALSE(pending.are_late());
}

TEST(PendingCommands, DoNotChangeByTheEchoOfACommandThatIsNotPending) {
  PendingCommands pending = counting();
  pending.add(command(1), false);
  pending.confirm(command(3));
  EXPECT_FALSE(pending.are_late());
  pending.add(command(2), false);
  EXPECT_TRUE(pending.are_late());
}

TEST(PendingCommands, KeepTheLatestWhereMoreArePendingThanTheyCanHold) {
  PendingCommands pending = counting();
  for (std::uint8_t i = 1; i <= 50; ++i) pending.add(command(i), false);
  EXPECT_TRUE(pending.are_late());
  pending.confirm(command(50));
  pending.add(command(51), false);
  EXPECT_FALSE(pending.are_late());
}

}  // namespace
}  // namespace hystcan::controller::pending_commands_test
