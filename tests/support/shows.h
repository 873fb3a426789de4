// Which promises of the documents a test shows. tests/support/main.cpp says it at the end of the test,
// with the verdict; scripts/evidence reads that from the log.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace hystcan {

/// At the begin of a test, once: it passes only if these promises hold. `promises`: "S-012", "S-012, S-034".
inline void shows(const std::string& promises) { testing::Test::RecordProperty("shows", promises); }

}  // namespace hystcan
