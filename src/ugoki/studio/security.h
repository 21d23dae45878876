#pragma once
// Admission of requests to the studio by token, Host and Origin. Pure functions, no sockets.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// A new random token: 43 characters of 6 bits (258 bits) from the system's random source. They need no escaping in a URL or a header.
[[nodiscard]] std::string make_token();

/// True if both texts are equal and not empty. The time does not depend on where they differ.
[[nodiscard]] bool equal_secret(std::string_view given, std::string_view secret);

/// The token in an Authorization header of the form "Bearer TOKEN" (RFC 6750); nullopt if the header has another form.
[[nodiscard]] std::optional<std::string> bearer_token(std::string_view header);

/// Name of the studio's WebSocket subprotocol. A page cannot set headers of a WebSocket, so it offers the two subprotocols "ugoki" and
/// "ugoki.token.TOKEN".
inline constexpr std::string_view subprotocol = "ugoki";
/// The token in the list of subprotocols of a Sec-WebSocket-Protocol header; nullopt if the list contains no token.
[[nodiscard]] std::optional<std::string> subprotocol_token(std::string_view header);
/// True if the list of subprotocols contains "ugoki".
[[nodiscard]] bool offers_subprotocol(std::string_view header);

/// Percent-decoded text ('+' stays '+'); nullopt if an escape is invalid or decodes to NUL.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

/// A request target (path and query of a URL) split into its parts.
struct Target {
  std::string path;   ///< percent-decoded path, begins with '/'
  std::string query;  ///< query as in the target (not decoded), without '?'
};
/// Splits a request target; nullopt if the target is not an absolute path or contains an invalid escape.
[[nodiscard]] std::optional<Target> parse_target(std::string_view target);

/// The decoded value of `name` in a query string ('+' is a space); nullopt if it is absent or invalid.
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);
/// The number `name` in a query string; nullopt if it is absent or empty.
/// Error (its location is the name): the value is not a finite number from `min` to `max`.
[[nodiscard]] Result<std::optional<double>> query_number(std::string_view query, std::string_view name, double min, double max);
/// All decoded values of `name`, in order; invalid ones are omitted.
[[nodiscard]] std::vector<std::string> query_values(std::string_view query, std::string_view name);

/// True if a decoded path cannot lead out of the web folder: it is absolute and contains no "." or ".." segment, backslash or control
/// character.
[[nodiscard]] bool is_plain_path(std::string_view path);

/// The fields of a request that decide on its admission. Views into the request.
struct Credentials {
  std::string_view host;                   ///< value of the Host header; empty if absent
  std::size_t host_count = 0;              ///< number of Host headers
  std::optional<std::string_view> origin;  ///< value of the first Origin header
  std::size_t origin_count = 0;            ///< number of Origin headers
  std::string_view authorization;          ///< value of the Authorization header
  std::string_view subprotocols;           ///< Sec-WebSocket-Protocol header; used for /ws only
  std::string_view path;
};

/// `open`: the path needs no token. `granted`: the request contains the token.
enum class Admission : std::uint8_t { open, granted, bad_host, bad_origin, no_token, wrong_token };

/// Access control of the server at 127.0.0.1:`port`.
struct Gate {
  std::uint16_t port = 0;
  std::string token;  ///< secret that gives access to /api/ and /ws
  std::string code;   ///< part of the page's address; the page exchanges the code for the token

  [[nodiscard]] std::string host() const;    ///< "127.0.0.1:PORT"
  [[nodiscard]] std::string origin() const;  ///< "http://127.0.0.1:PORT"
  /// The rules of docs/studio-protocol.md: /api/ and /ws need the token, /api/session and the page's files only the Host and Origin.
  [[nodiscard]] Admission admit(const Credentials& credentials) const;
};

}  // namespace ugoki::studio
