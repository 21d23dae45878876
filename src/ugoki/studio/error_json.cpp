#include "ugoki/studio/error_json.h"

#include <nlohmann/json.hpp>

namespace ugoki::studio {

std::string_view name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::syntax: return "syntax";
    case ErrorCode::truncated: return "truncated";
    case ErrorCode::range: return "range";
    case ErrorCode::unknown: return "unknown";
    case ErrorCode::duplicate: return "duplicate";
    case ErrorCode::structure: return "structure";
    case ErrorCode::unsupported: return "unsupported";
    case ErrorCode::io: return "io";
    case ErrorCode::conflict: return "conflict";
    case ErrorCode::cancelled: return "cancelled";
  }
  return "unknown";
}

std::string error_json(const Error& error) {
  nlohmann::json problems = nlohmann::json::array();
  for (const Problem& p : error.problems) {
    problems.push_back({{"code", name_of(p.code)}, {"place", p.place}, {"message", p.message}, {"remedy", p.remedy}});
  }
  // Texts may quote a file's bytes; what is not UTF-8 in them is replaced.
  return nlohmann::json{{"problems", std::move(problems)}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

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
