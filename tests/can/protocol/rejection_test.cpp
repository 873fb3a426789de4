// The counts and texts of the receiver of a protected message, and the lengths that it expects.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "can/protocol/e2e.h"

namespace hystcan::can::rejection_test {
namespace {

TEST(Rejection, IsDescribedWithItsCauseAndCount) {
  EXPECT_EQ(describe({.message = "XAmpStatus", .by_cause = {1, 2, 3, 4, 5}}),
            "XAmpStatus: rejected: 1 not a data frame, 2 wrong identifier type, 3 wrong length, 4 wrong CRC, "
            "5 repeated counter");
}

TEST(Rejection, IsDescribedOnlyIfItOccurred) {
  EXPECT_EQ(describe({.message = "XAmpStatus", .by_cause = {0, 0, 0, 1, 0}}),
            "XAmpStatus: rejected: 1 wrong CRC");
  EXPECT_EQ(describe({.message = "XAmpStatus"}), "");
}

TEST(Rejection, IsCountedByItsCauseInTheReport) {
  E2eChecker checker({}, 8, false);
  checker.check({.kind = FrameKind::remote, .length = 8});
  checker.check({.length = 7});
  checker.check({.length = 9});
  checker.check({.extended = true, .length = 8});
  const RejectedFrames rejected = rejected_frames("XAmpStatus", checker);
  EXPECT_EQ(rejected.message, "XAmpStatus");
  EXPECT_EQ(rejected.by_cause, (std::array<std::uint64_t, rejection_count>{1, 1, 2, 0, 0}));
}

TEST(Rejection, DoesNotOccurWithoutCounterAndCrc) {
  E2eChecker checker({}, 8, false);
  const Frame frame{.length = 8};
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(checker.check(frame));
  EXPECT_EQ(checker.accepted(), 3u);
}

TEST(WireLength, IsTheNextLengthOfCanFd) {
  const std::vector<std::pair<int, int>> lengths{{0, 0},   {1, 1},   {8, 8},   {9, 12},  {12, 12}, {13, 16},
                                                 {16, 16}, {17, 20}, {20, 20}, {21, 24}, {24, 24}, {25, 32},
                                                 {32, 32}, {33, 48}, {48, 48}, {49, 64}, {64, 64}, {255, 64}};
  for (const auto& [message, wire] : lengths)
    EXPECT_EQ(wire_length(static_cast<std::uint8_t>(message)), wire) << message;
}

TEST(WireKind, IsCanFdBeyondEightBytes) {
  EXPECT_EQ(wire_kind(8), FrameKind::data);
  EXPECT_EQ(wire_kind(9), FrameKind::fd);
}

}  // namespace
}  // namespace hystcan::can::rejection_test
