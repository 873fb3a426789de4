// The writer's role, the changes that pages make with it at the controller, and the settings in force as far
// as known.
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
  /// `link`: connection to the controller. `ending`: a second connection, for `stop` and `disable`, which
  /// must not wait for other commands: the control socket answers the commands of a connection in order.
  WriterRole(ControlLink& link, ControlLink& ending, PageClients& clients, PageEvents& events);

  bool is_free() const { return holder_ == 0; }
  bool is_of(const PageClient& client) const { return holder_ == client.number; }
  /// Gives the role to the client with this number; 0: no client has the role. The right to write at the
  /// controller moves with the role.
  void give_to(std::uint64_t client);
  void show_to(PageClient& client) const;

  /// Sends a command of this page and adds its events. `stop` and `disable` do not need the role, because
  /// they only end a motion.
  void command(std::uint64_t client, const nlohmann::json& command, ControlLink::Done done);
  /// Requests `settings`. Adds events for changes that no command of a page made.
  void read_settings(ControlLink::Done done);
  /// Call this when the controller started or ended, or its stream was lost.
  void controller_changed();

 private:
  void note(const std::vector<config::Change>& changes);
  void compare(const std::vector<config::Setting>& now);

  PageClients& clients_;
  PageEvents& events_;
  ControlLink &link_, &ending_;
  std::uint64_t holder_ = 0;            ///< number of the client with the role; 0: none
  std::vector<config::Setting> known_;  ///< settings in force; empty: not read yet
  std::uint64_t changes_ = 0;           ///< number of the pages' commands so far, which detects outdated
                                        ///< answers
};

}  // namespace hystcan::app
