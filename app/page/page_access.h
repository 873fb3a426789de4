// Decides which requests may see the page and which may write.
//
// A page of another site can make a browser send requests to this server, and can give the server's address a
// name of its own (DNS rebinding). However, it cannot choose the header fields Host and Origin. Therefore
// Host must be a name of this server, and Origin, if present, must be the origin of the operator's page. The
// port is ignored, because it may be forwarded.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/page/http_server.h"

namespace hystcan::app {

class PageAccess {
 public:
  /// `names`: names of this server in addition to localhost and its addresses. `token`: the secret for
  /// writing.
  explicit PageAccess(std::vector<std::string> names, std::string token);

  /// Returns a response with status 200 if the request is allowed, otherwise the response that refuses it.
  HttpResponse judge(const HttpRequest& request) const;
  /// Returns true if `text` is the token. The comparison takes the same time for every text, so that an
  /// attacker cannot find out how many characters are right.
  bool is_token(std::string_view text) const;

 private:
  std::vector<std::string> names_;
  std::string token_;
};

bool is_loopback(const std::string& address);

/// Returns a new token: 32 hexadecimal digits from the kernel's random generator. Throws RunError if that
/// fails.
std::string new_token();

/// Returns the token in this file. If the file is missing, creates it with a new token. Throws RunError if
/// other users can read the file, if it belongs to another user, or if it contains no token.
std::string token_of(const std::filesystem::path& file);

}  // namespace hystcan::app
