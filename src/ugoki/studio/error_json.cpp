#include "ugoki/studio/error_json.h"

#include "ugoki/json/json.h"

namespace ugoki::studio {

std::string error_json(const Error& error) { return json::to_text(json::error_json(error)); }

std::string error_body(const Error& error) { return "{\"error\":" + error_json(error) + "}"; }

std::string error_page(const Error& error) {
  const auto escaped = [](std::string_view text) {
    std::string out;
    for (const char c : text) {
      if (c == '<')
        out += "&lt;";
      else if (c == '&')
        out += "&amp;";
      else
        out += c;
    }
    return out;
  };
  const Problem& p = error.problems.front();
  return "<!doctype html><meta charset=\"utf-8\"><title>Ugoki</title><body style=\"font:15px system-ui;background:#16181d;"
         "color:#e6e6ea;padding:3em\"><p>" +
         escaped(p.message) + "</p><p>" + escaped(p.remedy) + "</p></body>\n";
}

int http_status_of(const Error& error) {
  if (error.problems.empty()) return 500;
  switch (error.problems.front().code) {
    case ErrorCode::unknown: return 404;
    case ErrorCode::conflict: return 409;
    case ErrorCode::io: return 500;
    default: return 400;
  }
}

}  // namespace ugoki::studio
