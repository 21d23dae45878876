#include "ugoki/studio/error_json.h"

#include "ugoki/json/json.h"

namespace ugoki::studio {

std::string error_json(const Error& error) { return json::to_text(json::error_json(error)); }

std::string error_body(const Error& error) { return "{\"error\":" + error_json(error) + "}"; }

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
