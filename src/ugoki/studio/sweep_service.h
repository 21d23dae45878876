#pragma once
// Tables of results of `ugoki bake` for the studio's page: GET /api/sweeps... (docs/studio-protocol.md).

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/studio/server.h"

namespace ugoki::studio {

/// Where the studio looks for tables.
struct SweepPlaces {
  std::string folder;   ///< of the open project
  std::string library;  ///< location of the library; its sweeps are listed if it is a PostgreSQL database
};

/// True for the paths that answer_sweeps() answers.
[[nodiscard]] bool is_sweep_path(std::string_view path);

/// Answers GET /api/sweeps, /api/sweeps/rows, /api/sweeps/csv and /api/sweeps/plot.
/// Errors: an unknown table or column; a table with more than 100,000 runs.
[[nodiscard]] Result<ApiReply> answer_sweeps(const ApiRequest& request, const SweepPlaces& places);

}  // namespace ugoki::studio
