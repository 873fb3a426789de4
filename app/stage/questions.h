// Asks on a terminal, one question at a time, for facts that a command needs and its options do not contain.
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
  std::string option;  ///< option with the same effect as the answer, "--drive-max"
  std::string what;    ///< subject of the question, "Highest drive"
  std::string unit;    ///< empty: no unit
  std::string why;     ///< reason for the question, one sentence
};

/// Returns `nullopt` if the answer is valid, otherwise the formatted problem.
template <class... Args>
std::optional<std::string> unless(bool is_sound, fmt::format_string<Args...> format, Args&&... args) {
  return is_sound ? std::nullopt : std::optional(fmt::format(format, std::forward<Args>(args)...));
}

/// Returns the value for axis i of an option that has one value for all axes or one for each; `nullopt` if
/// the option has none.
template <class Value>
std::optional<Value> of_axis(const char* option, const std::vector<Value>& values, std::size_t i,
                             std::size_t axes) {
  if (values.empty()) return std::nullopt;
  if (values.size() != 1 && values.size() != axes)
    throw Error(fmt::format("{} has {} values", option, values.size()),
                expect("one, or one for each of {} axes", axes));
  return values.size() == 1 ? values.front() : values[i];
}

class Questions {
 public:
  /// Thrown if the answer was `<`. The caller starts again; the answers before the last one are reused.
  struct StepBack {};

  /// Returns one line that describes the problem with an answer; `nullopt` if the answer is accepted.
  template <class T>
  using Check = std::function<std::optional<std::string>(const T&)>;

  /// `asks`: true reads answers from `in` and shows questions on standard error; false takes the defaults.
  Questions(std::istream& in, bool asks) : in_(in), asks_(asks) {}

  /// Starts again with the first question; questions with an accepted answer are not shown again.
  void begin();

  /// Returns `stated`, or the answer. If `check` refuses a stated value, throws an error that names the
  /// option. Returns NaN, or an empty text, if nothing is known; require_all() then throws.
  double number(const Question& question, const std::optional<double>& stated,
                const std::optional<double>& usual, const Check<double>& check = {});
  std::string text(const Question& question, const std::optional<std::string>& stated,
                   const std::optional<std::string>& usual, const Check<std::string>& check = {});

  /// Throws Error with all options that have no default and were neither stated nor asked.
  void require_all() const;

  int asked() const { return asked_; }

 private:
  /// Stores the answer to the present question and proceeds to the next one.
  void accept(const std::string& line);
  void object(const std::string& problem);
  /// Returns the line that was typed; `nullopt` if no question is asked. Throws RunError at the end of the
  /// input.
  std::optional<std::string> answer(const Question& question, const std::string& usual);

  std::istream& in_;
  bool asks_;
  int asked_ = 0;
  std::vector<std::string> missing_;
  std::vector<std::string> accepted_;  ///< answers in the order of their questions
  std::size_t next_ = 0;               ///< index of the next question in `accepted_`
};

}  // namespace hystcan::app
