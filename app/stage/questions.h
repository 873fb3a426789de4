// Asks the user on a terminal for facts that a command needs and that its options do not state. One question
// is asked at a time.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace hystcan::app {

struct Question {
  std::string option;  ///< option that states the same fact, for example "--drive-max"
  std::string what;    ///< subject of the question, for example "Highest drive"
  std::string unit;    ///< unit of the answer; empty: no unit
  std::string why;     ///< one sentence that helps to answer
};

/// Returns `nullopt` if `is_sound` is true, otherwise the formatted description of the problem.
template <class... Args>
std::optional<std::string> unless(bool is_sound, fmt::format_string<Args...> format, Args&&... args) {
  return is_sound ? std::nullopt : std::optional(fmt::format(format, std::forward<Args>(args)...));
}

/// Returns the value of an option for axis i; `nullopt` if the option has no values. The option may have one
/// value, which then applies to all axes, or one value for each axis.
template <class Value>
std::optional<Value> of_axis(const char* option, const std::vector<Value>& values, std::size_t i,
                             std::size_t axes) {
  if (values.empty()) return std::nullopt;
  if (values.size() != 1 && values.size() != axes)
    throw Error(fmt::format("{} has {} values", option, values.size()),
                expect("one value, or one value for each of {} axes", axes));
  return values.size() == 1 ? values.front() : values[i];
}

class Questions {
 public:
  /// Thrown if the user answers `<`, to go back one question. The caller must start again with begin(). The
  /// earlier answers are then reused without a question.
  struct StepBack {};

  /// A function that checks an answer. It returns one line that describes the problem; `nullopt` accepts the
  /// answer.
  template <class T>
  using Check = std::function<std::optional<std::string>(const T&)>;

  /// `asks`: if true, shows questions on standard error and reads answers from `in`; if false, uses the
  /// defaults.
  Questions(std::istream& in, bool asks) : in_(in), asks_(asks) {}

  /// Starts again with the first question. Questions that already have an accepted answer are not shown.
  void begin();

  /// Returns `stated` if it has a value, otherwise the user's answer or the default `usual`. Throws an error
  /// that names the option if `check` refuses a stated value. If there is no value at all, returns NaN or an
  /// empty text, and require_all() will throw.
  double number(const Question& question, const std::optional<double>& stated,
                const std::optional<double>& usual, const Check<double>& check = {});
  std::string text(const Question& question, const std::optional<std::string>& stated,
                   const std::optional<std::string>& usual, const Check<std::string>& check = {});

  /// Throws Error with the names of all options that were neither stated nor answered and have no default.
  void require_all() const;

  int asked() const { return asked_; }

 private:
  /// Stores the answer to the current question and goes on to the next one.
  void accept(const std::string& line);
  void object(const std::string& problem);
  /// Shows the question and returns the line that the user types; `nullopt` if no questions are to be asked.
  /// Throws RunError if the input ends.
  std::optional<std::string> answer(const Question& question, const std::string& usual);

  std::istream& in_;
  bool asks_;
  int asked_ = 0;
  std::vector<std::string> missing_;
  std::vector<std::string> accepted_;  ///< accepted answers in the order of their questions
  std::size_t next_ = 0;               ///< index of the current question in `accepted_`
};

}  // namespace hystcan::app
