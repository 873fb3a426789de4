#include "app/page/page_access.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"

namespace hystcan::app {
namespace {

constexpr std::size_t token_bytes = 16;

/// Returns the host name in lower case and without port: "localhost" for "LOCALHOST:8080", "::1" for
/// "[::1]:8080".
std::string name_of(const std::string& host) {
  std::string name = host;
  if (name.starts_with('[')) {
    const auto end = name.find(']');
    name = end == std::string::npos ? "" : name.substr(1, end - 1);
  } else if (std::ranges::count(name, ':') == 1) {
    name = name.substr(0, name.find(':'));
  }
  std::ranges::transform(name, name.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

bool is_hexadecimal(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return std::isxdigit(c) != 0; });
}

/// Reads the token from the opened file. The file must belong to the user of this process, or to the owner of
/// its folder. The second case lets root read the token of a service that runs as another user. Throws
/// RunError otherwise, or if other users can read the file.
std::string read_token(const std::filesystem::path& file, const Descriptor& opened) {
  struct stat found {};
  struct stat folder {};
  if (fstat(opened.get(), &found) != 0 || stat(file.parent_path().c_str(), &folder) != 0)
    throw RunError(file, std::strerror(errno));
  if (!S_ISREG(found.st_mode))
    throw RunError(file, "is not a file", expect("a regular file with the token of the page"));
  const bool is_trusted = found.st_uid == geteuid() || found.st_uid == folder.st_uid;
  if (!is_trusted || (found.st_mode & 077U) != 0)
    throw RunError(file, "belongs to another user, or others can read it",
                   {.expected = "mode 0600", .remedy = "delete the file to get a new token"});
  std::array<char, 2 * token_bytes + 2> text{};
  const ssize_t size = ::read(opened.get(), text.data(), text.size());
  if (size < 0) throw RunError(file, std::strerror(errno));
  std::string token(text.data(), static_cast<std::size_t>(size));
  if (token.ends_with('\n')) token.pop_back();
  if (token.size() != 2 * token_bytes || !is_hexadecimal(token))
    throw RunError(file, "does not contain a token",
                   {.expected = "32 hexadecimal digits", .remedy = "delete the file to get a new token"});
  return token;
}

/// Reads the token if the file exists; returns nullopt if it does not.
std::optional<std::string> token_there(const std::filesystem::path& file) {
  const Descriptor opened(::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (opened.get() >= 0) return read_token(file, opened);
  if (errno != ENOENT) throw RunError(file, fmt::format("cannot be read: {}", std::strerror(errno)));
  return std::nullopt;
}

/// Writes the whole line. Returns 0, or errno if writing failed.
int write_line(const Descriptor& into, std::string_view line) {
  while (!line.empty()) {
    const ssize_t size = ::write(into.get(), line.data(), line.size());
    if (size < 0) return errno;
    line.remove_prefix(static_cast<std::size_t>(size));
  }
  return 0;
}

/// Creates the file with a new token and returns the token. Returns nullopt if another program created the
/// file first. The file appears only when it is complete.
std::optional<std::string> token_made(const std::filesystem::path& file) {
  std::string temporary = file.string() + ".XXXXXX";
  const Descriptor made(::mkostemp(temporary.data(), O_CLOEXEC));  // creates the file with mode 0600
  if (made.get() < 0) throw RunError(file, fmt::format("cannot be created: {}", std::strerror(errno)));
  std::string token = new_token();
  int error = write_line(made, token + "\n");
  // link() fails if the file exists. renameat2(RENAME_NOREPLACE) does the same, but not on a network file
  // system.
  if (error == 0 && ::link(temporary.c_str(), file.c_str()) != 0) error = errno;
  ::unlink(temporary.c_str());
  if (error == 0) return token;
  if (error != EEXIST) throw RunError(file, fmt::format("cannot be written: {}", std::strerror(error)));
  return std::nullopt;
}

}  // namespace

PageAccess::PageAccess(std::vector<std::string> names, std::string token)
    : names_(std::move(names)), token_(std::move(token)) {
  for (std::string& name : names_) name = name_of(name);
}

HttpResponse PageAccess::judge(const HttpRequest& request) const {
  const std::string host = name_of(request.host);
  const bool is_own = (host == "localhost" && is_loopback(request.local_address)) ||
                      (!host.empty() && host == name_of(request.local_address)) ||
                      std::ranges::find(names_, host) != names_.end();
  if (!is_own)
    return {.status = 421,
            .body = "This server has another name. Use its address, or start it with --name NAME.\n"};
  if (!request.origin.empty() && request.origin != "http://" + request.host)
    return {.status = 403, .body = "Pages of another origin are not allowed.\n"};
  return {};
}

bool PageAccess::is_token(std::string_view text) const {
  unsigned difference = text.size() == token_.size() ? 0 : 1;
  for (std::size_t i = 0; i < token_.size(); ++i)
    difference |=
        static_cast<unsigned char>(token_[i]) ^ static_cast<unsigned char>(i < text.size() ? text[i] : '\0');
  return difference == 0;
}

bool is_loopback(const std::string& address) {
  boost::system::error_code error;
  const auto parsed = boost::asio::ip::make_address(address, error);
  return !error && parsed.is_loopback();
}

std::string new_token() {
  std::array<unsigned char, token_bytes> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw RunError(fmt::format("cannot create the access token of the page: {}", std::strerror(errno)));
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

std::string token_of(const std::filesystem::path& file) {
  if (auto token = token_there(file)) return *std::move(token);
  if (auto token = token_made(file)) return *std::move(token);
  if (auto token = token_there(file)) return *std::move(token);  // another program created it
  throw RunError(file, "disappeared while it was read");
}

}  // namespace hystcan::app
