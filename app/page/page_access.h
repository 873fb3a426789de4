// Who may see the page, and who may write.
//
// A page of another site can make a browser send requests to this server, and can give its own name the
// server's address (DNS rebinding). It cannot choose Host and Origin. So Host must be a name of this server,
// and Origin, if there is one, the page's own. The port does not count: it may be forwarded.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/page/http_server.h"

namespace hystcan::app {

class PageAccess {
 public:
  /// `names`: further names of this server, beside localhost and its addresses.
  explicit PageAccess(std::vector<std::string> names, std::string token);

  /// Status 200, or what the request is refused with.
  HttpResponse judge(const HttpRequest& request) const;
  /// In a time that does not depend on what is wrong.
  bool is_token(std::string_view text) const;

 private:
  std::vector<std::string> names_;
  std::string token_;
};

bool is_loopback(const std::string& address);

/// 32 hexadecimal digits from the kernel. Throws RunError.
std::string new_token();

/// The token in this file, which only its owner may read; makes the file if it is not there. Throws RunError
/// if others may read it, if it is not the user's own or no token.
std::string token_of(const std::filesystem::path& file);

}  // namespace hystcan::app
