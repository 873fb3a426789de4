#include "app/setup/questions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <istream>
#include <limits>

#include "app/io/exit_status.h"
#include "app/io/standard_streams.h"
#include "config/document/error.h"

namespace hystcan::app {
namespace {

std::string without_spaces_around(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::optional<double> parsed(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

template <class T>
std::string objection(const Questions::Check<T>& check, const T& value) {
  return check ? check(value) : std::string();
}

template <class T>
void require(const Question& question, const Questions::Check<T>& check, const T& stated) {
  if (const std::string wrong = objection(check, stated); !wrong.empty())
    throw config::Error(fmt::format("{}: {}", question.option, wrong));
}

}  // namespace

std::optional<std::string> Questions::answer(const Question& question, const std::string& usual) {
  if (!asks_) return std::nullopt;
  note("{}{}: {}\n  {}{}: ", question.what, question.unit.empty() ? "" : ", " + question.unit, question.why,
       question.option, usual.empty() ? "" : " [" + usual + "]");
  std::string line;
  if (!std::getline(in_, line))
    throw RunError(
        fmt::format("the input ended before an answer to {}, nothing is written", question.option));
  return without_spaces_around(line);
}

double Questions::number(const Question& question, const std::optional<double>& stated,
                         const std::optional<double>& usual, const Check<double>& check) {
  if (stated) {
    require(question, check, *stated);
    return *stated;
  }
  if (asks_) ++asked_;
  while (const auto line = answer(question, usual ? fmt::format("{}", *usual) : "")) {
    const std::optional<double> value = line->empty() ? usual : parsed(*line);
    const std::string wrong = value ? objection(check, *value)
                                    : fmt::format("'{}' is no number, expected one{}", *line,
                                                  question.unit.empty() ? "" : " in " + question.unit);
    if (wrong.empty()) return *value;
    note("  {}\n", wrong);
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
    const std::string wrong = value.empty() ? "an answer is expected" : objection(check, value);
    if (wrong.empty()) return value;
    note("  {}\n", wrong);
  }
  if (!usual) missing_.push_back(question.option);
  return usual.value_or("");
}

void Questions::require_all() const {
  if (missing_.empty()) return;
  throw config::Error(
      fmt::format("{} missing: {} no default; on a terminal, without --yes, `hystcan init` asks",
                  fmt::join(missing_, ", "), missing_.size() == 1 ? "it has" : "they have"));
}

}  // namespace hystcan::app
