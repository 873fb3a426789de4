// What follows after attributes have given messages, signals and nodes their long names.
#include <map>
#include <set>
#include <string_view>

#include "can/dbc/reader.h"

namespace hystcan::can::dbc {
namespace {

using Blocks = std::vector<const MessageBlock*>;

/// Senders and receivers are names of nodes.
void name_nodes(Database& database, const Blocks& blocks, Copies& copies) {
  std::map<std::string_view, const std::string*> names;
  for (const Node& node : database.nodes) {
    if (!node.short_name.empty()) names.emplace(node.short_name, &node.name);
  }
  if (names.empty()) return;
  const auto replace = [&](std::string& name, Token at) {
    const auto found = names.find(name);
    if (found == names.end()) return;
    copies.take(at, found->second->size());
    name = *found->second;
  };
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    Message& message = database.messages[i];
    replace(message.sender, blocks[i]->name);
    for (Signal& signal : message.signals) {
      for (std::string& receiver : signal.receivers) replace(receiver, blocks[i]->name);
    }
  }
}

void note_repeated_signals(const Message& message, const MessageBlock& block, Warnings& warnings) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < message.signals.size(); ++i) {
    const Signal& signal = message.signals[i];
    const bool is_new = names.insert(signal.name).second;
    if (is_new || signal.short_name.empty() || signal.multiplexing.present_at) continue;
    warnings.add(block.signals[i].name, "signal " + signal.name + " occurs a second time in message " +
                                            message.name + ": both are kept");
  }
}

}  // namespace

void finish_long_names(Database& database, const Blocks& blocks, Warnings& warnings, Copies& copies) {
  name_nodes(database, blocks, copies);
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Message& message = database.messages[i];
    if (!names.insert(message.name).second && !message.short_name.empty()) {
      warnings.add(blocks[i]->name,
                   "message " + message.name + " occurs a second time: its name finds the first");
    }
    note_repeated_signals(message, *blocks[i], warnings);
  }
}

}  // namespace hystcan::can::dbc
