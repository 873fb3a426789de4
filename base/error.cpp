#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/system/system_error.hpp>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace hystcan {
namespace {

template <class Error>
const Error* as(const std::exception& error) {
  return dynamic_cast<const Error*>(&error);
}

std::string without_controls(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20; }, ' ');
  return text;
}

}  // namespace

PlacedError::PlacedError(std::string what, Advice advice, Place place)
    : std::runtime_error(""), place_(std::move(place)), what_(std::move(what)), advice_(std::move(advice)) {
  form();
}

std::string PlacedError::finding() const {
  std::string text = place_.name;
  for (const std::size_t number : {place_.line, place_.column})
    if (number > 0) text += fmt::format(":{}", number);
  if (!text.empty()) text += ": ";
  text += what_;
  if (!advice_.expected.empty()) text += ", expected " + advice_.expected;
  return without_controls(std::move(text));
}

void PlacedError::form() {
  std::string text = finding();
  if (!advice_.remedy.empty()) text += "; " + without_controls(advice_.remedy);
  std::runtime_error::operator=(std::runtime_error(text));
}

void PlacedError::rename_folder(const std::string& from, const std::string& to) {
  if (place_.name == from || place_.name.starts_with(from + "/")) place_.name.replace(0, from.size(), to);
  form();
}

void PlacedError::add_sentence(const std::string& sentence) {
  std::string& last = advice_.expected.empty() ? what_ : advice_.expected;
  (advice_.remedy.empty() ? last : advice_.remedy) += ". " + sentence;
  form();
}

std::string error_text(const std::exception& error) {
  if (const auto* file = as<std::filesystem::filesystem_error>(error))
    return fmt::format("{}: {}", file->path1().empty() ? "a file without a name" : file->path1().string(),
                       file->code().message());
  if (const auto* system = as<boost::system::system_error>(error)) return system->code().message();
  if (const auto* system = as<std::system_error>(error);  // std::thread throws this error
      system != nullptr && system->code() == std::errc::resource_unavailable_try_again)
    return "cannot start another thread: raise the limit of processes (ulimit -u)";
  if (as<std::bad_alloc>(error) != nullptr || as<std::length_error>(error) != nullptr)
    return "out of memory: the input is too large";
  if (as<nlohmann::json::exception>(error) != nullptr)
    return "invalid JSON, expected JSON as hystcan writes it";
  if (as<std::logic_error>(error) != nullptr && as<std::invalid_argument>(error) == nullptr)
    return fmt::format("a defect in hystcan ({}): please report it", error.what());
  return error.what();
}

}  // namespace hystcan
