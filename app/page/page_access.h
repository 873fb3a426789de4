// Decides who may see the page, and who may write.
//
// A page of another site can make a browser send requests to this server, and can assign the server's address
// to its own name (DNS rebinding). It cannot choose Host and Origin. Therefore Host must be a name of this
// server, and Origin, if present, must be the page's own. The port is ignored: it may be forwarded.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/page/http_server.h"

namespace hystcan::app {

class PageAccess {
 public:
  /// `names`: further names of this server, besides localhost and its addresses.
  explicit PageAccess(std::vector<std::string> names, std::string token);

  /// Returns a response with status 200 if the request is allowed, else the refusal.
  HttpResponse judge(const HttpRequest& request) const;
  /// Compares in constant time, so that the time does not show how many characters of a guess are right.
  bool is_token(std::string_view text) const;

 private:
  std::vector<std::string> names_;
  std::string token_;
};

bool is_loopback(const std::string& address);

/// Returns 32 hexadecimal digits from the kernel's random numbers. Throws RunError.
std::string new_token();

/// Returns the token in this file, which only its owner may read; creates the file if it is missing. Throws
/// RunError if others may read the file, if it is not the user's own, or if it contains no token.
std::string token_of(const std::filesystem::path& file);

}  // namespace hystcan::app
