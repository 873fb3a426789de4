// The rows of a CSV written by `simulate`.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace hystcan {

struct Row {
  double time_s, input, output;
};

inline std::vector<Row> rows_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "time_s,input,output");
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    Row row{};
    EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", &row.time_s, &row.input, &row.output), 3) << line;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace hystcan
