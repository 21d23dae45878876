// `ugoki db`: lists, shows and changes single entries of the library of mechanisms and motions.

#include "db_library.h"

#include <filesystem>
#include <memory>

#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"

namespace ugoki::cli {
namespace db {
namespace {

std::string number_cell(const Json& summary, const char* key, int digits) {
  return summary.contains(key) && summary[key].is_number() ? to_fixed(summary[key].get<double>(), digits) : "-";
}

/// Shortens a UTC time of the library to "2026-03-01 12:00".
std::string short_time(const std::string& time) { return time.size() > 16 ? time.substr(0, 10) + " " + time.substr(11, 5) : time; }

void print_entries(const Options& options, const std::string& location, const store::LibraryPage& page) {
  if (options.json) {
    Json rows = Json::array(), next = nullptr;
    for (const store::LibraryEntry& entry : page.entries) rows.push_back(entry_json(entry));
    if (!page.next.empty()) next = page.next;
    return print_json(
        {{"library", location}, {"entries", std::move(rows)}, {"next", next}, {"total", page.total}, {"total_exact", page.total_exact}});
  }
  if (page.entries.empty()) {
    const bool asked = !options.words.empty() || !options.tags.empty() || !options.kinds.empty() || !options.after.empty();
    return print_line(options.removed ? "The trash is empty."
                      : asked         ? "No entry matches."
                                      : "The library is empty. Add entries with: ugoki import FILE");
  }
  std::vector<std::vector<std::string>> rows = {{"id", "kind", "name", "frames", "s", "dofs", "kg", "version", "by", "changed", "tags"}};
  for (const store::LibraryEntry& entry : page.entries) {
    const Json summary = summary_of(entry);
    rows.push_back({entry.id, std::string(store::name_of(entry.kind)), entry.name, number_cell(summary, "frames", 0),
                    number_cell(summary, "duration", 2), number_cell(summary, "dofs", 0), number_cell(summary, "mass", 1),
                    std::to_string(entry.version), entry.author, short_time(entry.changed), joined(entry.tags, ",")});
  }
  print_table(rows);
  if (!page.next.empty())
    print_line(std::to_string(page.entries.size()) + " of " + (page.total_exact ? "" : "more than ") + std::to_string(page.total) +
               " entries. For the next page add: --after " + page.next);
}

int list_in(const Options& options, store::LibraryOrder usual) {
  const std::string location = library_path(options.library);
  // The user's own library is empty until something is imported; reading does not create it. A library named by --library must exist.
  if (options.library.empty() && !store::Library::exists(location)) {
    print_entries(options, location, {});
    return 0;
  }
  return with_library(options, Access::read, [&](store::Library& library) -> Result<void> {
    const Result<store::LibraryPage> page = library.find(query_of(options, usual));
    if (!page) return fail(page.error());
    print_entries(options, library.path(), *page);
    return {};
  });
}

int list(const Options& options) { return list_in(options, store::LibraryOrder::name); }
int find(const Options& options) { return list_in(options, store::LibraryOrder::relevance); }

int tags(const Options& options) {
  return with_library(options, Access::read, [&](store::Library& library) -> Result<void> {
    const auto found = library.tags(options.kinds);
    if (!found) return fail(found.error());
    Json rows = Json::array();
    std::vector<std::vector<std::string>> table = {{"tag", "entries"}};
    for (const auto& [name, count] : *found) {
      rows.push_back({{"name", name}, {"count", count}});
      table.push_back({name, std::to_string(count)});
    }
    if (options.json)
      print_json({{"tags", std::move(rows)}});
    else if (table.size() == 1)
      print_line("No entry has a tag.");
    else
      print_table(table);
    return {};
  });
}

int show(const Options& options) {
  return with_library(options, Access::read, [&](store::Library& library) -> Result<void> {
    const Result<store::LibraryEntry> entry = library.resolve(options.entry, {}, options.removed);
    if (!entry) return fail(entry.error());
    if (options.json) {
      print_json(entry_json(*entry));
      return {};
    }
    print_line("id       " + entry->id);
    print_line("kind     " + std::string(store::name_of(entry->kind)));
    print_line("name     " + entry->name);
    print_line("tags     " + joined(entry->tags, ", "));
    if (!entry->note.empty()) print_line("note     " + entry->note);
    print_line("created  " + entry->created);
    print_line("version  " + std::to_string(entry->version) + ", saved " + entry->changed +
               (entry->author.empty() ? "" : " by " + entry->author));
    print_line("content  " + entry->content);
    print_line("bytes    " + std::to_string(entry->size));
    if (!entry->removed.empty()) print_line("removed  " + entry->removed + " by " + entry->removed_by);
    const Json summary = summary_of(*entry);
    for (const auto& [key, value] : summary.items())
      print_line(key + std::string(key.size() < 9 ? 9 - key.size() : 1, ' ') +
                 (value.is_string() ? value.get<std::string>() : value.dump()));
    return {};
  });
}

int history(const Options& options) {
  return with_library(options, Access::read, [&](store::Library& library) -> Result<void> {
    Result<store::LibraryEntry> entry = library.resolve(options.entry, {}, options.removed);
    if (!entry) return fail(std::move(entry.error()));
    const Result<std::vector<store::LibraryVersion>> versions = library.history(entry->id);
    if (!versions) return fail(versions.error());
    Json rows = Json::array();
    std::vector<std::vector<std::string>> table = {{"version", "saved", "by", "name", "bytes", "content", "note"}};
    for (const store::LibraryVersion& v : *versions) {
      rows.push_back({{"version", v.version},
                      {"saved", v.saved},
                      {"by", v.author},
                      {"name", v.name},
                      {"note", v.note},
                      {"content", v.content},
                      {"bytes", v.size}});
      table.push_back({std::to_string(v.version), v.saved, v.author, v.name, std::to_string(v.size), v.content, v.note});
    }
    if (options.json)
      print_json({{"id", entry->id}, {"versions", std::move(rows)}});
    else
      print_table(table);
    return {};
  });
}

/// Runs `change` on each named entry. All names are resolved before the first change.
int change_entries(const Options& options, const std::vector<std::string>& names, bool removed,
                   const std::function<Result<void>(store::Library&, const store::LibraryEntry&)>& change) {
  return with_library(options, Access::write, [&](store::Library& library) -> Result<void> {
    std::vector<store::LibraryEntry> entries;
    for (const std::string& name : names) {
      Result<store::LibraryEntry> entry = library.resolve(name, {}, removed);
      if (!entry) return fail(std::move(entry.error()));
      entries.push_back(std::move(*entry));
    }
    Json rows = Json::array();
    for (const store::LibraryEntry& entry : entries) {
      if (Result<void> done = change(library, entry); !done) return done;
      const Result<store::LibraryEntry> after = library.get(entry.id);
      rows.push_back(after ? entry_json(*after) : Json{{"id", entry.id}, {"removed", true}});
      if (!options.json)
        print_line(
            entry.id + "  " +
            (after ? after->name + "  version " + std::to_string(after->version) + "  " + joined(after->tags, ",") : "in the trash"));
    }
    if (options.json) print_json({{"entries", std::move(rows)}});
    return {};
  });
}

using store::Library;
using store::LibraryEntry;

/// Version on which a change is based: --based-on, or else the newest version.
int base_of(const Options& o, const LibraryEntry& e) { return o.based_on > 0 ? o.based_on : e.version; }

Result<void> saved(const Result<LibraryEntry>& entry) {
  if (!entry) return fail(entry.error());
  return {};
}

int tag(const Options& o) {
  return change_entries(o, o.entries, false, [&](Library& l, const LibraryEntry& e) { return l.set_tags(e.id, o.add, o.remove); });
}
int untag(const Options& o) {
  return change_entries(o, {o.entry}, false, [&](Library& l, const LibraryEntry& e) { return l.set_tags(e.id, {}, o.tags); });
}
int rename(const Options& o) {
  return change_entries(o, {o.entry}, false, [&](Library& l, const LibraryEntry& e) {
    return saved(l.save({.id = e.id, .base = base_of(o, e), .name = o.name}));
  });
}
int note(const Options& o) {
  return change_entries(o, {o.entry}, false, [&](Library& l, const LibraryEntry& e) {
    return saved(l.save({.id = e.id, .base = base_of(o, e), .note = o.note}));
  });
}
int restore(const Options& o) {
  return change_entries(o, {o.entry}, false,
                        [&](Library& l, const LibraryEntry& e) { return saved(l.restore(e.id, base_of(o, e), o.version)); });
}
int remove(const Options& o) {
  return change_entries(o, o.entries, false, [](Library& l, const LibraryEntry& e) { return l.remove(e.id); });
}
int undelete(const Options& o) {
  return change_entries(o, o.entries, true, [](Library& l, const LibraryEntry& e) { return l.undelete(e.id); });
}
int save(const Options& o) {
  const Result<std::string> text = files::read_file(o.file);
  if (!text) return print_error(text.error(), o.json);
  const auto* p = reinterpret_cast<const std::byte*>(text->data());
  store::LibrarySave next;
  next.data.emplace(p, p + text->size());
  if (!o.note.empty()) next.note = o.note;
  return change_entries(o, {o.entry}, false, [&](Library& l, const LibraryEntry& e) {
    if (Result<void> good = check_data(e.kind, *text, o.file); !good) return good;
    next.id = e.id;
    next.base = base_of(o, e);
    return saved(l.save(next));
  });
}

int thumbnail(const Options& o) {
  if (o.clear) return change_entries(o, {o.entry}, false, [&](Library& l, const LibraryEntry& e) { return l.set_thumbnail(e.id, {}); });
  if (!o.file.empty()) {
    const Result<std::string> picture = files::read_file(o.file);
    if (!picture) return print_error(picture.error(), o.json);
    return change_entries(o, {o.entry}, false,
                          [&](Library& l, const LibraryEntry& e) { return l.set_thumbnail(e.id, std::as_bytes(std::span(*picture))); });
  }
  return with_library(o, Access::read, [&](Library& library) -> Result<void> {
    const Result<LibraryEntry> entry = library.resolve(o.entry);
    if (!entry) return fail(entry.error());
    const Result<std::vector<std::byte>> picture = library.thumbnail(entry->id);
    if (!picture) return fail(picture.error());
    if (picture->empty())
      return fail(ErrorCode::unknown, entry->id, "'" + entry->name + "' has no thumbnail.", "Set one with --set PICTURE.");
    if (o.to.empty())
      return fail(ErrorCode::structure, entry->id, "No destination is given for the thumbnail.",
                  "Add --to FILE, or --set PICTURE to change the thumbnail.");
    if (Result<void> may = check_outputs({}, {{"--to", o.to}}); !may) return may;
    if (Result<void> written = files::write_file(o.to, std::span<const std::byte>(*picture)); !written) return written;
    o.json ? print_json({{"id", entry->id}, {"file", o.to}, {"bytes", picture->size()}}) : print_line("Wrote " + o.to + ".");
    return {};
  });
}

void declare_base(Verb verb, Options& o) {
  verb.add_option("--based-on", o.based_on, "Version that the change is based on (default: the newest); a later version is a conflict")
      .check(range(1, 1'000'000'000));
  declare_author(verb, o);
}

}  // namespace

void Verbs::add(const char* name, const char* about, const char* example, const Declare& declare, int (*run)(const Options&)) const {
  auto options = std::make_shared<Options>();
  Verb verb = parent.add_subcommand(name, about);
  declare(verb, *options);
  verb.add_option("--library", options->library,
                  "Library: a file or postgresql://USER@HOST/DATABASE (default: $UGOKI_LIBRARY or ~/.local/share/ugoki/library.db)");
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  " + std::string(example));
  Action& then = action;
  verb.callback([options, run, &then] { then = [options, run] { return run(*options); }; });
}

void declare_filters(Verb verb, Options& o) {
  verb.add_option("--kind", o.kinds, "Only mechanism, motion, measured, circuit or set")
      .delimiter(',')
      .check(one_of({"mechanism", "motion", "measured", "circuit", "set"}));
  verb.add_option("--tag", o.tags, "Only entries with these tags").delimiter(',');
}

void declare_entry(Verb verb, Options& o) { verb.add_option("entry", o.entry, "Name, id or first characters of an id").required(); }
void declare_entries(Verb verb, Options& o) { verb.add_option("entries", o.entries, "Names, ids or first characters of ids").required(); }
void declare_author(Verb verb, Options& o) {
  verb.add_option("--author", o.author, "Author of the change (default: $UGOKI_AUTHOR or the user's name)");
}

int with_library(const Options& options, Access access, const std::function<Result<void>(Library&)>& work) {
  const std::string location = library_path(options.library);
  Result<Library> library = access == Access::write ? Library::open(location) : Library::open_read_only(location);
  if (!library) return print_error(library.error(), options.json);
  print_warning(library->warning());
  library->set_author(options.author);
  if (Result<void> done = work(*library); !done) return print_error(done.error(), options.json);
  return 0;
}

store::LibraryQuery query_of(const Options& options, store::LibraryOrder usual) {
  store::LibraryQuery query;
  query.text = joined(options.words, " ");
  query.kinds = options.kinds;
  query.tags = options.tags;
  query.limit = options.limit;
  query.after = options.after;
  query.removed = options.removed;
  query.order =
      options.order.empty() ? usual : store::library_order_named(options.order).value_or(usual);  // the options' check has validated it
  return query;
}

Json summary_of(const LibraryEntry& entry) {
  Json summary = Json::parse(entry.summary, nullptr, false);
  json::rename_field(summary, "freedoms", "dofs");  // the field's name in summaries written by earlier versions
  return summary.is_object() ? summary : Json::object();
}

Json entry_json(const LibraryEntry& e) {
  Json json = {
      {"id", e.id},           {"kind", store::name_of(e.kind)}, {"name", e.name},          {"tags", e.tags}, {"note", e.note},
      {"created", e.created}, {"version", e.version},           {"content", e.content},    {"by", e.author}, {"changed", e.changed},
      {"bytes", e.size},      {"thumbnail", e.thumbnail},       {"summary", summary_of(e)}};
  if (!e.removed.empty()) json.update({{"removed", e.removed}, {"removed_by", e.removed_by}});
  return json;
}

std::string joined(const std::vector<std::string>& words, const char* by) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : by) + word;
  return out;
}

}  // namespace db

void add_db_verb(Verb app, Action& action) {
  using namespace db;
  Verb parent = app.add_subcommand("db", "List, find and change the entries of the library.");
  parent.require_subcommand(1);
  parent.footer(
      "Example:\n  ugoki db list --kind motion\n  ugoki db find walk\n  ugoki db copy library.db postgresql://anna@server/motions");
  const Verbs verbs{parent, action};
  const auto lists = [](Verb verb, Options& o) {
    declare_filters(verb, o);
    verb.add_option("--order", o.order, "relevance, name, newest, oldest, longest or shortest")
        .check(one_of({"relevance", "name", "newest", "oldest", "longest", "shortest"}));
    verb.add_option("--limit", o.limit, "Maximum number of entries").check(range(1, 10'000)).capture_default_str();
    verb.add_option("--after", o.after, "Start after the previous page; the value is printed with it");
    verb.add_flag("--removed", o.removed, "List the trash instead");
  };
  verbs.add("list", "List all entries.", "ugoki db list --kind motion --tag walk --order newest", lists, list);
  const auto words = [&](Verb verb, Options& o) {
    verb.add_option("words", o.words, "Words or beginnings of words; an entry must contain all of them").required();
    lists(verb, o);
  };
  verbs.add("find", "Find entries with these words in name, tags, note or summary.", "ugoki db find cmu walk", words, find);
  verbs.add("search", "Same as `find`.", "ugoki db search 02_01 --limit 20", words, find);
  verbs.add("tags", "List all tags with their number of entries.", "ugoki db tags --kind motion", declare_filters, tags);
  const auto one = [](Verb verb, Options& o) {
    declare_entry(verb, o);
    verb.add_flag("--removed", o.removed, "Look in the trash");
  };
  verbs.add("show", "Show all data of one entry.", "ugoki db show walk", one, show);
  verbs.add("history", "List all versions of an entry: author, changes and time.", "ugoki db history walk", one, history);
  verbs.add(
      "tag", "Add and remove tags.", "ugoki db tag walk --add slow,cmu --remove new",
      [](Verb verb, Options& o) {
        declare_entries(verb, o);
        verb.add_option("--add", o.add, "Tags to add").delimiter(',');
        verb.add_option("--remove", o.remove, "Tags to remove").delimiter(',');
      },
      tag);
  verbs.add(
      "untag", "Remove tags.", "ugoki db untag walk slow cmu",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("tags", o.tags, "Tags to remove").required();
      },
      untag);
  verbs.add(
      "rename", "Rename an entry (creates a new version).", "ugoki db rename walk stroll",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("name", o.name, "New name").required();
        declare_base(verb, o);
      },
      rename);
  verbs.add(
      "note", "Set the note of an entry (creates a new version).", "ugoki db note walk 'left knee is noisy'",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("note", o.note, "The note; '' removes it").required();
        declare_base(verb, o);
      },
      note);
  verbs.add(
      "save", "Save a file's bytes as the new version of an entry.", "ugoki db save body body.json --based-on 3 --note 'longer arms'",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("file", o.file, "The data, in the format that `db export` writes").required();
        verb.add_option("--note", o.note, "New note (default: unchanged)");
        declare_base(verb, o);
      },
      save);
  verbs.add(
      "restore", "Save an old version again as the newest one.", "ugoki db restore walk 2",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("version", o.version, "The old version").required().check(range(1, 1'000'000'000));
        declare_base(verb, o);
      },
      restore);
  const auto many = [](Verb verb, Options& o) {
    declare_entries(verb, o);
    declare_author(verb, o);
  };
  verbs.add("remove", "Move entries to the trash.", "ugoki db remove walk", many, remove);
  verbs.add("undelete", "Restore entries from the trash.", "ugoki db undelete walk", many, undelete);
  verbs.add(
      "thumbnail", "Write an entry's thumbnail to a file, or replace it.", "ugoki db thumbnail walk --set walk.png",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        verb.add_option("--to", o.to, "Write the thumbnail to this file");
        const Option set = verb.add_option("--set", o.file, "A PNG or WebP of at most 256 KB that becomes the thumbnail");
        verb.add_flag("--clear", o.clear, "Remove the thumbnail").excludes(set);
      },
      thumbnail);
  add_set_verbs(verbs);
}

}  // namespace ugoki::cli
