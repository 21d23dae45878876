#include "ugoki/studio/security.h"

#include <sys/random.h>

#include <array>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"

namespace ugoki::studio {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> decoded(std::string_view text, bool plus_is_blank) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
      if (high < 0 || low < 0 || (high == 0 && low == 0)) return std::nullopt;
      out.push_back(static_cast<char>(high * 16 + low));
      i += 2;
    } else {
      out.push_back(plus_is_blank && text[i] == '+' ? ' ' : text[i]);
    }
  }
  return out;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Calls `use(part)` for each part between separators, until it returns false.
template <class Use>
void for_each_part(std::string_view text, char separator, Use use) {
  while (true) {
    const std::size_t end = text.find(separator);
    if (!use(text.substr(0, end)) || end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

std::string make_token() {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  std::array<unsigned char, 43> bytes{};
  UGOKI_CHECK(getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  std::string token;
  for (const unsigned char b : bytes) token.push_back(digits[b & 63]);
  return token;
}

bool equal_secret(std::string_view given, std::string_view secret) {
  unsigned difference = given.size() == secret.size() && !secret.empty() ? 0 : 1;
  for (std::size_t i = 0; i < given.size() && !secret.empty(); ++i) {
    difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned>(static_cast<unsigned char>(secret[i % secret.size()]));
  }
  return difference == 0;
}

std::optional<std::string> bearer_token(std::string_view header) {
  constexpr std::string_view scheme = "bearer ";  // not case-sensitive (RFC 7235)
  if (header.size() <= scheme.size()) return std::nullopt;
  for (std::size_t i = 0; i < scheme.size(); ++i) {
    const char c = header[i] >= 'A' && header[i] <= 'Z' ? static_cast<char>(header[i] + 32) : header[i];
    if (c != scheme[i]) return std::nullopt;
  }
  return std::string(trimmed(header.substr(scheme.size())));
}

std::optional<std::string> subprotocol_token(std::string_view header) {
  constexpr std::string_view prefix = "ugoki.token.";
  std::optional<std::string> found;
  for_each_part(header, ',', [&](std::string_view part) {
    part = trimmed(part);
    if (part.starts_with(prefix)) found = std::string(part.substr(prefix.size()));
    return !found;
  });
  return found;
}

bool offers_subprotocol(std::string_view header) {
  bool offered = false;
  for_each_part(header, ',', [&](std::string_view part) {
    offered = trimmed(part) == subprotocol;
    return !offered;
  });
  return offered;
}

std::optional<std::string> percent_decoded(std::string_view text) { return decoded(text, false); }

std::optional<Target> parse_target(std::string_view target) {
  if (target.empty() || target.front() != '/') return std::nullopt;
  const std::size_t question = target.find('?');
  std::optional<std::string> path = percent_decoded(target.substr(0, question));
  if (!path) return std::nullopt;
  return Target{std::move(*path), question == std::string_view::npos ? std::string() : std::string(target.substr(question + 1))};
}

std::optional<std::string> query_value(std::string_view query, std::string_view name) {
  std::optional<std::string> found;
  for_each_part(query, '&', [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    const std::optional<std::string> key = decoded(part.substr(0, equals), true);
    if (!key || *key != name) return true;
    found = equals == std::string_view::npos ? std::string() : decoded(part.substr(equals + 1), true);
    return false;
  });
  return found;
}

Result<std::optional<double>> query_number(std::string_view query, std::string_view name, double min, double max) {
  const std::string given = query_value(query, name).value_or("");
  if (given.empty()) return std::optional<double>();
  const std::optional<double> number = parse_double(given);
  if (number && *number >= min && *number <= max) return number;
  return fail(ErrorCode::range, std::string(name),
              "\"" + std::string(name) + "\" must be a number from " + to_text(min) + " to " + to_text(max) + ".",
              "See docs/studio-protocol.md.");
}

std::vector<std::string> query_values(std::string_view query, std::string_view name) {
  std::vector<std::string> found;
  for_each_part(query, '&', [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    const std::optional<std::string> key = decoded(part.substr(0, equals), true);
    if (!key || *key != name) return true;
    std::optional<std::string> value = equals == std::string_view::npos ? std::string() : decoded(part.substr(equals + 1), true);
    if (value) found.push_back(std::move(*value));
    return true;
  });
  return found;
}

bool is_plain_path(std::string_view path) {
  if (path.empty() || path.front() != '/') return false;
  for (const char c : path) {
    if (c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  }
  bool plain = true;
  for_each_part(path.substr(1), '/', [&](std::string_view part) {
    plain = part != "." && part != "..";
    return plain;
  });
  return plain;
}

std::string Gate::host() const { return "127.0.0.1:" + std::to_string(port); }
std::string Gate::origin() const { return "http://" + host(); }

Admission Gate::admit(const Credentials& credentials) const {
  // Browsers omit the port from Host and Origin if it is the default port of HTTP, 80.
  const bool default_port = port == 80;
  if (credentials.host_count != 1 || (credentials.host != host() && !(default_port && credentials.host == "127.0.0.1"))) {
    return Admission::bad_host;
  }
  if (credentials.origin_count > 1) return Admission::bad_origin;
  if (credentials.origin && *credentials.origin != origin() && !(default_port && *credentials.origin == "http://127.0.0.1")) {
    return Admission::bad_origin;
  }
  const std::string_view path = credentials.path;
  const bool guarded = path == "/ws" || path == "/api" || (path.starts_with("/api/") && path != "/api/session");
  if (!guarded) return Admission::open;
  std::optional<std::string> given = bearer_token(credentials.authorization);
  if (!given && path == "/ws") given = subprotocol_token(credentials.subprotocols);
  if (!given) return Admission::no_token;
  return equal_secret(*given, token) ? Admission::granted : Admission::wrong_token;
}

}  // namespace ugoki::studio
