// Fuzz target of sets of library entries that are imported (changed_database.h).
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "changed_database.h"
#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/store/copy.h"
#include "ugoki/store/library.h"
#include "ugoki/store/library_body.h"

namespace ugoki {
namespace {

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty());
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

std::string good_set(const Folder& folder) {
  const std::string path = folder.file("good.db");
  auto library = store::Library::open(":memory:");
  UGOKI_CHECK(library.has_value());
  library->set_author("Ann");
  const std::string body = R"({"a": 1})", walk = "walk";
  const std::string mechanism = store::entry_id(store::EntryKind::mechanism, bytes_of(body));
  auto ids = library->put(std::vector<store::LibraryItem>{
      {store::EntryKind::mechanism, "body", R"({"mass": 70})", {"own"}, bytes_of(body), "a note"},
      {store::EntryKind::motion, "walk", R"({"mechanism": ")" + mechanism + R"(", "duration": 2})", {"slow", "own"}, bytes_of(walk), ""}});
  UGOKI_CHECK(ids.has_value());
  UGOKI_CHECK(library->save({.id = (*ids)[1], .base = 1, .name = "walk on", .data = bytes_of("walk on")}).has_value());
  UGOKI_CHECK(library->set_thumbnail((*ids)[1], bytes_of("\x89PNG\r\n\x1a\n........")).has_value());
  const auto set = library->put(std::vector<store::LibraryItem>{
      {store::EntryKind::set, "both", "{}", {}, bytes_of("[\"" + (*ids)[0] + "\", \"" + (*ids)[1] + "\"]"), ""}});
  UGOKI_CHECK(set && store::export_set(*library, *set, path).has_value());
  return read_all(path);
}

/// Empties a library that is used for all inputs, because opening a database takes longer than importing a set.
store::Library& empty_library() {
  static store::Library library = [] {
    auto made = store::Library::open(":memory:");
    UGOKI_CHECK(made.has_value());
    return std::move(*made);
  }();
  UGOKI_CHECK(store::body_of(library).connection->script("DELETE FROM entry; DELETE FROM blob; DELETE FROM entry_text").has_value());
  return library;
}

}  // namespace

/// A library must be consistent after importing a set, however damaged the set is.
void fuzz_set(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  static const std::string good = good_set(folder);
  static bool good_was_read = false;
  folder.clear();
  const std::string path = folder.file("fuzz.db");
  const bool changed = make_changed(good, {reinterpret_cast<const char*>(data), size}, path);
  if (!changed && std::exchange(good_was_read, true)) return;
  const auto from = store::Library::open_read_only(path);
  if (!from) return check_error(from.error());
  store::Library& to = empty_library();
  const auto copied = store::copy_entries(*from, to);
  if (!copied) check_error(copied.error());
  const auto whole = to.check(false);
  UGOKI_CHECK(whole && whole->problems.empty());
  for (const char* text : {"", "own", "o"}) {
    const auto page = to.find({.text = text, .limit = 2, .order = store::LibraryOrder::relevance});
    UGOKI_CHECK(page.has_value());
    if (!page->next.empty())
      UGOKI_CHECK(to.find({.text = text, .limit = 2, .order = store::LibraryOrder::relevance, .after = page->next}).has_value());
    for (const store::LibraryEntry& e : page->entries) {
      UGOKI_CHECK(to.data(e.id).has_value() && to.history(e.id).has_value() && to.content(e.content).has_value());
      UGOKI_CHECK(to.save({.id = e.id, .base = e.version, .note = "again"}).has_value());
    }
  }
}

}  // namespace ugoki
