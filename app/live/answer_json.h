// Converts the answer structs of app/live/control_answers.h to JSON objects and back, by means of their
// `visit` functions. NaN becomes null. If an object has additional members, for example from a newer program,
// they are ignored.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "app/live/control_answers.h"
#include "base/error.h"
#include "base/words.h"

namespace hystcan::app {

template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

/// True for a type that is converted to JSON directly, for example a number or a text. False for a struct
/// with a `visit`, a list or an optional.
template <class T>
inline constexpr bool is_value =
    std::is_arithmetic_v<T> || HasWords<T> || std::is_same_v<T, std::string> ||
    std::is_same_v<T, std::filesystem::path> || std::is_same_v<T, std::map<std::string, std::string>>;

template <class T>
nlohmann::json as_json(T value);

class AnswerWriter {
 public:
  template <class T>
  void member(const char* name, T& value, About) {
    object[name] = as_json(value);
  }
  template <class T>
  void optional(const char* name, T& value, bool is_there, About about) {
    if (is_there) member(name, value, about);
  }

  nlohmann::json object = nlohmann::json::object();
};

/// Converts `value` to JSON. T is a struct with a `visit`, a list, or a single value.
template <class T>
nlohmann::json as_json(T value) {
  if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return value.string();
  } else if constexpr (HasWords<T>) {
    return word_of(value);
  } else if constexpr (is_value<T>) {
    return value;
  } else if constexpr (is_optional<T>) {
    return as_json(*value);
  } else if constexpr (is_list<T>) {
    nlohmann::json list = nlohmann::json::array();
    for (auto& element : value) list.push_back(as_json(element));
    return list;
  } else {
    AnswerWriter writer;
    visit(writer, value);
    return std::move(writer.object);
  }
}

/// Reads `to` from JSON. If the type is wrong, throws RunError with `place` (the path of the value) and the
/// expected type.
template <class T>
void read_value(const nlohmann::json& from, T& to, const std::string& place);

class AnswerReader {
 public:
  AnswerReader(const nlohmann::json& object, std::string place) : object_(object), place_(std::move(place)) {}

  template <class T>
  void member(const char* name, T& value, About) {
    const auto found = object_.find(name);
    if (found == object_.end())
      throw RunError(fmt::format(
          "the answer has no \"{}{}\"; the sender must have the same version of hystcan", place_, name));
    read_value(*found, value, place_ + name);
  }
  template <class T>
  void optional(const char* name, T& value, bool, About about) {
    if (object_.contains(name)) member(name, value, about);
  }

 private:
  const nlohmann::json& object_;
  std::string place_;  ///< path of the object that is being read, for example "axes[0]."
};

template <class T>
void read_value(const nlohmann::json& from, T& to, const std::string& place) {
  const auto require = [&](bool is_right, const char* expected) {
    if (!is_right)
      throw RunError(fmt::format("\"{}\" of the answer is {}, expected {}", place,
                                 from.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace),
                                 expected));
  };
  if constexpr (std::is_same_v<T, bool>) {
    require(from.is_boolean(), "true or false");
    to = from.get<bool>();
  } else if constexpr (std::is_integral_v<T>) {
    require(from.is_number_unsigned(), "a count");
    to = from.get<T>();
  } else if constexpr (std::is_floating_point_v<T>) {
    require(from.is_number() || from.is_null(), "a number");
    to = from.is_null() ? std::numeric_limits<T>::quiet_NaN() : from.get<T>();
  } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>) {
    require(from.is_string(), "a text");
    to = from.get<std::string>();
  } else if constexpr (HasWords<T>) {
    const auto word = from.is_string() ? parse_word<T>(from.get<std::string>()) : std::nullopt;
    require(word.has_value(),
            "one of the words that this version of hystcan has for this value; "
            "the sender must have the same version");
    to = *word;
  } else if constexpr (is_optional<T>) {
    read_value(from, to.emplace(), place);
  } else if constexpr (is_list<T>) {
    require(from.is_array(), "a list");
    to.resize(from.size());
    for (std::size_t i = 0; i < to.size(); ++i) read_value(from[i], to[i], fmt::format("{}[{}]", place, i));
  } else if constexpr (std::is_same_v<T, std::map<std::string, std::string>>) {
    require(from.is_object(), "an object");
    for (const auto& [key, value] : from.items())
      read_value(value, to[key], fmt::format("{}.{}", place, key));
  } else {
    require(from.is_object(), "an object");
    AnswerReader reader(from, place.empty() ? "" : place + ".");
    visit(reader, to);
  }
}

/// Returns {"ok": true, ...} with the members of `answer`, or {"ok": false, ...} if `answer` is a
/// RefusedAnswer.
template <class T>
nlohmann::json answer_json(T answer) {
  nlohmann::json object = as_json(std::move(answer));
  object["ok"] = !std::is_same_v<T, RefusedAnswer>;
  return object;
}

/// Returns true if the answer contains "ok": true, so the command was executed.
inline bool is_done(const nlohmann::json& answer) {
  const auto ok = answer.find("ok");
  return ok != answer.end() && *ok == true;
}

/// Converts a JSON object to the struct T. Throws RunError if a member is missing or has the wrong type.
template <class T>
T read_object(const nlohmann::json& object) {
  T read{};
  read_value(object, read, "");
  return read;
}

/// Converts the answer to a command to the struct T. If the answer is a refusal ("ok": false), throws
/// RunError with its reason; otherwise throws under the same conditions as read_object().
template <class T>
T read_answer(const nlohmann::json& answer) {
  if (!is_done(answer)) throw RunError(read_object<RefusedAnswer>(answer).error);
  return read_object<T>(answer);
}

}  // namespace hystcan::app
