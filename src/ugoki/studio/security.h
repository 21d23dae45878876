#pragma once
// Admission of requests to the studio by token, cookie, Host and Origin. Pure functions, no sockets.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::studio {

/// A new random token: 43 characters of 6 bits (258 bits) from the system's random source. They need no escaping in a URL or a cookie.
[[nodiscard]] std::string make_token();

/// True if both texts are equal and not empty. The time does not depend on where they differ.
[[nodiscard]] bool equal_secret(std::string_view given, std::string_view secret);

/// The value of cookie `name` in a Cookie header; nothing if it is absent.
[[nodiscard]] std::optional<std::string> cookie_value(std::string_view header, std::string_view name);

/// Percent-decoded text ('+' stays '+'); nothing if an escape is invalid or decodes to NUL.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

/// A request target (path and query of a URL) split into its parts.
struct Target {
  std::string path;   ///< decoded, begins with '/'
  std::string query;  ///< not decoded, without '?'
};
/// Splits a request target; nothing if it is not an absolute path or contains an invalid escape.
[[nodiscard]] std::optional<Target> parse_target(std::string_view target);

/// The decoded value of `name` in a query string ('+' is a space); nothing if it is absent or invalid.
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);
/// All decoded values of `name`, in order; invalid ones are omitted.
[[nodiscard]] std::vector<std::string> query_values(std::string_view query, std::string_view name);

/// True if a decoded path cannot lead out of the web folder: it is absolute and contains no "." or ".." segment, backslash or control
/// character.
[[nodiscard]] bool is_plain_path(std::string_view path);

/// The fields of a request that decide on its admission. Views into the request.
struct Credentials {
  std::string_view host;       ///< Host header; empty if absent
  std::size_t host_count = 0;  ///< number of Host headers
  std::optional<std::string_view> origin;
  std::string_view cookies;  ///< Cookie header
  std::string_view path;
  std::string_view query;
};

enum class Admission : std::uint8_t { granted, granted_by_token, bad_host, bad_origin, no_token, wrong_token };

/// Access control of the server at 127.0.0.1:`port`.
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
