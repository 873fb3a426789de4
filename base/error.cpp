#include "base/error.h"

#include <fmt/format.h>

#include <boost/system/system_error.hpp>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

namespace hystcan {
namespace {

template <class Error>
const Error* as(const std::exception& error) {
  return dynamic_cast<const Error*>(&error);
}

}  // namespace

std::string error_text(const std::exception& error) {
  if (const auto* file = as<std::filesystem::filesystem_error>(error))
    return fmt::format("{}: {}", file->path1().empty() ? "a file without a name" : file->path1().string(),
                       file->code().message());
  if (const auto* system = as<boost::system::system_error>(error)) return system->code().message();
  if (const auto* system = as<std::system_error>(error);  // of std::thread
      system != nullptr && system->code() == std::errc::resource_unavailable_try_again)
    return "no further thread can be started: raise the limit of processes (ulimit -u)";
  if (as<std::bad_alloc>(error) != nullptr || as<std::length_error>(error) != nullptr)
    return "the memory does not suffice: the input is too large";
  if (as<nlohmann::json::exception>(error) != nullptr) return "found a text that is not the expected JSON";
  if (as<std::logic_error>(error) != nullptr && as<std::invalid_argument>(error) == nullptr)
    return fmt::format("a mistake in hystcan itself ({}): please report it", error.what());
  return error.what();
}

}  // namespace hystcan
