#include "app/page/writer_role.h"

#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_protocol.h"
#include "base/error.h"

namespace hystcan::app {

using nlohmann::json;

WriterRole::WriterRole(ControlLink& link, ControlLink& ending, PageClients& clients, PageEvents& events)
    : clients_(clients), events_(events), link_(link), ending_(ending) {}

void WriterRole::give_to(std::uint64_t client) {
  if (holder_ == client) return;
  link_.give_up_writing();
  if (client != 0)
    events_.add_act(client, "info", "takes control");
  else
    events_.add_act(holder_, "info", "returns control");
  holder_ = client;
  for (auto& [number, other] : clients_.all()) show_to(other);
}

void WriterRole::show_to(PageClient& client) const {
  const char* role = is_free() ? "free" : is_of(client) ? "yours" : "taken";
  client.send({{"type", "writer"}, {"role", role}, {"authorised", client.is_authorised}});
}

void WriterRole::command(std::uint64_t client, const json& command, ControlLink::Done done) {
  ++changes_;
  const ControlCommand& row = take_command(command, Server::controller);
  ControlLink& link = row.access == Access::ends ? ending_ : link_;
  link.ask(command, [this, client, command, &row, done = std::move(done)](const json& answer) {
    ++changes_;
    if (row.controller == Reply::changes && is_done(answer)) note(read_answer<ChangesAnswer>(answer).changed);
    events_.add_command(client, command, answer);
    done(answer);
    if (!ending_.is_busy()) ending_.close();
  });
}

void WriterRole::read_settings(ControlLink::Done done) {
  link_.ask(command_of(Verb::settings),
            [this, done = std::move(done), changes = changes_](const json& answer) {
              try {
                if (changes == changes_ && is_done(answer))
                  compare(read_answer<SettingsAnswer>(answer).settings);
              } catch (const std::exception& error) {  // the answer does not have the form of `settings`
                return done(refusal(error_text(error)));
              }
              done(answer);
            });
}

/// Closes the connection if it is idle, because the controller at its other end may have ended. Keeps the
/// settings that were read last: the next settings are compared with them, so that a change in between
/// becomes an event.
void WriterRole::controller_changed() {
  if (!link_.is_busy()) link_.close();
}

void WriterRole::note(const std::vector<config::Change>& changes) {
  if (known_.empty()) return;
  for (const config::Change& change : changes) {
    std::erase_if(known_, [&](const config::Setting& setting) { return setting.path == change.path; });
    if (!change.to.empty()) known_.push_back({change.path, change.to});
  }
}

void WriterRole::compare(const std::vector<config::Setting>& now) {
  if (!known_.empty()) events_.add_foreign_changes(config::changes(known_, now));
  known_ = now;
}

}  // namespace hystcan::app
