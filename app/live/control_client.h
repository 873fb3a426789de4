// A client of the control socket, for `hystcan ctl`.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

namespace hystcan::app {

/// Sends one command to the socket `file` and returns its answer. Throws std::system_error if the socket
/// cannot be used or is closed, if no answer arrives within `limit` (ETIMEDOUT), if the answer is not a JSON
/// object (EBADMSG), or if the answer is longer than 1 MiB (EMSGSIZE). Without a limit, waits until the
/// server answers or closes the connection.
nlohmann::json ask_socket(const std::filesystem::path& file, const nlohmann::json& command,
                          std::optional<std::chrono::milliseconds> limit);

}  // namespace hystcan::app
