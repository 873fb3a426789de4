// `hystcan init` on unknown stages (any_stage.h), from their own records: the promised errors of its loops,
// and the errors on the stage itself in place of the twin. The sensor delay is stated for every second stage.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "tests/app/command_line/any_stage.h"
#include "tests/app/command_line/cli.h"

namespace hystcan::any_stage_test {
namespace {

/// A loop proposed by `init`, with its true error in um.
struct Promised {
  std::string of;
  double promised = 0.0, least = 0.0, most = 0.0;
  Errors came;

  bool is_kept() const { return !came.faulted && least <= came.true_um && came.true_um <= most; }
  double width() const { return most / least; }
  double miss() const {
    return came.faulted ? std::numeric_limits<double>::infinity()
                        : std::max(came.true_um / promised, promised / came.true_um);
  }
};

/// Returns the promises in a text, in order.
std::vector<Promised> promised(const std::string& text) {
  static const std::regex line(
      R"(promise x: ([0-9.e+-]+) um RMS true \(90 %: ([0-9.e+-]+) to ([0-9.e+-]+)\), [0-9.e+-]+ % of stroke; )");
  std::vector<Promised> rows;
  for (std::sregex_iterator found(text.begin(), text.end(), line), end; found != end; ++found)
    rows.push_back({.of = {},
                    .promised = std::stod((*found)[1]),
                    .least = std::stod((*found)[2]),
                    .most = std::stod((*found)[3]),
                    .came = {}});
  return rows;
}

constexpr double least_kept = 0.66, widest_median = 2.5;  // for a small number of stages

class AnyNewStage : public Cli {
 protected:
  Process run(std::vector<std::string> words) const {
    words.insert(words.begin(), HYSTCAN_PROGRAM);
    return Process(words);
  }
  void excite(const char* output, std::vector<std::string> more) const {
    more.insert(more.begin(), {"excite", path("any.toml"), "--rehearse", "--output", path(output)});
    Process excited = run(more);
    ASSERT_EQ(excited.wait(), done) << excited.err();
  }

  /// Runs the cautious loop, and the fast one if it exists, on the stage itself. Empty: the stage was
  /// refused.
  std::vector<Promised> rows(unsigned seed) const {
    Draw draw(seed);
    const Stage stage = drawn(draw);
    for (const char* made : {"loops.csv", "step.csv", "stage"}) std::filesystem::remove_all(shipped / made);
    config::TomlEdit edit = config::TomlEdit::of_file(shipped / "soft_stage.toml");
    edit.set("axis[0].twin.model", "\"any.plant.toml\"");
    edit.set("axis[0].control.position_min_um", "-40.0");  // the memory of the first run is unknown
    write("any.plant.toml", hysteresis(seed, draw));
    write("any.toml", configured(std::move(edit), stage, draw));
    excite("loops.csv", {});
    excite("step.csv", {"--signal", "step"});
    std::vector<std::string> words{"init",         path("stage"),
                                   "--record",     path("loops.csv"),
                                   "--step",       path("step.csv"),
                                   "--resonance",  std::to_string(stage.mode_Hz * draw.off()),
                                   "--drive-min",  "-20",
                                   "--drive-max",  "120",
                                   "--safe",       "0",
                                   "--cycle-rate", std::to_string(stage.rate_Hz),
                                   "--yes"};
    if (seed / 3 % 2 == 0)
      words.insert(words.end(), {"--sensor-delay", std::to_string(stage.sensor_delay_us)});
    Process init = run(words);
    const int ended = init.wait();
    if (std::getenv("HYSTCAN_STAGE") != nullptr) std::printf("%s", init.out().c_str());
    EXPECT_EQ(ended, done) << stage.text() << "\n" << init.err() << init.out();
    const twin::Config itself = config::twin_config(config::load(shipped / "any.toml"));
    std::vector<Promised> all = promised(init.out());
    if (ended != done) all.clear();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const char* file = i == 0 ? "stage/stage.toml" : "stage/stage.fast.toml";
      all[i].of = stage.text() + (i == 0 ? "" : ", fast");
      all[i].came = errors_of(config::load(shipped / file), itself);
    }
    return all;
  }
};

TEST_F(AnyNewStage, IsCompleteFromItsRecordsAndKeepsItsPromise) {
  const auto [first, last] = seeds(3);
  std::vector<Promised> all;
  std::size_t refused = 0;
  for (unsigned seed = first; seed <= last; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<Promised> of_stage = rows(seed);
    refused += of_stage.empty() ? 1 : 0;
    all.insert(all.end(), of_stage.begin(), of_stage.end());
  }
  ASSERT_FALSE(all.empty());
  std::vector<double> widths, misses;
  for (const Promised& row : all) {
    widths.push_back(row.width());
    misses.push_back(row.miss());
  }
  print_shares("width of the interval", widths);
  print_shares("true error and the promised one", misses);
  const auto kept = std::ranges::count_if(all, &Promised::is_kept);
  std::printf("refused %zu of %u; %td of %zu promises kept; the ten that miss most:\n", refused,
              last - first + 1, kept, all.size());
  std::ranges::sort(all, std::greater{}, &Promised::miss);
  for (std::size_t i = 0; i < std::min<std::size_t>(10, all.size()); ++i)
    std::printf("  %.2f  %s: true error %.4f um, promised %.4f (%.4f to %.4f)\n", all[i].miss(),
                all[i].of.c_str(), all[i].came.true_um, all[i].promised, all[i].least, all[i].most);
  EXPECT_GE(static_cast<double>(kept), least_kept * static_cast<double>(all.size()));
  std::ranges::sort(widths);
  EXPECT_LE(widths[widths.size() / 2], widest_median);
}

}  // namespace
}  // namespace hystcan::any_stage_test
