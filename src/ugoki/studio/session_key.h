#pragma once
// The user's secret key. The studio derives the access token of its port from this key, so an open page keeps its access after a
// restart.

#include <cstdint>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// The key's file: $XDG_STATE_HOME/ugoki/studio.key, or ~/.local/state/ugoki/studio.key; empty if neither folder is known.
[[nodiscard]] std::string default_key_file();

/// The key in the file `path`. Makes a new random key if the file is missing, is damaged, belongs to another user, or can be read by
/// others. Permissions of the file: 0600. Errors: the folder or the file cannot be written.
[[nodiscard]] Result<std::string> read_or_make_key(const std::string& path);

/// HMAC-SHA-256 (RFC 2104) as 64 hexadecimal digits.
[[nodiscard]] std::string hmac_sha256(std::string_view key, std::string_view text);

/// The access token that the studio at 127.0.0.1:`port` accepts. With the same key it is the same after each restart.
[[nodiscard]] std::string derive_token(std::string_view key, std::uint16_t port);

}  // namespace ugoki::studio
