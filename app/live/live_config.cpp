#include "app/live/live_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hystcan::app {
namespace {

using config::Effect;
using controller::AxisTuning;
using controller::Request;

constexpr std::size_t longest_key = 200;
constexpr std::size_t most_undone = 100;

/// True if a change of this key needs a new trajectory. Without one the reference goes on unchanged.
bool concerns_reference(const std::string& path) {
  return path.find(".setpoint[") != std::string::npos || path.ends_with(".repeat") ||
         path.find(".reference_") != std::string::npos;
}

/// True for the path itself and for the keys of its table or list.
bool is_within(const std::string& key, const std::string& path) {
  return key.starts_with(path) &&
         (key.size() == path.size() || key[path.size()] == '.' || key[path.size()] == '[');
}

/// Of a file with other axes than those in force; their keys one by one say less.
std::string difference(const config::Config& config, const std::vector<std::string>& in_force) {
  const std::vector<std::string> in_file = config::axis_names(config);
  std::vector<std::string> texts;
  for (const std::string& name : in_force)
    if (std::ranges::find(in_file, name) == in_file.end())
      texts.push_back(fmt::format("axis {} is missing", name));
  for (const std::string& name : in_file)
    if (std::ranges::find(in_force, name) == in_force.end())
      texts.push_back(fmt::format("axis {} is new", name));
  return fmt::format("needs a restart, nothing was changed: {}", fmt::join(texts, "; "));
}

std::size_t axis_of(const std::string& path) {
  return static_cast<std::size_t>(std::stoul(path.substr(path.find('[') + 1)));
}

}  // namespace

LiveConfig::LiveConfig(std::filesystem::path file, const config::Config& config)
    : file_(std::move(file)), names_(config::axis_names(config)), settings_(config::settings(file_)) {}

std::size_t LiveConfig::axis_index(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end())
    throw Error(fmt::format("there is no axis \"{}\", expected {}", name, fmt::join(names_, ", ")));
  return static_cast<std::size_t>(found - names_.begin());
}

LiveConfig::Prepared LiveConfig::reread() const { return prepare({}, {}); }

LiveConfig::Prepared LiveConfig::with(std::string_view axis, std::string_view key,
                                      const std::string& toml_value) const {
  if (key.size() > longest_key)
    throw Error(fmt::format("the key has {} characters, expected at most {}", key.size(), longest_key));
  std::vector<config::Setting> overrides = overrides_;
  const std::string path = fmt::format("axis[{}].control.{}", axis_index(axis), key);
  std::erase_if(overrides, [&](const config::Setting& setting) { return is_within(setting.path, path); });
  overrides.push_back({path, toml_value});
  std::vector<Overrides> earlier = earlier_;
  if (earlier.size() == most_undone) earlier.erase(earlier.begin());
  earlier.push_back(overrides_);
  Prepared prepared = prepare(std::move(overrides), std::move(earlier));
  if (prepared.at_once.empty()) prepared.earlier = earlier_;  // it is so already
  return prepared;
}

LiveConfig::Prepared LiveConfig::without_the_last() const {
  if (earlier_.empty()) throw Error("there is no setting to take back since the file was read");
  std::vector<Overrides> earlier = earlier_;
  Overrides overrides = std::move(earlier.back());
  earlier.pop_back();
  return prepare(std::move(overrides), std::move(earlier));
}

LiveConfig::Prepared LiveConfig::prepare(Overrides overrides, std::vector<Overrides> earlier) const {
  const config::Config config = config::load(file_, overrides);
  if (config.axes.size() != names_.size()) throw Error(difference(config, names_));
  std::vector<config::Setting> settings = config::settings(file_, overrides);
  Prepared prepared{.settings = std::move(settings),
                    .overrides = std::move(overrides),
                    .earlier = std::move(earlier),
                    .at_once = {},
                    .after_restart = {},
                    .requests = {}};
  std::map<std::size_t, bool> concerned = uncertain_;  // axes, and whether their reference changes too
  for (config::Change& change : config::changes(settings_, prepared.settings)) {
    const Effect effect = config::effect_of(change.path);
    if (effect == Effect::after_restart) {
      prepared.after_restart.push_back(std::move(change));
    } else if (effect == Effect::at_once) {
      concerned[axis_of(change.path)] |= concerns_reference(change.path);
      prepared.at_once.push_back(std::move(change));
    }
  }
  if (!prepared.after_restart.empty()) return prepared;
  prepared.requests.reserve(concerned.size());
  for (const auto& [axis, new_reference] : concerned) {
    auto request = std::make_unique<Request>();
    request->kind = Request::Kind::retune;
    request->axis = axis;
    request->tuning = std::make_unique<AxisTuning>(config.axes[axis].control, new_reference);
    prepared.requests.push_back(std::move(request));
  }
  return prepared;
}

void LiveConfig::accept(const Prepared& prepared) {
  settings_ = prepared.settings;
  overrides_ = prepared.overrides;
  earlier_ = prepared.earlier;
  uncertain_.clear();
}

void LiveConfig::mark_uncertain(const Prepared& prepared) {
  for (const config::Change& change : prepared.at_once)
    uncertain_[axis_of(change.path)] |= concerns_reference(change.path);
}

}  // namespace hystcan::app
