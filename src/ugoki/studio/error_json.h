#pragma once
// Errors as the page reads them.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// {"problems": [{"code", "place", "message", "remedy"}]}
[[nodiscard]] std::string error_json(const Error& error);

/// {"error": {"problems": [...]}}: the body of a refused HTTP request.
[[nodiscard]] std::string error_body(const Error& error);

/// HTTP status that fits an error: 404 unknown, 409 conflict, 500 io, otherwise 400.
[[nodiscard]] int http_status_of(const Error& error);

}  // namespace ugoki::studio
