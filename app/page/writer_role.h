// The writer's role, what the pages change with it at the controller, and the settings in force as far as
// they are known here.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/page/control_link.h"
#include "app/page/page_clients.h"
#include "app/page/page_events.h"

namespace hystcan::app {

class WriterRole {
 public:
  /// `link`: to the controller. `ending`: to the same one, for the time of each `stop` and each `disable`:
  /// the control socket answers the commands of a connection in order, and these wait behind no other one.
  WriterRole(ControlLink& link, ControlLink& ending, PageClients& clients, PageEvents& events);

  bool is_free() const { return holder_ == 0; }
  bool is_of(const PageClient& client) const { return holder_ == client.number; }
  /// 0: to none. The controller's right to write goes with the role.
  void give_to(std::uint64_t client);
  void show_to(PageClient& client) const;

  /// Sends a command of this page and makes its events. `stop` and `disable` end something: they need no
  /// role.
  void command(std::uint64_t client, const nlohmann::json& command, ControlLink::Done done);
  /// Gets the answer to `settings`. Makes events of those that no command of a page has changed.
  void read_settings(ControlLink::Done done);
  /// The controller has begun or ended, or its stream was lost.
  void controller_changed();

 private:
  void note(const std::vector<config::Change>& changes);
  void compare(const std::vector<config::Setting>& now);

  PageClients& clients_;
  PageEvents& events_;
  ControlLink &link_, &ending_;
  std::uint64_t holder_ = 0;            ///< number of a client
  std::vector<config::Setting> known_;  ///< settings in force; empty: none read yet
  std::uint64_t changes_ = 0;           ///< commands of pages so far: answers from before one of them are old
};

}  // namespace hystcan::app
