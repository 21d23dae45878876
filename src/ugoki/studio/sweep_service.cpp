#include "ugoki/studio/sweep_service.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "ugoki/base/number.h"
#include "ugoki/store/connection.h"
#include "ugoki/studio/security.h"
#include "ugoki/sweep/plot.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t max_runs = 100'000;
constexpr std::string_view prefix = "/api/sweeps";

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// The address of the table that a request names: a file of the folder, the path of a file, or the name of a sweep in the library.
Result<sweep::TableAddress> address_of(const ApiRequest& request, const SweepPlaces& places) {
  if (const std::string name = query_value(request.query, "sweep").value_or(""); !name.empty()) {
    if (!store::is_postgres(places.library))
      return fail(ErrorCode::unknown, "sweep", "The library is not in PostgreSQL, so it has no sweeps.", "Name a table.");
    return sweep::TableAddress{places.library, name};
  }
  const std::string name = query_value(request.query, "table").value_or("");
  const std::filesystem::path named = std::filesystem::path(name).lexically_normal();
  if (named.is_relative() && !named.empty() && *named.begin() == "..")
    return fail(ErrorCode::unknown, name.substr(0, 400), "A table without a full path must be in the folder of the project.", "Give the full path of the file.");
  const std::filesystem::path path = std::filesystem::path(places.folder) / named;  // an absolute name replaces the folder
  std::error_code none;
  if (name.empty() || !std::filesystem::is_regular_file(path, none))
    return fail(ErrorCode::unknown, name.empty() ? "table" : name.substr(0, 400), "There is no such file.",
                "Name a table that `ugoki bake` wrote.");
  return sweep::TableAddress{path.string(), ""};
}

Result<ApiReply> list(const SweepPlaces& places) {
  Json tables = Json::array();
  for (const sweep::FoundTable& t : sweep::find_tables(places.folder))
    tables.push_back({{"table", t.name}, {"name", t.name}, {"runs", t.runs}});
  if (store::is_postgres(places.library)) {
    const Result<std::vector<sweep::FoundTable>> found = sweep::find_sweeps(places.library);
    if (!found) return fail(found.error());
    for (const sweep::FoundTable& t : *found) tables.push_back({{"sweep", t.name}, {"name", t.name}, {"runs", t.runs}});
  }
  return ApiReply{200, text_of({{"folder", places.folder}, {"tables", std::move(tables)}})};
}

/// Numbers as numbers, other texts as texts, missing values as null.
Json cell(const std::string& text) {
  if (text.empty()) return nullptr;
  if (const std::optional<double> number = parse_double(text)) return *number;
  return text;
}

}  // namespace

bool is_sweep_path(std::string_view path) {
  return path == prefix || (path.starts_with(prefix) && path.substr(prefix.size()).starts_with('/'));
}

Result<ApiReply> answer_sweeps(const ApiRequest& request, const SweepPlaces& places) {
  const std::string_view what = std::string_view(request.path).substr(prefix.size());
  if (what.empty()) return list(places);
  const Result<sweep::TableAddress> address = address_of(request, places);
  if (!address) return fail(address.error());
  if (what == "/plot") {
    const auto column = [&](std::string_view name) { return query_value(request.query, name).value_or(""); };
    Result<sweep::TablePlot> plot = sweep::plot_table(*address, {column("title"), column("x"), column("y"), column("by")});
    if (!plot) return fail(std::move(plot.error()));
    return ApiReply{200, std::move(plot->svg), "application/octet-stream"};
  }
  if (what != "/rows" && what != "/csv")
    return fail(ErrorCode::unknown, request.path, "The studio has no such address.", "See docs/studio-protocol.md.");
  const Result<sweep::Results> results = sweep::read_results(*address, max_runs);
  if (!results) return fail(results.error());
  if (what == "/csv") return ApiReply{200, sweep::to_csv(*results), "application/octet-stream"};
  Json rows = Json::array();
  for (const std::vector<std::string>& row : results->cells) {
    Json cells = Json::array();
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string& name = results->columns[i];
      // hashes and messages are texts even if they consist of digits
      if (name == "state_hash" || name == "message" || name == "target")
        cells.push_back(row[i].empty() ? Json(nullptr) : Json(row[i]));
      else
        cells.push_back(cell(row[i]));
    }
    rows.push_back(std::move(cells));
  }
  return ApiReply{200, text_of({{"columns", results->columns}, {"rows", std::move(rows)}})};
}

}  // namespace ugoki::studio
