#pragma once
// Errors in the JSON form that the page reads.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// The error as JSON: {"problems": [{"code", "location", "message", "remedy"}]}
[[nodiscard]] std::string error_json(const Error& error);

/// {"error": {"problems": [...]}}: the body of the reply to a rejected HTTP request.
[[nodiscard]] std::string error_body(const Error& error);

/// An HTML page that shows the error's first problem, for a browser that opened the address directly. @param error at least one problem
[[nodiscard]] std::string error_page(const Error& error);

/// HTTP status for the code of the error's first problem: `unknown` 404, `conflict` 409, `io` 500, other codes 400. Without problems: 500.
[[nodiscard]] int http_status_of(const Error& error);

}  // namespace ugoki::studio
