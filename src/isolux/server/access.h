#pragma once

#include <string>
#include <string_view>

namespace isolux {

/// Who may speak to the server. Three locks, since each alone has been picked elsewhere:
/// - the token, which only the person who saw the URL has;
/// - the Host header, so that a foreign name that was made to point here (DNS rebinding) is known;
/// - the Origin header, so that a page from elsewhere is known even where it knows the token.
/// A port is not looked at: behind `ssh -L` the browser sees another one.
class Access {
 public:
  /// @param host  what the server was told to listen on, such as "127.0.0.1" or "0.0.0.0".
  Access(std::string token, std::string host);

  /// Loopback names always; beyond loopback also numeric addresses, which no one can rebind, and
  /// the name itself.
  bool host_is_ours(std::string_view host_header) const;

  /// Whether the origin is that of the page served under this Host header.
  bool origin_is_ours(std::string_view origin, std::string_view host_header) const;

  /// In time that does not depend on where the two differ.
  bool token_is_right(std::string_view given) const;

  const std::string& token() const { return token_; }

 private:
  std::string token_;
  std::string host_;
};

/// Whether only this machine can reach a server there.
bool is_loopback(std::string_view host);

/// The token of this user's viewers: 256 random bits in hexadecimal digits, kept in a file that
/// only the user can read, so that a page finds its way back to a server that was started again.
/// Without a folder to keep it in, a new one.
std::string user_token();

}  // namespace isolux
