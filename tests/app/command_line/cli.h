// Runs the program in a temporary folder with a copy of the shipped configuration.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "base/error.h"
#include "tests/support/process.h"
#include "tests/support/shipped.h"

namespace hystcan {

using support::Process;

class Cli : public testing::Test {
 protected:
  std::string path(const char* name) const { return (shipped / name).string(); }
  void write(const char* name, const std::string& text) const { std::ofstream(shipped / name) << text; }
  std::string read(const char* name) const { return support::read_file(shipped / name); }

  support::ShippedCopy shipped;
};

}  // namespace hystcan
