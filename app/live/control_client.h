// A client of the control socket, for `hystcan ctl`.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

namespace hystcan::app {

/// Sends one command and returns its answer. Throws std::system_error if the socket cannot be used, if it
/// closes, if the answer does not come within `limit` (ETIMEDOUT), or if it is no JSON object (EBADMSG) or
/// longer than 1 MiB (EMSGSIZE). Without a limit it waits as long as the connection is open.
nlohmann::json ask_socket(const std::filesystem::path& file, const nlohmann::json& command,
                          std::optional<std::chrono::milliseconds> limit);

}  // namespace hystcan::app
