// `hystcan identify`, `hystcan validate` and `hystcan init` with damaged records.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "identification/dataset.h"
#include "model/hysteresis.h"
#include "tests/app/command_line/cli.h"
#include "tests/identification/made_record.h"
#include "tests/support/piezo.h"

namespace hystcan::spoilt_record_test {
namespace {

using identification::Dataset;
using nlohmann::json;

class SpoiltRecord : public Cli {
 protected:
  static Dataset clean() {
    return identification::with_noise(
        identification::record_of(model::Hysteresis(support::piezo_model()), 30.0), 3e-4, 1);
  }
  void write_record(const char* name, const Dataset& record) const {
    std::ostringstream text;
    text.precision(17);
    text << "time_s,input,output\n";
    for (std::size_t i = 0; i < record.size(); ++i)
      text << record.time_s[i] << ',' << record.input[i] << ',' << record.output[i] << '\n';
    write(name, text.str());
  }
  int run(std::vector<std::string> words) {
    words.insert(words.begin(), HYSTCAN_PROGRAM);
    Process process(words);
    const int status = process.wait();
    out = process.out();
    err = process.err();
    return status;
  }
  json identified(std::vector<std::string> words) {
    words.insert(words.begin(), "identify");
    words.insert(words.end(), {"--output", path("found.toml"), "--overwrite", "--json"});
    EXPECT_EQ(run(words), done) << err;
    return json::parse(out);
  }
  int init(const char* record, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"init",        path("stage"), "--record", path(record),
                                   "--resonance", "500",         "--yes"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }

  std::string out, err;
};

TEST_F(SpoiltRecord, IsIdentifiedWithoutItsReportedDropOuts) {
  Dataset record = clean();
  write_record("clean.csv", record);
  record.output[300] = record.output[301] = 0.0;
  record.input[500] = 130.0;
  write_record("spoilt.csv", record);
  const json of_clean = identified({path("clean.csv")}), of_spoilt = identified({path("spoilt.csv")});
  EXPECT_NEAR(of_spoilt["rms_percent"].get<double>(), of_clean["rms_percent"].get<double>(), 1e-4);
  EXPECT_NEAR(of_spoilt["input_max"].get<double>(), of_clean["input_max"].get<double>(), 1.0);
  EXPECT_EQ(of_spoilt["records"][0]["samples"], of_clean["records"][0]["samples"].get<int>() - 3);
  EXPECT_NE(of_spoilt["findings"][0].get<std::string>().find("in row 301"), std::string::npos);
  EXPECT_NE(read("found.toml").find("these rows are left out"), std::string::npos);
}

TEST_F(SpoiltRecord, IsValidatedWithoutItsReportedDropOuts) {
  Dataset record = clean();
  write_record("clean.csv", record);
  record.output[300] = record.output[301] = 0.0;
  write_record("spoilt.csv", record);
  identified({path("clean.csv")});
  EXPECT_EQ(run({"validate", path("found.toml"), path("spoilt.csv"), "--json"}), done) << err;
  const json found = json::parse(out);
  EXPECT_LT(found["max_percent"].get<double>(), 1.0);
  EXPECT_NE(found["findings"].at(0).get<std::string>().find("in row 301"), std::string::npos);
  EXPECT_EQ(run({"validate", path("found.toml"), path("spoilt.csv")}), done) << err;
  EXPECT_NE(out.find("in row 301"), std::string::npos) << out;
}

TEST_F(SpoiltRecord, IsRefusedByInitUnlessItIsAccepted) {
  Dataset record = clean();
  record.input[500] = 130.0;
  write_record("spoilt.csv", record);
  EXPECT_EQ(init("spoilt.csv"), bad_input);
  EXPECT_NE(err.find("input 130 V instead of about"), std::string::npos) << err;
  EXPECT_NE(err.find("--accept"), std::string::npos) << err;
  EXPECT_FALSE(std::filesystem::exists(shipped / "stage"));
  EXPECT_EQ(init("spoilt.csv", {"--accept"}), done) << err;
  EXPECT_NE(err.find("in row 501"), std::string::npos) << err;
  EXPECT_NE(read("stage/stage.toml").find("drive_max_V "), std::string::npos);
  EXPECT_EQ(read("stage/stage.toml").find("130"), std::string::npos);
}

TEST_F(SpoiltRecord, IsRefusedByInitIfTheSensorSaturates) {
  Dataset record = clean();
  for (double& x : record.output) x = std::min(x, 24.0);
  write_record("spoilt.csv", record);
  EXPECT_EQ(init("spoilt.csv"), bad_input);
  EXPECT_NE(err.find("the output stays at 24 um, its highest"), std::string::npos) << err;
}

TEST_F(SpoiltRecord, IsRefusedIfItIsGivenTwice) {
  write_record("monday.csv", clean());
  write_record("copy.csv", clean());
  EXPECT_EQ(run({"identify", path("monday.csv"), path("copy.csv"), "--output", path("found.toml")}),
            bad_input);
  EXPECT_NE(err.find("has the same rows as"), std::string::npos) << err;
  EXPECT_EQ(init("monday.csv", {"--unseen", path("copy.csv")}), bad_input);
  EXPECT_NE(err.find("has the same rows as"), std::string::npos) << err;
}

TEST_F(SpoiltRecord, IsNotComparedWithRecordsOfSmallerRange) {
  const model::Hysteresis truth(support::piezo_model());
  const auto record = [&](const std::vector<double>& turns, std::uint64_t seed) {
    return identification::with_noise(
        identification::record_of(truth, truth.at_lower_threshold(), identification::travelled(turns, 2.0)),
        3e-4, seed);
  };
  write_record("wide.csv", record({0.0, 100.0, 0.0, 100.0, 0.0}, 1));
  write_record("narrow.csv", record({0.0, 60.0, 0.0, 60.0, 10.0, 50.0, 0.0}, 2));
  const json found = identified({path("wide.csv"), path("narrow.csv"), "--order", "3"});
  EXPECT_TRUE(found["records"][0]["left_out_rms_percent"].is_null());
  EXPECT_GT(found["records"][1]["left_out_rms_percent"].get<double>(), 0.0);
}

}  // namespace
}  // namespace hystcan::spoilt_record_test
