// The output of an amplifier whose input is connected to a converter of a card.
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
// The node calls works() at each SYNC. After a failed conversion works() writes the safe drive and returns
// false, and repeats this at each SYNC until a write succeeds. works() also returns false while the interlock
// is active, and at the SYNC after the guard made a driven output safe.

class CardOutput final : public DriveOutput {
 public:
  /// Throws ChannelError if the card lacks a channel, or if the range of the output does not contain the
  /// voltages of all `drives`.
  CardOutput(const AnalogueConfig& config, const DriveRange& drives, Card& card);

  bool reaches(double drive) const override;
  void switch_on() override;
  void go_to(double drive, can::Time from, can::Duration within) override;
  void leave(WatchdogAction action, can::Time from) override;
  double output(can::Time at) override;
  bool works() override;
  /// From now on, works() reads `takeovers`: how often the guard made the output safe (Guard::takeovers()).
  /// If this number changes while the output is driven, works() returns false.
  void obey(const std::atomic<unsigned>& takeovers) { takeovers_ = &takeovers; }
  /// Writes the safe drive, then switches the enable line off. Returns false if one of the two failed.
  bool make_safe();

  const VoltageRange& range() const { return output_->range(); }

 private:
  bool write(double drive);
  bool is_overruled();
  bool interlock_is_active();

  AnalogueConfig config_;
  DriveRange drives_;
  std::unique_ptr<VoltageOutput> output_;
  std::unique_ptr<VoltageInput> monitor_;    ///< input that measures the output; null: the output is assumed
                                             ///< to equal the last written value
  std::unique_ptr<LineOutput> enable_;       ///< active while the output is driven; null: no enable line
  std::unique_ptr<LineOutput> charge_pump_;  ///< toggles at each SYNC; null: no charge-pump line
  std::unique_ptr<LineInput> interlock_;     ///< input for the interlock; null: no interlock line
  double written_ = 0.0;
  const std::atomic<unsigned>* takeovers_ = nullptr;  ///< number of times the guard made the
                                                      ///< output safe (see obey()); null: no guard
  unsigned known_takeovers_ = 0;
  bool is_driven_ = false;
  bool has_failed_ = false;
  bool pump_is_high_ = false;
};

}  // namespace hystcan::node
