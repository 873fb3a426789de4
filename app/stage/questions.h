// What a command needs to know and its options do not say: asked on a terminal, one question at a time.
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
  std::string option;  ///< "--drive-max", which says the same without a question
  std::string what;    ///< "Highest drive"
  std::string unit;    ///< empty: none
  std::string why;     ///< one sentence
};

/// None where the answer is sound.
template <class... Args>
std::optional<std::string> unless(bool is_sound, fmt::format_string<Args...> format, Args&&... args) {
  return is_sound ? std::nullopt : std::optional(fmt::format(format, std::forward<Args>(args)...));
}

/// The value of axis i, of an option that has one for all axes or one for each; none if it has none.
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
  /// Thrown where the answer was `<`. Whoever asks begins again: the answers before the last one are given by
  /// themselves.
  struct StepBack {};

  /// What is wrong with an answer, in one line; none: it is taken.
  template <class T>
  using Check = std::function<std::optional<std::string>(const T&)>;

  /// `asks`: reads answers from `in` and shows questions on standard error; else takes the defaults.
  Questions(std::istream& in, bool asks) : in_(in), asks_(asks) {}

  /// From the first question on; those that have an accepted answer are not shown again.
  void begin();

  /// `stated`, or the answer. A stated value that `check` refuses is an error that names the option. NaN, or
  /// an empty text, where nothing is known; require_all() then throws.
  double number(const Question& question, const std::optional<double>& stated,
                const std::optional<double>& usual, const Check<double>& check = {});
  std::string text(const Question& question, const std::optional<std::string>& stated,
                   const std::optional<std::string>& usual, const Check<std::string>& check = {});

  /// Throws Error with all options that have no default and were neither stated nor asked for.
  void require_all() const;

  int asked() const { return asked_; }

 private:
  /// Keeps the answer to the present question, which then is the next one.
  void accept(const std::string& line);
  void object(const std::string& wrong);
  /// The line that was answered; none where no question is asked. Throws RunError at the end of the input.
  std::optional<std::string> answer(const Question& question, const std::string& usual);

  std::istream& in_;
  bool asks_;
  int asked_ = 0;
  std::vector<std::string> missing_;
  std::vector<std::string> accepted_;  ///< answers in the order of their questions
  std::size_t next_ = 0;               ///< question, counted as in `accepted_`
};

}  // namespace hystcan::app
