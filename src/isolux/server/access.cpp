#include "isolux/server/access.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/base/user_folder.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTokenBytes = 32;

// "localhost:7411" -> "localhost", "[::1]:80" -> "::1", in lower case.
std::string name_of(std::string_view host_header) {
  std::string name(host_header);
  if (name.starts_with('[')) {
    const std::size_t end = name.find(']');
    name = end == std::string::npos ? std::string() : name.substr(1, end - 1);
  } else {
    name = name.substr(0, name.find(':'));
  }
  std::ranges::transform(name, name.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

bool is_numeric_address(std::string_view name) {
  const bool has_colon = name.find(':') != std::string_view::npos;
  return !name.empty() && std::ranges::all_of(name, [&](unsigned char c) {
    return has_colon ? std::isxdigit(c) || c == ':' || c == '.' : std::isdigit(c) || c == '.';
  });
}

std::string random_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw WorkError("view", std::string("no random numbers: ") + std::strerror(errno),
                    "this system cannot make a safe token");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    token += "0123456789abcdef"[byte >> 4];
    token += "0123456789abcdef"[byte & 15];
  }
  return token;
}

// The token in a file that is ours alone, or an empty text.
std::string kept_token(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return {};
  struct stat about {};
  std::string token(2 * kTokenBytes, '\0');
  const bool is_ours =
      ::fstat(file, &about) == 0 && about.st_uid == ::geteuid() && (about.st_mode & 077) == 0 &&
      ::read(file, token.data(), token.size()) == static_cast<ssize_t>(token.size());
  ::close(file);
  const bool is_token =
      std::ranges::all_of(token, [](unsigned char c) { return std::isxdigit(c); });
  return is_ours && is_token ? token : std::string();
}

}  // namespace

Access::Access(std::string token, std::string host)
    : token_(std::move(token)), host_(std::move(host)) {}

bool Access::host_is_ours(std::string_view host_header) const {
  const std::string name = name_of(host_header);
  if (is_loopback(name)) return true;
  return !is_loopback(host_) && (is_numeric_address(name) || name == host_);
}

bool Access::origin_is_ours(std::string_view origin, std::string_view host_header) const {
  return origin == "http://" + std::string(host_header);
}

bool Access::token_is_right(std::string_view given) const {
  if (given.size() != token_.size()) return false;
  unsigned char difference = 0;
  for (std::size_t n = 0; n < token_.size(); ++n) {
    difference = static_cast<unsigned char>(difference | (given[n] ^ token_[n]));
  }
  return difference == 0;
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" ||
         (host.starts_with("127.") && is_numeric_address(host));
}

std::string user_token() {
  const fs::path folder = user_state_folder();
  if (folder.empty()) return random_token();
  const fs::path path = folder / "view-token";
  if (std::string token = kept_token(path); !token.empty()) return token;
  std::string token = random_token();
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  fs::remove(path, ignored);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return token;
  const bool written =
      ::write(file, token.data(), token.size()) == static_cast<ssize_t>(token.size());
  ::close(file);
  if (!written) fs::remove(path, ignored);
  return token;
}

}  // namespace isolux
