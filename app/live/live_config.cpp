#include "app/live/live_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace hystcan::app {
namespace {

using controller::AxisTuning;
using controller::Request;

constexpr std::size_t longest_key = 200;
constexpr std::size_t most_undone = 100;

/// Returns the error text for a file with other axes than the running controller. The text names each missing
/// and each new axis, because a list of all changed keys would be less clear.
std::string difference(const config::Config& config, const std::vector<std::string>& in_force) {
  const std::vector<std::string> in_file = config::axis_names(config);
  std::vector<std::string> texts;
  for (const std::string& name : in_force)
    if (std::ranges::find(in_file, name) == in_file.end())
      texts.push_back(fmt::format("axis {} is missing", name));
  for (const std::string& name : in_file)
    if (std::ranges::find(in_force, name) == in_force.end())
      texts.push_back(fmt::format("axis {} is new", name));
  return fmt::format("nothing was changed; a restart is needed: {}", fmt::join(texts, "; "));
}

}  // namespace

LiveConfig::LiveConfig(std::filesystem::path file, const config::Config& config, config::ReadFiles files)
    : file_(std::move(file)),
      files_(std::move(files)),
      names_(config::axis_names(config)),
      settings_(settings_of_file()) {}

std::size_t LiveConfig::axis_index(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end())
    throw Error(fmt::format("there is no axis \"{}\"", name), expect("{}", fmt::join(names_, ", ")));
  return static_cast<std::size_t>(found - names_.begin());
}

LiveConfig::Prepared LiveConfig::reread() const { return prepare({{}}); }

LiveConfig::Prepared LiveConfig::with(std::string_view axis, std::string_view key,
                                      const std::string& toml_value) const {
  if (key.size() > longest_key)
    throw Error(fmt::format("the key has {} characters", key.size()), expect("at most {}", longest_key));
  History history = history_;
  std::vector<config::Setting>& overrides = history.emplace_back(history_.back());
  const std::string path = fmt::format("axis[{}].{}.{}", axis_index(axis), config::control_key, key);
  std::erase_if(overrides,
                [&](const config::Setting& setting) { return config::is_within(setting.path, path); });
  overrides.push_back({path, toml_value});
  Prepared prepared = prepare(std::move(history));
  // If the setting already has this value, nothing changes. The history of `set` commands must then not
  // become longer, because an `undo` of this command would have no effect. The last element is removed, and
  // the new element takes its place.
  if (prepared.at_once.empty()) prepared.history.erase(prepared.history.end() - 2);
  return prepared;
}

LiveConfig::Prepared LiveConfig::without_the_last() const {
  if (history_.size() == 1)
    throw Error(
        "there is no set command to undo; a reload of the configuration file clears the list of set "
        "commands");
  return prepare({history_.begin(), history_.end() - 1});
}

LiveConfig::Prepared LiveConfig::prepare(History history) const {
  const config::Config config = config::load(file_, history.back(), files_);
  if (config.axes.size() != names_.size()) throw Error(difference(config, names_));
  Prepared prepared;
  prepared.settings = config::settings(file_, history.back(), files_);
  prepared.history = std::move(history);
  for (config::Change& change : config::changes(settings_, prepared.settings))
    if (change.effect == config::Effect::after_restart)
      prepared.after_restart.push_back(std::move(change));
    else if (config::is_taken_over(change.effect))
      prepared.at_once.push_back(std::move(change));
  if (!prepared.after_restart.empty()) return prepared;
  const Concerned concerned = concerned_by(prepared.at_once);
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

LiveConfig::Concerned LiveConfig::concerned_by(const std::vector<config::Change>& changes) const {
  Concerned concerned = uncertain_;
  for (const config::Change& change : changes)
    concerned[std::stoul(change.path.substr(change.path.find('[') + 1))] |=
        change.effect == config::Effect::new_reference;
  return concerned;
}

void LiveConfig::accept(const Prepared& prepared) {
  settings_ = prepared.settings;
  history_ = prepared.history;
  if (history_.size() > most_undone + 1) history_.erase(history_.begin());
  uncertain_.clear();
}

void LiveConfig::mark_uncertain(const Prepared& prepared) { uncertain_ = concerned_by(prepared.at_once); }

}  // namespace hystcan::app
