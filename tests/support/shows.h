// The promises of the documents that a test shows. tests/support/main.cpp prints them at the end of the test,
// with the verdict; scripts/evidence reads them from the log.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace hystcan {

/// Call once at the beginning of a test that passes only if these promises hold. `promises`: "S-012", "S-012,
/// S-034".
inline void shows(const std::string& promises) { testing::Test::RecordProperty("shows", promises); }

}  // namespace hystcan
