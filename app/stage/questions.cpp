#include "app/stage/questions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <limits>
#include <string_view>

#include "base/error.h"
#include "base/standard_streams.h"
#include "can/protocol/layout.h"

namespace hystcan::app {
namespace {

std::string without_spaces_around(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// Returns true for a text such as "1,234", in which the comma may be a decimal comma or a thousands
/// separator.
bool has_ambiguous_comma(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return false;
  const std::size_t end = text.find_first_not_of("0123456789", comma + 1);
  return std::min(end, text.size()) - comma - 1 == 3;
}

/// Parses a number with an optional unit: "60.5", "60,5", "60 um", or "0.31 kHz" if `unit` is Hz.
std::optional<double> parsed(std::string text, const std::string& unit) {
  if (has_ambiguous_comma(text)) return std::nullopt;
  if (text.find('.') == std::string::npos && std::ranges::count(text, ',') == 1)
    std::ranges::replace(text, ',', '.');
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  const std::string given = without_spaces_around({end, static_cast<const char*>(text.data() + text.size())});
  const auto step = can::decimal_step(given.empty() ? unit : given, unit);
  return step ? std::optional(step->to_ours(value)) : std::nullopt;
}

std::string refusal_of_number(const std::string& text, const std::string& unit) {
  if (has_ambiguous_comma(text))
    return fmt::format(
        "'{}' has a comma before three digits; write a decimal point, or thousands without a comma", text);
  return fmt::format("'{}', expected a number{}", text, unit.empty() ? "" : " in " + unit);
}

template <class T>
std::optional<std::string> objection(const Questions::Check<T>& check, const T& value) {
  return check ? check(value) : std::nullopt;
}

template <class T>
void require(const Question& question, const Questions::Check<T>& check, const T& stated) {
  if (const auto problem = objection(check, stated)) throw Error(question.option, *problem);
}

}  // namespace

std::optional<std::string> Questions::answer(const Question& question, const std::string& usual) {
  if (!asks_) return std::nullopt;
  if (next_ < accepted_.size()) return accepted_[next_];
  note("{}{}: {}\n  {}{}: ", question.what, question.unit.empty() ? "" : ", " + question.unit, question.why,
       question.option, usual.empty() ? "" : " [" + usual + "]");
  std::string line;
  if (!std::getline(in_, line))
    throw RunError(
        fmt::format("the input ended before an answer to {}; nothing is written", question.option));
  line = without_spaces_around(line);
  if (line != "<") return line;
  if (!accepted_.empty()) accepted_.pop_back();
  throw StepBack();
}

void Questions::begin() {
  next_ = 0;
  asked_ = 0;
  missing_.clear();
}

void Questions::accept(const std::string& line) {
  if (next_ == accepted_.size()) accepted_.push_back(line);
  ++next_;
}

void Questions::object(const std::string& problem) {
  accepted_.resize(next_);
  note("  {}\n", problem);
}

double Questions::number(const Question& question, const std::optional<double>& stated,
                         const std::optional<double>& usual, const Check<double>& check) {
  if (stated) {
    require(question, check, *stated);
    return *stated;
  }
  if (asks_) ++asked_;
  while (const auto line = answer(question, usual ? fmt::format("{}", *usual) : "")) {
    const std::optional<double> value = line->empty() ? usual : parsed(*line, question.unit);
    const auto problem =
        value ? objection(check, *value) : std::optional(refusal_of_number(*line, question.unit));
    if (!problem) {
      accept(*line);
      return *value;
    }
    object(*problem);
  }
  if (!usual) missing_.push_back(question.option);
  return usual.value_or(std::numeric_limits<double>::quiet_NaN());
}

std::string Questions::text(const Question& question, const std::optional<std::string>& stated,
                            const std::optional<std::string>& usual, const Check<std::string>& check) {
  if (stated) {
    require(question, check, *stated);
    return *stated;
  }
  if (asks_) ++asked_;
  while (const auto line = answer(question, usual.value_or(""))) {
    std::string value = line->empty() ? usual.value_or("") : *line;
    const auto problem =
        value.empty() ? std::optional<std::string>("an answer is required") : objection(check, value);
    if (!problem) {
      accept(*line);
      return value;
    }
    object(*problem);
  }
  if (!usual) missing_.push_back(question.option);
  return usual.value_or("");
}

void Questions::require_all() const {
  if (missing_.empty()) return;
  const std::string options = fmt::format("{}", fmt::join(missing_, ", "));
  throw Error(missing_.size() == 1 ? fmt::format("{} is missing and has no default", options)
                                   : fmt::format("{} are missing and have no default", options),
              {.remedy = "state the missing values, or run `hystcan init` on a terminal without --yes"});
}

}  // namespace hystcan::app
