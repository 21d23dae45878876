#pragma once
// Who may talk to the studio: token, cookie, Host and Origin. Pure functions, no sockets.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::studio {

/// 256 bits of the system's randomness as 43 characters that need no escaping in an address or a cookie.
[[nodiscard]] std::string make_token();

/// True if both texts are equal; takes the same time wherever they differ.
[[nodiscard]] bool equal_secret(std::string_view given, std::string_view secret);

/// The value of cookie `name` in a Cookie header.
[[nodiscard]] std::optional<std::string> cookie_value(std::string_view header, std::string_view name);

/// Percent-decoded text ('+' stays '+'); nothing where an escape is broken or decodes to a NUL.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

/// A request target taken apart.
struct Target {
  std::string path;   ///< decoded, begins with '/'
  std::string query;  ///< as it came, without '?'
};
/// Nothing where the target is not an absolute path or is broken.
[[nodiscard]] std::optional<Target> parse_target(std::string_view target);

/// The decoded value of `name` in a query string ('+' means a blank); nothing where it is absent or broken.
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);
/// All values of `name`, in their order; broken ones are left out.
[[nodiscard]] std::vector<std::string> query_values(std::string_view query, std::string_view name);

/// True where a path names something below the web folder: no "." or ".." segment, backslash, control character.
[[nodiscard]] bool is_plain_path(std::string_view path);

/// What a request brings to prove that it may come in. Views into the request.
struct Credentials {
  std::string_view host;       ///< Host header, empty if none
  std::size_t host_count = 0;  ///< how many Host headers there are
  std::optional<std::string_view> origin;
  std::string_view cookies;  ///< Cookie header
  std::string_view path;
  std::string_view query;
};

enum class Admission : std::uint8_t { granted, granted_by_token, bad_host, bad_origin, no_token, wrong_token };

/// The gate of 127.0.0.1:`port`.
struct Gate {
  std::uint16_t port = 0;
  std::string token;

  [[nodiscard]] std::string host() const;         ///< "127.0.0.1:PORT"
  [[nodiscard]] std::string origin() const;       ///< "http://127.0.0.1:PORT"
  [[nodiscard]] std::string cookie_name() const;  ///< "ugoki_PORT"
  /// Value of a Set-Cookie header.
  [[nodiscard]] std::string set_cookie() const;
  /// The rules of docs/studio-protocol.md: the page, /api/ and /ws need the token, assets only the Host.
  [[nodiscard]] Admission admit(const Credentials& credentials) const;
};

}  // namespace ugoki::studio
