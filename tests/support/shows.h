// Records which promises of the documents (S-012, ...) a test verifies. tests/support/main.cpp prints these
// numbers at the end of the test, with its result; scripts/evidence reads the lines from the log.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace hystcan {

/// Call once at the beginning of a test that passes only if these promises hold. `promises`: "S-012", "S-012,
/// S-034".
inline void shows(const std::string& promises) { testing::Test::RecordProperty("shows", promises); }

}  // namespace hystcan
