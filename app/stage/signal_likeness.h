// How like a signal of a DBC is to what is looked for: by the words of its name and of its message's, by its
// unit, by its range. Each word that fits gives points; what fits something else takes them away.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "model/reference_curve.h"

namespace hystcan::app {

using Words = std::vector<std::string_view>;

/// The first of the words that is a part of the name, or that begins one and has three letters or more. The
/// parts of AmpSetpoint_V1 are amp, setpoint, v, 1. Empty: none.
std::string_view word_in(std::string_view name, const Words& words);

std::string in_lower_case(std::string_view text);

/// True: the signal can be decoded, and its unit differs by a decimal prefix at most.
bool converts(const can::Signal& signal, std::string_view unit);

struct LikeSignal {
  const can::Message* message = nullptr;  ///< null: nothing is like it
  const can::Signal* signal = nullptr;
  int points = 0;
  std::string because;  ///< "mV, set, volt"
};

class LikeSignals {
 public:
  /// `axis`: a name that a signal of this axis has somewhere; empty: there is one axis. A message that is
  /// `taken` is left out; the set is looked at with each search.
  LikeSignals(const can::Database& database, std::string_view axis,
              const std::set<const can::Message*>& taken)
      : database_(database), axis_(in_lower_case(axis)), taken_(taken) {}

  /// The signal that can say these values, most like `words`, in name and message, and least like `others`;
  /// `names` are good for a name alone.
  LikeSignal best(std::string_view unit, const model::Interval& values, const Words& words,
                  const Words& others, const Words& names) const;

 private:
  LikeSignal judged(const can::Message& message, const can::Signal& signal, const Words& words,
                    const Words& others, const Words& names) const;
  bool is_of_axis(const can::Message& message, const can::Signal& signal) const;

  const can::Database& database_;
  std::string axis_;
  const std::set<const can::Message*>& taken_;
};

}  // namespace hystcan::app
