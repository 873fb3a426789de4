// Manages the writer's role: only the page that has this role may change the controller. Sends the pages'
// commands to the controller, and stores the settings in force that it read last.
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
  /// `link`: connection for commands. `ending`: a second connection for `stop` and `disable`. A control
  /// socket answers the commands of a connection in order, and these two must not wait for other commands.
  WriterRole(ControlLink& link, ControlLink& ending, PageClients& clients, PageEvents& events);

  bool is_free() const { return holder_ == 0; }
  bool is_of(const PageClient& client) const { return holder_ == client.number; }
  /// Gives the role to the client with this number; with 0, no client has the role. Afterwards the previous
  /// client's connection can no longer write at the controller.
  void give_to(std::uint64_t client);
  void show_to(PageClient& client) const;

  /// Sends a command of a page and adds its events. `stop` and `disable` do not need the role, because they
  /// can only end a movement.
  void command(std::uint64_t client, const nlohmann::json& command, ControlLink::Done done);
  /// Requests the settings from the controller. Adds events for changes that no page made.
  void read_settings(ControlLink::Done done);
  /// Closes the connection for commands if it is idle, because the controller at its other end may have
  /// ended. Call this function when the controller starts or ends, or when its stream is lost.
  void controller_changed();

 private:
  void note(const std::vector<config::Change>& changes);
  void compare(const std::vector<config::Setting>& now);

  PageClients& clients_;
  PageEvents& events_;
  ControlLink &link_, &ending_;
  std::uint64_t holder_ = 0;            ///< number of the client that has the role; 0: none
  std::vector<config::Setting> known_;  ///< settings in force, from the last reading; empty: not read yet
  std::uint64_t changes_ = 0;           ///< number of commands and answers so far; if this number changes
                                        ///< during a request for the settings, the answer may be outdated
};

}  // namespace hystcan::app
