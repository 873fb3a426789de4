// The drive of an amplifier that a card's converter commands.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "node/analogue/card.h"
#include "node/analogue/config.h"
#include "node/drive_output.h"

namespace hystcan::node {

// volts = volts_per_drive * drive
//
// After a failed conversion the output does not work: the safe drive is written at each SYNC until a write
// succeeds. It does not work while the interlock is active either, nor at the SYNC after the guard took over
// a driven output.

class CardOutput final : public DriveOutput {
 public:
  /// Throws ChannelError if the card lacks a channel, or if its range does not reach a drive.
  CardOutput(const AnalogueConfig& config, const DriveRange& drives, Card& card);

  bool reaches(double drive) const override;
  void switch_on() override;
  void go_to(double drive, can::Time from, can::Duration within) override;
  void leave(WatchdogAction action, can::Time from) override;
  double output(can::Time at) override;
  bool works() override;
  /// `takeovers`: of the guard (Guard::takeovers).
  void obey(const std::atomic<unsigned>& takeovers) { takeovers_ = &takeovers; }
  /// Writes the safe drive, then switches the line off. False: the card has refused one of them.
  bool make_safe();

  const VoltageRange& range() const { return output_->range(); }

 private:
  bool write(double drive);
  bool is_overruled();
  bool interlock_is_active();

  AnalogueConfig config_;
  DriveRange drives_;
  std::unique_ptr<VoltageOutput> output_;
  std::unique_ptr<VoltageInput> monitor_;    ///< null: the output is what was written
  std::unique_ptr<LineOutput> enable_;       ///< null: none
  std::unique_ptr<LineOutput> charge_pump_;  ///< null: none
  std::unique_ptr<LineInput> interlock_;     ///< null: none
  double written_ = 0.0;
  const std::atomic<unsigned>* takeovers_ = nullptr;  ///< null: there is no guard
  unsigned known_takeovers_ = 0;
  bool is_driven_ = false;
  bool has_failed_ = false;
  bool pump_is_high_ = false;
};

}  // namespace hystcan::node
