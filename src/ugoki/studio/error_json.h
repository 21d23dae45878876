#pragma once
// Errors in the JSON form that the page reads.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// {"problems": [{"code", "location", "message", "remedy"}]}
[[nodiscard]] std::string error_json(const Error& error);

/// {"error": {"problems": [...]}}: the body of the reply to a rejected HTTP request.
[[nodiscard]] std::string error_body(const Error& error);

/// A page with the error's first problem, for a browser that opened an address directly. @param error at least one problem
[[nodiscard]] std::string error_page(const Error& error);

/// HTTP status for the error's first problem: 404 unknown, 409 conflict, 500 io, otherwise 400; 500 for an error without problems.
[[nodiscard]] int http_status_of(const Error& error);

}  // namespace ugoki::studio
