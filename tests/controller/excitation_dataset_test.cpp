#include "controller/excitation_dataset.h"

#include <gtest/gtest.h>

namespace hystcan::controller::excitation_dataset_test {
namespace {

CycleRecord cycle(std::uint64_t number, double drive, double position_um) {
  CycleRecord record;
  record.cycle = number;
  record.time_s = 1e-3 * static_cast<double>(number);
  record.report.state = AxisState::tracking;
  record.report.drive = drive;
  record.report.position_um = position_um;
  return record;
}

CycleRecord ready(std::uint64_t number, double drive) {
  CycleRecord record = cycle(number, drive, 0.0);
  record.report.state = AxisState::ready;
  return record;
}

TEST(ExcitationDataset, PairsAPositionWithTheDriveThatTakesEffectAtItsSync) {
  ExcitationDataset excitation;
  EXPECT_FALSE(excitation.add(ready(6, 10.0)));
  const auto first = excitation.add(cycle(7, 11.0, 0.7));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->time_s, 0.0);
  EXPECT_EQ(first->input, 10.0) << "the command that answers SYNC 6 is in force from SYNC 7 on";
  EXPECT_EQ(first->output, 0.7);
  const auto second = excitation.add(cycle(8, 12.0, 0.8));
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->time_s, 1e-3, 1e-15);
  EXPECT_EQ(second->input, 11.0);
  EXPECT_EQ(excitation.rows(), 2u);
}

TEST(ExcitationDataset, BeginsAfterItsLead) {
  ExcitationDataset excitation(2e-3);
  EXPECT_FALSE(excitation.add(ready(6, 10.0)));
  EXPECT_FALSE(excitation.add(cycle(7, 11.0, 0.7)));
  EXPECT_FALSE(excitation.add(cycle(8, 12.0, 0.8)));
  const auto first = excitation.add(cycle(9, 13.0, 0.9));
  ASSERT_TRUE(first);
  EXPECT_EQ(first->time_s, 0.0);
  EXPECT_EQ(first->input, 12.0);
  EXPECT_EQ(excitation.rows(), 1u);
  EXPECT_EQ(excitation.left_out(), 0u);
}

TEST(ExcitationDataset, LeavesOutABridgedSampleAndContinues) {
  ExcitationDataset excitation;
  excitation.add(ready(1, 1.0));
  excitation.add(cycle(2, 2.0, 0.2));
  CycleRecord bridged = cycle(3, 3.0, 0.2);
  bridged.report.sample_missing = true;
  EXPECT_FALSE(excitation.add(bridged));
  const auto next = excitation.add(cycle(4, 4.0, 0.4));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->input, 3.0) << "the bridged cycle has a command too";
  EXPECT_EQ(excitation.left_out(), 1u);
}

TEST(ExcitationDataset, LeavesOutTheCycleAfterALostRecord) {
  ExcitationDataset excitation;
  excitation.add(ready(1, 1.0));
  excitation.add(cycle(2, 2.0, 0.2));
  EXPECT_FALSE(excitation.add(cycle(4, 4.0, 0.4))) << "the drive of cycle 3 is not known";
  EXPECT_TRUE(excitation.add(cycle(5, 5.0, 0.5)));
}

TEST(ExcitationDataset, EndsAtTheEndOfTheExcitationAndAtAFault) {
  ExcitationDataset excitation;
  excitation.add(ready(1, 1.0));
  CycleRecord finished = cycle(2, 2.0, 0.2);
  finished.report.point.finished = true;
  EXPECT_FALSE(excitation.add(finished));
  CycleRecord faulted = cycle(3, 0.0, 0.3);
  faulted.report.state = AxisState::faulted;
  EXPECT_FALSE(excitation.add(faulted));
  EXPECT_EQ(excitation.rows(), 0u);
  EXPECT_EQ(excitation.left_out(), 0u);
}

}  // namespace
}  // namespace hystcan::controller::excitation_dataset_test
