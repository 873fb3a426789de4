// The configuration as a list of settings: changes, their effect, and single values that override the file.
#include "config/schema/settings.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "config/document/toml_edit.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::settings_test {
namespace {

const std::filesystem::path shipped = HYSTCAN_SOURCE_DIR "/config/piezo.toml";

std::string value_of(const std::vector<Setting>& settings, std::string_view path) {
  const auto found = std::ranges::find(settings, path, &Setting::path);
  return found == settings.end() ? "(none)" : found->value;
}

std::string refusal_of(const std::vector<Setting>& overrides) {
  return support::refusal_of([&] { load(shipped, overrides); });
}

TEST(Settings, HaveOneEntryForEachKeyIncludingDefaults) {
  const std::vector<Setting> all = settings(shipped);
  EXPECT_EQ(value_of(all, "axis[0].control.kp"), "0");
  EXPECT_EQ(value_of(all, "axis[1].name"), "'y'");
  EXPECT_EQ(value_of(all, "axis[0].control.setpoint[0].high_um"), "27");
  EXPECT_EQ(value_of(all, "axis[1].control.setpoint[1].levels_um"), "[25, 6, 22, 9, 19, 12, 16]");
  EXPECT_EQ(value_of(all, "axis[0].control.delays.resonance_Hz"), "500");
  EXPECT_EQ(value_of(all, "axis[0].control.start_up"), "'wipe'") << "a default";
  EXPECT_EQ(value_of(all, "axis[0].control.notch.depth"), "(none)");
  std::vector<std::string> paths;
  paths.reserve(all.size());
  for (const Setting& setting : all) paths.push_back(setting.path);
  std::ranges::sort(paths);
  EXPECT_EQ(std::ranges::adjacent_find(paths), paths.end());
}

TEST(Settings, AreEqualForTheSameFile) { EXPECT_TRUE(changes(settings(shipped), settings(shipped)).empty()); }

TEST(Changes, ListChangedNewAndRemovedKeys) {
  const std::vector<Setting> before{{"a", "1"}, {"b", "2"}, {"c", "3"}};
  const std::vector<Setting> after{{"a", "1"}, {"b", "5"}, {"d", "4"}};
  const std::vector<Change> found = changes(before, after);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(describe(found[0]), "b: 2 -> 5");
  EXPECT_EQ(describe(found[1]), "d: (none) -> 4");
  EXPECT_EQ(describe(found[2]), "c: 3 -> (none)");
}

TEST(Changes, ListTheKeysOfAnAddedSegment) {
  const support::ShippedCopy files;
  const std::vector<Setting> before = settings(files / "piezo.toml");
  files.edit("piezo.toml", "[axis.twin]",
             "[[axis.control.setpoint]]\nkind = \"hold\"\nlevel_um = 7.0\nduration_s = 1.0\n\n[axis.twin]");
  const std::vector<Change> found = changes(before, settings(files / "piezo.toml"));
  ASSERT_FALSE(found.empty());
  for (const Change& change : found) {
    EXPECT_TRUE(change.path.starts_with("axis[0].control.setpoint[2].")) << change.path;
    EXPECT_TRUE(change.from.empty());
    EXPECT_EQ(change.effect, Effect::new_reference);
  }
}

Key running_key(std::string_view path) {
  const std::vector<Key> keys = running_keys(load(shipped));
  const auto found = std::ranges::find(keys, path, &Key::path);
  return found == keys.end() ? Key{} : *found;
}

TEST(RunningKeys, HaveMeaningAndRange) {
  const Key gain = running_key("axis[0].control.kp");
  EXPECT_EQ(gain.meaning, "proportional gain");
  EXPECT_EQ(gain.range.describe(), "a number >= 0");
}

TEST(RunningKeys, HaveTheirChoices) {
  const Key structure = running_key("axis[0].control.structure");
  EXPECT_EQ(structure.choices.size(), controller::all_structures.size());
  EXPECT_EQ(running_key("axis[0].control.repeat").choices[1], "true");
}

TEST(RunningKeys, IncludeKeysOfAnAbsentTable) {
  EXPECT_FALSE(load(shipped).axes[0].control.law.notch);
  EXPECT_EQ(running_key("axis[0].control.notch.depth").range.describe(), "a number >= 0 and <= 1");
}

TEST(RunningKeys, ExcludeKeysThatNeedARestart) {
  EXPECT_EQ(running_key("axis[0].control.model").path, "");
  EXPECT_EQ(running_key("axis[0].name").path, "");
}

TEST(UnitOf, GivesTheUnitOfTheKeyInAPath) {
  EXPECT_EQ(unit_of("axis[0].control.kp"), "um/um");
  EXPECT_EQ(unit_of("axis[0].control.reference_acceleration_um_per_s2"), "um/s^2");
  EXPECT_EQ(unit_of("axis[0].control.notch.depth"), "");
}

TEST(EffectOfAKey, MatchesTheApplicationOfItsChange) {
  const std::vector<Setting> all = settings(shipped);
  for (const auto& [path, effect] : {std::pair{"axis[0].control.kp", Effect::at_once},
                                     {"axis[1].control.delays.resonance_Hz", Effect::at_once},
                                     {"axis[0].control.position_max_um", Effect::at_once},
                                     {"axis[0].control.wipe_dwell_s", Effect::at_next_start},
                                     {"axis[0].control.repeat", Effect::new_reference},
                                     {"axis[0].control.setpoint[1].levels_um", Effect::new_reference},
                                     {"axis[0].control.model", Effect::after_restart},
                                     {"axis[0].control.safe_drive_V", Effect::after_restart},
                                     {"axis[0].name", Effect::after_restart},
                                     {"axis[0].live_setpoint", Effect::after_restart},
                                     {"bus.interface", Effect::after_restart},
                                     {"controller.rate_Hz", Effect::after_restart},
                                     {"axis[0].twin.noise_um_rms", Effect::on_nodes},
                                     {"twin.seed", Effect::on_nodes}}) {
    const auto found = std::ranges::find(all, path, &Setting::path);
    ASSERT_NE(found, all.end()) << path;
    EXPECT_EQ(found->effect, effect) << path;
  }
}

TEST(PathOf, GivesThePathOfAMember) {
  const Config config = load(shipped);
  const AxisConfig& y = config.axes[1];
  EXPECT_EQ(path_of(config, y.control.law.pi.kp), "axis[1].control.kp");
  EXPECT_EQ(path_of(config, y.control.gate.drive_min), "axis[1].control.drive_min_V");
  EXPECT_EQ(path_of(config, y.control.reference_limits.slew_um_per_s),
            "axis[1].control.reference_slew_um_per_s")
      << "also if the file leaves it out";
  EXPECT_EQ(path_of(config, y.control.setpoint[1]), "axis[1].control.setpoint[1]") << "a table";
  EXPECT_EQ(path_of(y, y.twin.sensor.delay), "twin.sensor.delay_us");
  EXPECT_EQ(key_of(y, y.twin.sensor.delay), "delay_us");
}

TEST(PathOf, RefusesAMemberWithoutAKey) {
  const Config config = load(shipped);
  EXPECT_THROW(path_of(config, config.axes[0].control.law.model), std::logic_error);
}

TEST(Overrides, ReplaceTheValuesOfTheFile) {
  const Config config =
      load(shipped, {{"axis[1].control.kp", "0.25"}, {"axis[0].control.structure", "\"pi\""}});
  EXPECT_EQ(config.axes[1].control.law.pi.kp, 0.25);
  EXPECT_EQ(config.axes[0].control.law.pi.kp, 0.0);
  EXPECT_EQ(config.axes[0].control.law.structure, controller::Structure::pi);
  EXPECT_EQ(controller_config(config).axes[1].axis.law.pi.kp, 0.25) << "where the controller looks";
}

TEST(Overrides, CreateMissingTablesButNoElementsOfAList) {
  const std::string notch = "axis[0].control.notch.";
  const Config config =
      load(shipped, {{notch + "frequency_Hz", "300"}, {notch + "depth", "0.1"}, {notch + "width", "0.5"}});
  ASSERT_TRUE(config.axes[0].control.law.notch);
  EXPECT_EQ(config.axes[0].control.law.notch->frequency_Hz, 300.0);
  EXPECT_FALSE(config.axes[1].control.law.notch);

  EXPECT_NE(refusal_of({{"axis[7].control.kp", "0.1"}}).find("unknown key"), std::string::npos);
  EXPECT_NE(refusal_of({{"axis[0].control.setpoint[7].low_um", "4.0"}}).find("unknown key"),
            std::string::npos);
  EXPECT_NE(refusal_of({{"axis[0].control.setpoint[7]", "{}"}}).find("unknown key"), std::string::npos);
  EXPECT_NE(refusal_of({{"axis[0].control.kp.a", "1"}}).find("unknown key"), std::string::npos)
      << "a number has no keys";
}

TEST(Overrides, RefuseAValueThatIsNotToml) {
  for (const char* value : {"", "0.1 0.2", "pi", "[", "1\nki_per_s = 2", "\"open", "0.1 # c\nx = 1"}) {
    const std::string refusal = refusal_of({{"axis[0].control.kp", value}});
    EXPECT_NE(refusal, "accepted") << value;
    EXPECT_NE(refusal.find("axis[0].control.kp"), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
  }
}

TEST(Overrides, RefuseUnknownKeysAndValuesOutOfRange) {
  EXPECT_TRUE(refusal_of({{"axis[0].control.kpp", "0.1"}})
                  .starts_with("axis[0].control.kpp: unknown key kpp (did you mean kp?), expected one of "));
  EXPECT_EQ(refusal_of({{"axis[0].control.kp", "-0.1"}}),
            "axis[0].control.kp: kp is -0.1, expected a number >= 0");
  EXPECT_EQ(refusal_of({{"axis[0].control.kp", "\"high\""}}),
            "axis[0].control.kp: kp is of type string, expected a number >= 0");
  EXPECT_TRUE(refusal_of({{"axis[0].control.in_position", "{tolerance_um = -1.0}"}})
                  .starts_with("axis[0].control.in_position: tolerance_um is -1"));
  EXPECT_NE(refusal_of({{"axis[0].control.kp", "nan"}}).find("expected a"), std::string::npos);
  EXPECT_NE(refusal_of({{"axis[0].control.drive_max_V", "50.0"}}), "accepted")
      << "checks between keys hold too";
}

TEST(FileText, ReadsBackAsTheSameConfiguration) {
  for (const char* name :
       {"piezo", "galfenol", "galfenol_unimorph", "soft_stage", "p733", "lab_amplifier", "raster"}) {
    const auto file = std::filesystem::path(HYSTCAN_SOURCE_DIR "/config") / (std::string(name) + ".toml");
    const Config config = load(file);
    const Config again = load_text(file, file_text(config, {{"controller.rate_Hz", "a comment"}}));
    for (const Change& change : changes(settings(config), settings(again)))
      ADD_FAILURE() << name << ": " << describe(change);
  }
}

TEST(Echo, MarksKeysThatTheFileLeavesOutButNoTables) {
  const std::string text = echo(shipped);
  EXPECT_NE(text.find("start_timeout_s = 5  # default\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n[record]\n"), std::string::npos) << text;
}

/// Returns the text of the shipped file after `change` was applied to the configuration.
template <class Change>
std::string edited(const Change& change) {
  const Config before = load(shipped);
  Config after = before;
  change(after.axes[0].control);
  TomlEdit text = TomlEdit::of_file(shipped);
  edit(text, before, after);
  return text.text();
}

TEST(Edit, KeepsTheTextWithoutAChange) {
  EXPECT_EQ(edited([](const auto&) {}), TomlEdit::of_file(shipped).text());
}

TEST(Edit, ReplacesTheValueThatChanged) {
  const std::string text = edited([](controller::AxisConfig& axis) { axis.law.pi.ki_per_s = 120.0; });
  const auto changed = load_text(shipped, text);
  EXPECT_EQ(changed.axes[0].control.law.pi.ki_per_s, 120.0);
  EXPECT_EQ(changes(settings(load(shipped)), settings(changed)).size(), 1u);
}

TEST(Edit, CommentsOutARemovedTable) {
  const std::string text = edited([](controller::AxisConfig& axis) { axis.in_position.reset(); });
  EXPECT_NE(text.find("\n# [axis.control.in_position]"), std::string::npos) << text;
  EXPECT_FALSE(load_text(shipped, text).axes[0].control.in_position);
}

}  // namespace
}  // namespace hystcan::config::settings_test
