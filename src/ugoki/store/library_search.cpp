// Searching and browsing.
//
// Two ways, the same on both databases, chosen so that no search reads all rows of a large library:
// - few fit: the index of words (which knows kinds and tags as well) gives the entries, these are sorted;
// - many fit, or nothing is asked for: the entries are read in the order asked for, from the place where the page begins, and each is
//   looked at; a page is soon full because many fit. The words of an entry stand in one text, so that "has these words in a row" is
//   "contains this text", which means exactly what the index of words means. Where those that fit stand far from where the page begins,
//   that would take long: after some rows it is given up, and what fits is sorted after all.
// How many are few depends on how fast a database sorts what its index found (Dialect).

#include <algorithm>
#include <array>
#include <charconv>

#include "ugoki/base/base64.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

/// Relevance comes in three parts, one after the other: names that begin with the text, names that hold it, the others.
constexpr int relevance_parts = 3;

/// How many fit: at most `few`, more, or so many that reading in order finds a page at once. Later pages need not count again.
enum class Crowd : std::uint8_t { few, many, most };

/// A place in the order: entries behind it follow.
struct Position {
  int part = 0;
  std::string key, id;
  Crowd crowd = Crowd::few;
};

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

std::string text_of(const Position& position, LibraryOrder order) {
  const std::string text = std::to_string(static_cast<int>(order)) + "," + std::to_string(position.part) + "," +
                           std::to_string(static_cast<int>(position.crowd)) + "," + position.id + "," + position.key;
  return to_base64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Result<Position> position_of(const std::string& text, LibraryOrder order) {
  const auto wrong = [] {
    return fail(ErrorCode::range, "after", "This is no place in this list.",
                "Give `next` of the page before, and otherwise the same query.");
  };
  const std::optional<std::vector<std::uint8_t>> bytes = from_base64(text);
  if (!bytes) return wrong();
  const std::string_view all(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::array<std::string_view, 5> fields;
  std::size_t at = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::size_t end = i + 1 < fields.size() ? all.find(',', at) : all.size();
    if (end == std::string_view::npos) return wrong();
    fields[i] = all.substr(at, end - at);
    at = end + 1;
  }
  int part = -1;
  std::from_chars(fields[1].data(), fields[1].data() + fields[1].size(), part);
  const bool number = column_of(order).number;
  const bool digits = !fields[4].empty() && fields[4].size() < 18 && fields[4].find_first_not_of("0123456789") == std::string_view::npos;
  if (fields[0] != std::to_string(static_cast<int>(order)) || part < 0 || part >= relevance_parts || (number && !digits) ||
      fields[2].size() != 1 || fields[2][0] < '0' || fields[2][0] > '2' || clean_text(all) != all)
    return wrong();
  return Position{part, std::string(fields[4]), std::string(fields[3]), static_cast<Crowd>(fields[2][0] - '0')};
}

/// A statement that grows, with the values of its parameters.
struct Sql {
  std::string text;
  std::vector<Value> values;
  std::vector<std::unique_ptr<std::string>> owned;

  std::string parameter(const Value& value) {
    values.push_back(value);
    return "?" + std::to_string(values.size());
  }
  std::string parameter(std::string value) {
    owned.push_back(std::make_unique<std::string>(std::move(value)));
    return parameter(Value(*owned.back()));
  }
};

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
    Crowd crowd = after ? after->crowd : Crowd::few;
    if (by_index_ && crowd == Crowd::few) {
      const Result<std::size_t> total = count_matches(Among::all);
      if (!total) return fail(total.error());
      out.total = std::min(*total, body_.few);
      crowd = *total > sorted_at_most() ? Crowd::most : *total > body_.few ? Crowd::many : Crowd::few;
    }
    if (filtered && (query_.removed || crowd != Crowd::few)) {
      out.total = body_.few;
      out.total_exact = false;
    }
    Result<std::vector<Hit>> hits = by_index_ && crowd != Crowd::most ? sorted(after, Among::all) : walk(after);
    if (!hits) return fail(std::move(hits.error()));
    if (hits->size() > query_.limit) {
      hits->resize(query_.limit);
      Position last = hits->back().position;
      last.crowd = crowd;
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
  enum class Among : std::uint8_t { all, named, unnamed };  ///< all that fit, those with the text in their name, the others
  struct Hit {
    Position position;
    EntryRow row;
  };
  [[nodiscard]] Connection& connection() const { return *body_.connection; }
  [[nodiscard]] const Dialect& dialect() const { return connection().dialect(); }

  /// The entries that fit, by the index of words, as `hit`.
  [[nodiscard]] std::string match(Sql& sql, Among among) const {
    const bool in_name = among == Among::named;
    const std::vector<std::string>& kinds = query_.kinds;
    const auto with = [&](std::string text, std::string query) {
      return text.replace(text.find("{query}"), 7, sql.parameter(std::move(query)));
    };
    if (!dialect().postgres) return with(dialect().match, phrases_.fts5(in_name, tags_, kinds));
    const std::string others = among == Among::unnamed ? " & !(" + phrases_.tsquery(true, {}, {}, false) + ")" : "";
    std::string out = with(dialect().match, phrases_.tsquery(in_name, tags_, kinds, false) + others);
    if (phrases_.any_longer_than_pairs()) out += with(dialect().in_a_row, phrases_.tsquery(in_name, {}, {}, true));
    return out;
  }
  /// More than so many are read in order. What the index does not know for sure is dearer.
  [[nodiscard]] std::size_t sorted_at_most() const {
    return body_.few * static_cast<std::size_t>(phrases_.any_longer_than_pairs() ? 1 : dialect().sorts);
  }
  /// How many they are, at most one more than are sorted.
  Result<std::size_t> count_matches(Among among) const {
    Sql sql;
    const std::string select = match(sql, among);
    const Result<Rows> rows = connection().query(
        "SELECT count(*) FROM (SELECT 1 FROM (" + select + ") x LIMIT " + std::to_string(sorted_at_most() + 1) + ") y", sql.values);
    if (!rows) return fail(rows.error());
    return static_cast<std::size_t>(rows->integer(0, 0));
  }

  /// What an entry must fulfil, said of its own row.
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

  std::string begins(Sql& sql) const {
    return "(e.name_key >= " + sql.parameter(Value(phrases_.key)) + " AND e.name_key < " +
           sql.parameter(phrases_.key + "\xf4\x8f\xbf\xbf") + ")";
  }
  std::string in_name(Sql& sql) const {
    std::string out;
    for (std::size_t i = 0; i < phrases_.phrases.size(); ++i)
      out += (i ? " AND " : "(") + dialect().instr + "(' ' || e.name_key, " + sql.parameter(phrases_.in_words(i)) + ") > 0";
    return out + ")";
  }
  /// Behind `place` in the order, within one part.
  std::string behind(Sql& sql, const Position& place) const { return compared(sql, column_of(query_.order).descending ? "<" : ">", place); }
  std::string until(Sql& sql, const Position& place) const {
    return compared(sql, column_of(query_.order).descending ? ">=" : "<=", place);
  }
  std::string compared(Sql& sql, const char* how, const Position& place) const {
    const Column column = column_of(query_.order);
    const std::string key = column.number ? place.key : sql.parameter(Value(place.key));  // a number was checked to be digits
    return std::string("(") + column.name + ", e.id) " + how + " (" + key + ", " + sql.parameter(Value(place.id)) + ")";
  }
  std::string in_order() const {
    const Column column = column_of(query_.order);
    const std::string way = column.descending ? " DESC" : "";
    return std::string(column.name) + way + ", e.id" + way;
  }

  static Hit hit_of(const Rows& rows, std::size_t r, int part) {
    Hit hit;
    hit.row = entry_of(rows, r);
    hit.position = {.part = part, .key = rows.text(r, entry_column_count), .id = hit.row.id};
    return hit;
  }

  /// What the index of words gives, sorted. Only what is compared is sorted; the rows of the page are fetched afterwards.
  /// @param among all: all parts; otherwise only part 1 (the text is in the name, which does not begin with it), or only part 2
  /// @return a page, and one more if there is
  Result<std::vector<Hit>> sorted(const std::optional<Position>& after, Among among) const {
    Sql sql;
    const bool names = among == Among::named;
    sql.text = "WITH hit AS " + std::string(dialect().postgres ? "NOT " : "") + "MATERIALIZED (" + match(sql, among) + ") ";
    std::string part = names ? "1" : among == Among::unnamed ? "2" : "0";
    if (by_relevance_ && among == Among::all) part = "CASE WHEN " + begins(sql) + " THEN 0 WHEN " + in_name(sql) + " THEN 1 ELSE 2 END";
    const Column column = column_of(query_.order);
    const std::string narrow = "SELECT e.no, e.id, " + std::string(column.name) + " AS key, " + part + " AS part FROM " + dialect().hits +
                               (names ? " WHERE NOT " + begins(sql) : "");
    std::string place;
    if (after) {
      // The parts are compared first: each is a list of its own.
      const std::string here = std::to_string(after->part), key = column.number ? after->key : sql.parameter(Value(after->key));
      place = " WHERE s.part > " + here + " OR (s.part = " + here + " AND (s.key, s.id) " + (column.descending ? "<" : ">") + " (" + key +
              ", " + sql.parameter(Value(after->id)) + "))";
    }
    const std::string way = column.descending ? " DESC" : "", order = " ORDER BY s.part, s.key" + way + ", s.id" + way;
    sql.text += ", page AS MATERIALIZED (SELECT * FROM (" + narrow + ") s" + place + order + " LIMIT " + std::to_string(query_.limit + 1) +
                ") SELECT " + entry_columns + ", s.key, s.part FROM page s LEFT JOIN entry e ON e.no = s.no" + order;
    const Result<Rows> rows = connection().query(sql.text, sql.values);
    if (!rows) return fail(rows.error());
    std::vector<Hit> out;
    for (std::size_t r = 0; r < rows->size(); ++r)
      out.push_back(hit_of(*rows, r, static_cast<int>(rows->integer(r, entry_column_count + 1))));
    return out;
  }

  /// Many fit: part by part and kind by kind, each in the order of its index; the kinds are merged.
  Result<std::vector<Hit>> walk(const std::optional<Position>& after) const {
    std::vector<Hit> all;
    for (int part = after ? after->part : 0; part < (by_relevance_ ? relevance_parts : 1) && all.size() <= query_.limit; ++part) {
      const std::optional<Position> from = after && part == after->part ? after : std::nullopt;
      Result<std::size_t> by_name = sorted_at_most() + 1;
      if (part == 1) by_name = count_matches(Among::named);  // many fit, but perhaps few by their name alone
      if (!by_name) return fail(std::move(by_name.error()));
      Result<std::vector<Hit>> hits;
      if (*by_name <= sorted_at_most()) {
        hits = sorted(from, Among::named);
        if (!hits) return hits;
      } else {
        const Result<bool> done = walk_kinds(part, from, query_.limit + 1 - all.size(), *hits);
        if (!done) return fail(done.error());
        // The index of PostgreSQL knows what is in no name, unless three words must stand in a row.
        const bool rest = by_relevance_ && part == 2 && dialect().postgres && !phrases_.any_longer_than_pairs();
        if (!*done && !rest) return sorted(after, Among::all);
        if (!*done) hits = sorted(from, Among::unnamed);
        if (!hits) return hits;
      }
      const std::size_t room = std::min(hits->size(), query_.limit + 1 - all.size());
      std::move(hits->begin(), hits->begin() + static_cast<std::ptrdiff_t>(room), std::back_inserter(all));
    }
    return all;
  }

  /// One part. False: given up, because those that fit are too far apart.
  Result<bool> walk_kinds(int part, const std::optional<Position>& after, std::size_t limit, std::vector<Hit>& hits) const {
    for (const std::string& kind : kinds_) {
      Result<bool> done = walk_kind(kind, part, after, limit, hits);
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

  Result<bool> walk_kind(const std::string& kind, int part, const std::optional<Position>& after, std::size_t limit,
                         std::vector<Hit>& hits) const {
    Sql sql;
    const std::string key = column_of(query_.order).name, order = " ORDER BY " + in_order();
    std::string rows_of =
        " FROM entry e WHERE e.kind = " + sql.parameter(Value(kind)) + " AND e.removed IS " + (query_.removed ? "NOT NULL" : "NULL");
    if (by_relevance_ && part == 0) rows_of += " AND " + begins(sql);
    if (after) rows_of += " AND " + behind(sql, *after);
    std::optional<Position> end;  // that far it is looked; the index alone tells where that is
    if (by_index_) {
      const auto most = static_cast<std::size_t>(static_cast<double>(body_.few) * dialect().walks) + 2 * (limit + 1);
      const Result<Rows> row =
          connection().query("SELECT " + key + ", e.id" + rows_of + order + " LIMIT 1 OFFSET " + std::to_string(most), sql.values);
      if (!row) return fail(row.error());
      if (!row->empty()) end = Position{.part = part, .key = row->text(0, 0), .id = row->text(0, 1)};
    }
    if (end) rows_of += " AND " + until(sql, *end);
    sql.text = "SELECT " + std::string(entry_columns) + ", " + key + " AS key" + rows_of + " AND " + conditions(sql, part) + order +
               " LIMIT " + std::to_string(limit);
    const Result<Rows> rows = connection().query(sql.text, sql.values);
    if (!rows) return fail(rows.error());
    for (std::size_t r = 0; r < rows->size(); ++r) hits.push_back(hit_of(*rows, r, part));
    return !end || rows->size() == limit;
  }

  /// Browsing: how many entries of the kinds there are.
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
  bool by_index_ = false;  ///< the index of words tells what fits
};

}  // namespace

Result<LibraryPage> Library::find(const LibraryQuery& query) const {
  for (const std::string& kind : query.kinds)
    if (const Result<EntryKind> known = entry_kind_named(kind); !known) return fail(known.error());
  return Search(*body_, query).page();
}

}  // namespace ugoki::store
