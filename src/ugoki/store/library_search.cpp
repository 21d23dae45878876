// Searching and browsing a library.
//
// Two methods, the same on both databases, chosen so that no search reads all rows of a large library:
// - Few matches: the search index (which contains words, kinds and tags) returns the matching entries, which are then sorted.
// - Many matches, or no search text: the rows are scanned in the requested order from the position where the page begins, and each row is
//   tested. A page fills soon because many rows match. The words of an entry are stored in one text, so "contains these adjacent words" is
//   a substring test with the same result as the index. If the matches are far from the start of the page, the scan would take long; it
//   then stops after a limited count of rows, and the matches of the index are sorted instead.
// The limit between few and many depends on how fast the database sorts the matches of its index (Dialect::sort_factor).

#include <algorithm>
#include <array>
#include <charconv>

#include "ugoki/base/base64.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

/// The order by relevance has three parts, one after the other. Part 0: names that begin with the text. Part 1: other names that contain
/// the text. Part 2: all other matching entries.
constexpr int relevance_parts = 3;

/// Size class of the result. few: at most LibraryBody::sort_limit matches. many: more. scan: more than Search::sort_limit(), so scanning
/// finds a page faster than sorting. Stored in the position, so that later pages need not count again.
enum class ResultSize : std::uint8_t { few, many, scan };

/// Position in the sorted result, encoded in LibraryPage::next. The next page begins with the entry after this position.
struct Position {
  int part = 0;
  std::string key, id;  ///< sort key and id of the last entry of the page
  ResultSize size = ResultSize::few;
};

/// Column that is the sort key of an order.
struct Column {
  const char* name;
  bool descending, number;
};
Column column_of(LibraryOrder order) {
  switch (order) {
    case LibraryOrder::relevance:
    case LibraryOrder::name: return {"e.name_key", false, false};
    case LibraryOrder::newest: return {"e.changed", true, false};
    case LibraryOrder::oldest: return {"e.changed", false, false};
    case LibraryOrder::longest: return {"e.duration_ms", true, true};
    case LibraryOrder::shortest: return {"e.duration_ms", false, true};
  }
  return {"e.name_key", false, false};
}

/// Converts the position to the text of LibraryPage::next.
std::string text_of(const Position& position, LibraryOrder order) {
  const std::string text = std::to_string(static_cast<int>(order)) + "," + std::to_string(position.part) + "," +
                           std::to_string(static_cast<int>(position.size)) + "," + position.id + "," + position.key;
  return to_base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// Reads and checks the position in LibraryQuery::after, which comes from outside. Inverse of text_of().
Result<Position> position_of(const std::string& text, LibraryOrder order) {
  const auto invalid = [] {
    return fail(ErrorCode::range, "after", "The value is not a position in this list.",
                "Give the value `next` of the previous page, with otherwise the same query.");
  };
  const std::optional<std::vector<std::uint8_t>> bytes = from_base64(text);
  if (!bytes) return invalid();
  const std::string_view all(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::array<std::string_view, 5> fields;
  std::size_t at = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::size_t end = i + 1 < fields.size() ? all.find(',', at) : all.size();
    if (end == std::string_view::npos) return invalid();
    fields[i] = all.substr(at, end - at);
    at = end + 1;
  }
  int part = -1;
  std::from_chars(fields[1].data(), fields[1].data() + fields[1].size(), part);
  const bool number = column_of(order).number;
  const bool digits = !fields[4].empty() && fields[4].size() < 18 && fields[4].find_first_not_of("0123456789") == std::string_view::npos;
  if (fields[0] != std::to_string(static_cast<int>(order)) || part < 0 || part >= relevance_parts || (number && !digits) ||
      fields[2].size() != 1 || fields[2][0] < '0' || fields[2][0] > '2' || clean_text(all) != all)
    return invalid();
  return Position{part, std::string(fields[4]), std::string(fields[3]), static_cast<ResultSize>(fields[2][0] - '0')};
}

/// A statement under construction, with the values of its parameters. parameter() adds a value and returns its placeholder.
struct Sql {
  std::string text;
  std::vector<Value> values;
  std::vector<std::unique_ptr<std::string>> owned;  ///< texts to which `values` refers

  std::string parameter(const Value& value) {
    values.push_back(value);
    return "?" + std::to_string(values.size());
  }
  std::string parameter(std::string value) {
    owned.push_back(std::make_unique<std::string>(std::move(value)));
    return parameter(Value(*owned.back()));
  }
};

/// One search: a query on a library and the state of its execution.
class Search {
 public:
  Search(const LibraryBody& body, const LibraryQuery& query) : body_(body), query_(query), phrases_(search_phrases(query.text)) {
    by_relevance_ = query.order == LibraryOrder::relevance && !phrases_.empty();
    for (const std::string& tag : query.tags) tags_.push_back(clean_text(tag));
    if (query.kinds.empty())
      for (const EntryKind kind : entry_kinds) kinds_.emplace_back(name_of(kind));
    for (const std::string& kind : query.kinds)
      if (std::ranges::find(kinds_, kind) == kinds_.end()) kinds_.push_back(kind);
  }

  Result<LibraryPage> page() {
    LibraryPage out;
    if (phrases_.nothing || query_.limit == 0) return out;
    std::optional<Position> after;
    if (!query_.after.empty()) {
      Result<Position> position = position_of(query_.after, query_.order);
      if (!position) return fail(std::move(position.error()));
      after = std::move(*position);
    }
    const bool filtered = !phrases_.empty() || !tags_.empty();
    by_index_ = filtered && !query_.removed;
    if (!filtered && !after)
      if (Result<void> counted = count_all(out); !counted) return fail(std::move(counted.error()));
    ResultSize size = after ? after->size : ResultSize::few;
    if (by_index_ && size == ResultSize::few) {
      const Result<std::size_t> total = count_matches(Among::all);
      if (!total) return fail(total.error());
      out.total = std::min(*total, body_.sort_limit);
      size = *total > sort_limit() ? ResultSize::scan : *total > body_.sort_limit ? ResultSize::many : ResultSize::few;
    }
    if (filtered && (query_.removed || size != ResultSize::few)) {
      out.total = body_.sort_limit;
      out.total_exact = false;
    }
    Result<std::vector<Hit>> hits = by_index_ && size != ResultSize::scan ? sort_matches(after, Among::all) : scan(after);
    if (!hits) return fail(std::move(hits.error()));
    if (hits->size() > query_.limit) {
      hits->resize(query_.limit);
      Position last = hits->back().position;
      last.size = size;
      out.next = text_of(last, query_.order);
    }
    std::vector<EntryRow> rows;
    for (Hit& hit : *hits) rows.push_back(std::move(hit.row));
    if (Result<void> tagged = read_tags(*body_.connection, rows); !tagged) return fail(std::move(tagged.error()));
    for (const EntryRow& row : rows) {
      Result<LibraryEntry> entry = public_entry(row);
      if (!entry) return fail(std::move(entry.error()));
      out.entries.push_back(std::move(*entry));
    }
    return out;
  }

 private:
  /// Subset of the matches: all; those with the search text in their name; those without the search text in their name.
  enum class Among : std::uint8_t { all, in_name, not_in_name };
  struct Hit {
    Position position;
    EntryRow row;
  };
  [[nodiscard]] Connection& connection() const { return *body_.connection; }
  [[nodiscard]] const Dialect& dialect() const { return connection().dialect(); }

  /// SQL SELECT that returns the matching entries from the search index.
  [[nodiscard]] std::string match(Sql& sql, Among among) const {
    const bool in_name = among == Among::in_name;
    const std::vector<std::string>& kinds = query_.kinds;
    const auto with = [&](std::string text, std::string query) {
      return text.replace(text.find("{query}"), 7, sql.parameter(std::move(query)));
    };
    if (!dialect().postgres) return with(dialect().match, phrases_.fts5(in_name, tags_, kinds));
    const std::string exclude_names = among == Among::not_in_name ? " & !(" + phrases_.tsquery(true, {}, {}, false) + ")" : "";
    std::string out = with(dialect().match, phrases_.tsquery(in_name, tags_, kinds, false) + exclude_names);
    if (phrases_.any_longer_than_pairs()) out += with(dialect().phrase_condition, phrases_.tsquery(in_name, {}, {}, true));
    return out;
  }
  /// Maximum number of matches that are sorted; if there are more, the rows are scanned. Lower for phrases that PostgreSQL must check in
  /// the rows (Dialect::phrase_condition).
  [[nodiscard]] std::size_t sort_limit() const {
    return body_.sort_limit * static_cast<std::size_t>(phrases_.any_longer_than_pairs() ? 1 : dialect().sort_factor);
  }
  /// Count of the matches, at most sort_limit() + 1.
  Result<std::size_t> count_matches(Among among) const {
    Sql sql;
    const std::string select = match(sql, among);
    const Result<Rows> rows = connection().query(
        "SELECT count(*) FROM (SELECT 1 FROM (" + select + ") x LIMIT " + std::to_string(sort_limit() + 1) + ") y", sql.values);
    if (!rows) return fail(rows.error());
    return static_cast<std::size_t>(rows->integer(0, 0));
  }

  /// SQL condition on `entry e` that tests whether its row matches the query. @param part see relevance_parts
  std::string conditions(Sql& sql, int part) const {
    std::string out = "1 = 1";
    for (std::size_t i = 0; i < phrases_.phrases.size(); ++i)
      out += " AND " + dialect().instr + "(e.words, " + sql.parameter(phrases_.in_words(i)) + ") > 0";
    for (const std::string& tag : tags_)
      out += " AND EXISTS (SELECT 1 FROM tag t WHERE t.entry = e.no AND t.tag = " + sql.parameter(Value(tag)) + ")";
    if (by_relevance_ && part == 1) out += " AND " + in_name(sql) + " AND NOT " + begins(sql);
    if (by_relevance_ && part == 2) out += " AND NOT " + in_name(sql);
    return out;
  }

  /// SQL condition: the name begins with the search text. U+10FFFF is greater than any character of a name.
  std::string begins(Sql& sql) const {
    return "(e.name_key >= " + sql.parameter(Value(phrases_.key)) + " AND e.name_key < " +
           sql.parameter(phrases_.key + "\xf4\x8f\xbf\xbf") + ")";
  }
  /// SQL condition: the name contains all phrases of the search text.
  std::string in_name(Sql& sql) const {
    std::string out;
    for (std::size_t i = 0; i < phrases_.phrases.size(); ++i)
      out += (i ? " AND " : "(") + dialect().instr + "(' ' || e.name_key, " + sql.parameter(phrases_.in_words(i)) + ") > 0";
    return out + ")";
  }
  /// SQL condition: the entry is after `position` in the requested order. Both must be in the same part of the order by relevance.
  std::string after_position(Sql& sql, const Position& position) const {
    return compared(sql, column_of(query_.order).descending ? "<" : ">", position);
  }
  /// SQL condition: the entry is at or before `position` in the requested order. Both must be in the same part of the order by relevance.
  std::string up_to_position(Sql& sql, const Position& position) const {
    return compared(sql, column_of(query_.order).descending ? ">=" : "<=", position);
  }
  std::string compared(Sql& sql, const char* comparison, const Position& position) const {
    const Column column = column_of(query_.order);
    const std::string key = column.number ? position.key : sql.parameter(Value(position.key));  // a numeric key contains only digits
    return std::string("(") + column.name + ", e.id) " + comparison + " (" + key + ", " + sql.parameter(Value(position.id)) + ")";
  }
  /// The columns of ORDER BY within one part of the order by relevance.
  std::string order_columns() const {
    const Column column = column_of(query_.order);
    const std::string direction = column.descending ? " DESC" : "";
    return std::string(column.name) + direction + ", e.id" + direction;
  }

  static Hit hit_of(const Rows& rows, std::size_t r, int part) {
    Hit hit;
    hit.row = entry_of(rows, r);
    hit.position = {.part = part, .key = rows.text(r, entry_column_count), .id = hit.row.id};
    return hit;
  }

  /// Sorts the matches of the search index. Sorts only the sort keys; the rows of the page are read afterwards.
  /// @param among all: all parts; in_name: only part 1 (the name contains but does not begin with the text); not_in_name: only part 2
  /// @return the entries of a page, and one more if another page follows
  Result<std::vector<Hit>> sort_matches(const std::optional<Position>& after, Among among) const {
    Sql sql;
    const bool names = among == Among::in_name;
    sql.text = "WITH hit AS " + std::string(dialect().postgres ? "NOT " : "") + "MATERIALIZED (" + match(sql, among) + ") ";
    std::string part = names ? "1" : among == Among::not_in_name ? "2" : "0";
    if (by_relevance_ && among == Among::all) part = "CASE WHEN " + begins(sql) + " THEN 0 WHEN " + in_name(sql) + " THEN 1 ELSE 2 END";
    const Column column = column_of(query_.order);
    const std::string narrow = "SELECT e.no, e.id, " + std::string(column.name) + " AS key, " + part + " AS part FROM " +
                               dialect().hit_source + (names ? " WHERE NOT " + begins(sql) : "");
    std::string where;
    if (after) {
      // The part of the order by relevance is the first sort key.
      const std::string here = std::to_string(after->part), key = column.number ? after->key : sql.parameter(Value(after->key));
      where = " WHERE s.part > " + here + " OR (s.part = " + here + " AND (s.key, s.id) " + (column.descending ? "<" : ">") + " (" + key +
              ", " + sql.parameter(Value(after->id)) + "))";
    }
    const std::string direction = column.descending ? " DESC" : "", order = " ORDER BY s.part, s.key" + direction + ", s.id" + direction;
    sql.text += ", page AS MATERIALIZED (SELECT * FROM (" + narrow + ") s" + where + order + " LIMIT " + std::to_string(query_.limit + 1) +
                ") SELECT " + entry_columns + ", s.key, s.part FROM page s LEFT JOIN entry e ON e.no = s.no" + order;
    const Result<Rows> rows = connection().query(sql.text, sql.values);
    if (!rows) return fail(rows.error());
    std::vector<Hit> out;
    for (std::size_t r = 0; r < rows->size(); ++r)
      out.push_back(hit_of(*rows, r, static_cast<int>(rows->integer(r, entry_column_count + 1))));
    return out;
  }

  /// Many matches: scans the rows in order, part by part. Within a part, each kind is scanned in the order of its table index, and the
  /// results of the kinds are merged. @return as sort_matches()
  Result<std::vector<Hit>> scan(const std::optional<Position>& after) const {
    std::vector<Hit> all;
    for (int part = after ? after->part : 0; part < (by_relevance_ ? relevance_parts : 1) && all.size() <= query_.limit; ++part) {
      const std::optional<Position> from = after && part == after->part ? after : std::nullopt;
      Result<std::size_t> name_matches = sort_limit() + 1;
      if (part == 1) name_matches = count_matches(Among::in_name);  // of the many matches, only few may have the text in the name
      if (!name_matches) return fail(std::move(name_matches.error()));
      Result<std::vector<Hit>> hits;
      if (*name_matches <= sort_limit()) {
        hits = sort_matches(from, Among::in_name);
        if (!hits) return hits;
      } else {
        const Result<bool> done = scan_kinds(part, from, query_.limit + 1 - all.size(), *hits);
        if (!done) return fail(done.error());
        // On PostgreSQL, the index can exclude matches in names, unless a phrase has three or more words.
        const bool can_sort_part = by_relevance_ && part == 2 && dialect().postgres && !phrases_.any_longer_than_pairs();
        if (!*done && !can_sort_part) return sort_matches(after, Among::all);
        if (!*done) hits = sort_matches(from, Among::not_in_name);
        if (!hits) return hits;
      }
      const std::size_t room = std::min(hits->size(), query_.limit + 1 - all.size());
      std::move(hits->begin(), hits->begin() + static_cast<std::ptrdiff_t>(room), std::back_inserter(all));
    }
    return all;
  }

  /// Scans one part of the order by relevance. False: stopped at the limit of rows, because the matches are too far apart.
  Result<bool> scan_kinds(int part, const std::optional<Position>& after, std::size_t limit, std::vector<Hit>& hits) const {
    for (const std::string& kind : kinds_) {
      Result<bool> done = scan_kind(kind, part, after, limit, hits);
      if (!done || !*done) return done;
    }
    const Column column = column_of(query_.order);
    const auto before = [&](const Hit& a, const Hit& b) {
      const Position &p = a.position, &q = b.position;
      if (p.key == q.key) return column.descending ? p.id > q.id : p.id < q.id;
      const bool less = column.number && p.key.size() != q.key.size() ? p.key.size() < q.key.size() : p.key < q.key;
      return column.descending ? !less : less;
    };
    std::ranges::sort(hits, before);
    return true;
  }

  /// Scans the entries of one kind in one part of the order by relevance. False: stopped at the limit of rows.
  Result<bool> scan_kind(const std::string& kind, int part, const std::optional<Position>& after, std::size_t limit,
                         std::vector<Hit>& hits) const {
    Sql sql;
    const std::string key = column_of(query_.order).name, order = " ORDER BY " + order_columns();
    std::string rows_of =
        " FROM entry e WHERE e.kind = " + sql.parameter(Value(kind)) + " AND e.removed IS " + (query_.removed ? "NOT NULL" : "NULL");
    if (by_relevance_ && part == 0) rows_of += " AND " + begins(sql);
    if (after) rows_of += " AND " + after_position(sql, *after);
    std::optional<Position> end;  // last row to scan; found with the table index alone, without reading rows
    if (by_index_) {
      const auto max_rows = static_cast<std::size_t>(static_cast<double>(body_.sort_limit) * dialect().scan_fraction) + 2 * (limit + 1);
      const Result<Rows> row =
          connection().query("SELECT " + key + ", e.id" + rows_of + order + " LIMIT 1 OFFSET " + std::to_string(max_rows), sql.values);
      if (!row) return fail(row.error());
      if (!row->empty()) end = Position{.part = part, .key = row->text(0, 0), .id = row->text(0, 1)};
    }
    if (end) rows_of += " AND " + up_to_position(sql, *end);
    sql.text = "SELECT " + std::string(entry_columns) + ", " + key + " AS key" + rows_of + " AND " + conditions(sql, part) + order +
               " LIMIT " + std::to_string(limit);
    const Result<Rows> rows = connection().query(sql.text, sql.values);
    if (!rows) return fail(rows.error());
    for (std::size_t r = 0; r < rows->size(); ++r) hits.push_back(hit_of(*rows, r, part));
    return !end || rows->size() == limit;
  }

  /// Without text and tags: counts the entries of the requested kinds.
  Result<void> count_all(LibraryPage& out) const {
    for (const std::string& kind : kinds_) {
      const Result<Rows> rows = connection().query(
          std::string("SELECT count(*) FROM entry e WHERE e.kind = ?1 AND e.removed IS ") + (query_.removed ? "NOT NULL" : "NULL"), {kind});
      if (!rows) return fail(rows.error());
      out.total += static_cast<std::size_t>(rows->integer(0, 0));
    }
    return {};
  }

  const LibraryBody& body_;
  const LibraryQuery& query_;
  SearchPhrases phrases_;
  std::vector<std::string> kinds_, tags_;
  bool by_relevance_ = false;
  bool by_index_ = false;  ///< the search index can find the matches: there is text or a tag, and the trash is not searched
};

}  // namespace

Result<LibraryPage> Library::find(const LibraryQuery& query) const {
  for (const std::string& kind : query.kinds)
    if (const Result<EntryKind> known = entry_kind_named(kind); !known) return fail(known.error());
  return Search(*body_, query).page();
}

}  // namespace ugoki::store
