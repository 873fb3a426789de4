// What a user reads of an exception.
#pragma once

#include <exception>
#include <string>

namespace hystcan::app {

/// What the project's own exceptions say. For those of a library: a plain sentence instead of its words.
std::string error_text(const std::exception& error);

}  // namespace hystcan::app
