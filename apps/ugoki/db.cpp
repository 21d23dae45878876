// `ugoki db`: the library of mechanisms and motions.

#include <iterator>
#include <memory>

#include "output.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/motion_binary.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string library;
  std::vector<std::string> words, tags, kinds, add, remove, entries;
  std::string entry, name, out;
  bool json = false;
};

Json summary_of(const store::LibraryEntry& entry) {
  Json summary = Json::parse(entry.summary, nullptr, false);
  return summary.is_object() ? summary : Json::object();
}

Json entry_json(const store::LibraryEntry& entry) {
  return {
      {"id", entry.id},      {"kind", store::name_of(entry.kind)}, {"name", entry.name}, {"tags", entry.tags}, {"created", entry.created},
      {"bytes", entry.size}, {"summary", summary_of(entry)}};
}

std::string number_cell(const Json& summary, const char* key, int digits) {
  return summary.contains(key) && summary[key].is_number() ? to_fixed(summary[key].get<double>(), digits) : "-";
}

std::string joined(const std::vector<std::string>& words, const char* by) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : by) + word;
  return out;
}

/// Opens the library, to write if `write`, and hands it to `work`.
int with_library(const Options& options, bool write, const std::function<Result<void>(store::Library&)>& work) {
  const std::string path = library_path(options.library);
  Result<store::Library> library = write ? store::Library::open(path) : store::Library::open_read_only(path);
  if (!library) return print_error(library.error(), options.json);
  if (Result<void> done = work(*library); !done) return print_error(done.error(), options.json);
  return 0;
}

int list(const Options& options) {
  std::error_code ignored;
  const std::string path = library_path(options.library);
  // A library that does not exist yet is an empty one; looking does not make it.
  const bool none = !std::filesystem::exists(path, ignored);
  const auto show = [&](std::vector<store::LibraryEntry> entries) {
    if (options.json) {
      Json rows = Json::array();
      for (const store::LibraryEntry& entry : entries) rows.push_back(entry_json(entry));
      print_json({{"library", path}, {"entries", std::move(rows)}});
      return;
    }
    if (entries.empty())
      return print_line(options.words.empty() && options.tags.empty() ? "The library is empty. Put something in with: ugoki import FILE"
                                                                      : "Nothing fits.");
    std::vector<std::vector<std::string>> rows = {{"id", "kind", "name", "frames", "s", "freedoms", "kg", "tags"}};
    for (const store::LibraryEntry& entry : entries) {
      const Json summary = summary_of(entry);
      rows.push_back({entry.id, std::string(store::name_of(entry.kind)), entry.name, number_cell(summary, "frames", 0),
                      number_cell(summary, "duration", 2), number_cell(summary, "freedoms", 0), number_cell(summary, "mass", 1),
                      joined(entry.tags, ",")});
    }
    print_table(rows);
  };
  if (none) {
    show({});
    return 0;
  }
  return with_library(options, false, [&](store::Library& library) -> Result<void> {
    Result<std::vector<store::LibraryEntry>> entries = library.find({joined(options.words, " "), options.kinds, options.tags, 10'000});
    if (!entries) return fail(std::move(entries.error()));
    show(std::move(*entries));
    return {};
  });
}

int show(const Options& options) {
  return with_library(options, false, [&](store::Library& library) -> Result<void> {
    const Result<store::LibraryEntry> entry = library.resolve(options.entry);
    if (!entry) return fail(entry.error());
    if (options.json) {
      print_json(entry_json(*entry));
      return {};
    }
    print_line("id       " + entry->id);
    print_line("kind     " + std::string(store::name_of(entry->kind)));
    print_line("name     " + entry->name);
    print_line("tags     " + joined(entry->tags, ", "));
    print_line("created  " + entry->created);
    print_line("bytes    " + std::to_string(entry->size));
    for (const auto& [key, value] : summary_of(*entry).items())
      print_line(key + std::string(key.size() < 9 ? 9 - key.size() : 1, ' ') +
                 (value.is_string() ? value.get<std::string>() : value.dump()));
    return {};
  });
}

/// Runs `change` on each entry that the options name.
int change_entries(const Options& options, const std::vector<std::string>& names,
                   const std::function<Result<void>(store::Library&, const store::LibraryEntry&)>& change) {
  return with_library(options, true, [&](store::Library& library) -> Result<void> {
    std::vector<store::LibraryEntry> entries;
    for (const std::string& name : names) {  // all are found before anything is changed
      Result<store::LibraryEntry> entry = library.resolve(name);
      if (!entry) return fail(std::move(entry.error()));
      entries.push_back(std::move(*entry));
    }
    Json rows = Json::array();
    for (const store::LibraryEntry& entry : entries) {
      if (Result<void> done = change(library, entry); !done) return done;
      const Result<store::LibraryEntry> after = library.get(entry.id);
      rows.push_back(after ? entry_json(*after) : Json{{"id", entry.id}, {"removed", true}});
      if (!options.json) print_line(entry.id + "  " + (after ? after->name + "  " + joined(after->tags, ",") : "removed"));
    }
    if (options.json) print_json({{"entries", std::move(rows)}});
    return {};
  });
}

int export_entry(const Options& options) {
  return with_library(options, false, [&](store::Library& library) -> Result<void> {
    const Result<store::LibraryEntry> entry = library.resolve(options.entry);
    if (!entry) return fail(entry.error());
    Result<std::vector<std::byte>> data = library.data(entry->id);
    if (!data) return fail(std::move(data.error()));
    std::string form = entry->kind == store::EntryKind::mechanism ? "mechanism JSON" : "motion bytes";
    if (entry->kind == store::EntryKind::measured) {
      const Result<MeasuredMotion> measured = formats::read_measured_motion(*data, "library entry " + entry->id);
      if (!measured) return fail(measured.error());
      const std::string text = formats::write_bvh(*measured);
      const auto* p = reinterpret_cast<const std::byte*>(text.data());
      *data = {p, p + text.size()};
      form = "BVH";
    }
    if (Result<void> written = files::write_file(options.out, std::span<const std::byte>(*data)); !written) return written;
    if (options.json)
      print_json({{"id", entry->id}, {"file", options.out}, {"form", form}, {"bytes", data->size()}});
    else
      print_line("Wrote " + options.out + " (" + form + ", " + std::to_string(data->size()) + " bytes).");
    return {};
  });
}

}  // namespace

void add_db_verb(CLI::App& app, Action& action) {
  CLI::App* db = app.add_subcommand("db", "List, find and change what the library holds.");
  db->require_subcommand(1);
  db->footer("Example:\n  ugoki db list --kind motion\n  ugoki db find walk\n  ugoki db export walk walk.bvh");
  const auto add = [&](const char* name, const char* about, const char* example, const std::function<void(CLI::App&, Options&)>& declare,
                       int (*run)(const Options&)) {
    auto options = std::make_shared<Options>();
    CLI::App* verb = db->add_subcommand(name, about);
    declare(*verb, *options);
    verb->add_option("--library", options->library, "Library file (otherwise $UGOKI_LIBRARY or ~/.local/share/ugoki/library.db)");
    verb->add_flag("--json", options->json, "Print one JSON object");
    verb->footer("Example:\n  " + std::string(example));
    verb->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
  };
  const auto filters = [](CLI::App& verb, Options& o) {
    verb.add_option("--kind", o.kinds, "Only mechanism, motion or measured")
        ->delimiter(',')
        ->check(CLI::IsMember({"mechanism", "motion", "measured"}));
    verb.add_option("--tag", o.tags, "Only entries with these tags")->delimiter(',');
  };
  const auto one_entry = [](CLI::App& verb, Options& o) {
    verb.add_option("entry", o.entry, "Name, id or beginning of an id")->required();
  };
  add("list", "All entries.", "ugoki db list --kind motion --tag walk", filters, list);
  add(
      "find", "Entries with these words in name, tags or summary.", "ugoki db find cmu walk",
      [&](CLI::App& verb, Options& o) {
        verb.add_option("words", o.words, "Words, or their beginnings")->required();
        filters(verb, o);
      },
      list);
  add("show", "All about one entry.", "ugoki db show walk", one_entry, show);
  add(
      "tag", "Add and remove tags.", "ugoki db tag walk --add slow,cmu --remove new",
      [&](CLI::App& verb, Options& o) {
        verb.add_option("entries", o.entries, "Names or ids")->required();
        verb.add_option("--add", o.add, "Tags to add")->delimiter(',');
        verb.add_option("--remove", o.remove, "Tags to remove")->delimiter(',');
      },
      [](const Options& o) {
        return change_entries(o, o.entries,
                              [&](store::Library& l, const store::LibraryEntry& e) { return l.set_tags(e.id, o.add, o.remove); });
      });
  add(
      "rename", "Give an entry another name.", "ugoki db rename walk stroll",
      [&](CLI::App& verb, Options& o) {
        one_entry(verb, o);
        verb.add_option("name", o.name, "New name")->required();
      },
      [](const Options& o) {
        return change_entries(o, {o.entry}, [&](store::Library& l, const store::LibraryEntry& e) { return l.rename(e.id, o.name); });
      });
  add(
      "remove", "Take entries out.", "ugoki db remove walk",
      [&](CLI::App& verb, Options& o) { verb.add_option("entries", o.entries, "Names or ids")->required(); },
      [](const Options& o) {
        return change_entries(o, o.entries, [](store::Library& l, const store::LibraryEntry& e) { return l.remove(e.id); });
      });
  add(
      "export", "Write an entry to a file: a mechanism as JSON, measured data as BVH, a motion as bytes.", "ugoki db export walk walk.bvh",
      [&](CLI::App& verb, Options& o) {
        one_entry(verb, o);
        verb.add_option("file", o.out, "The file to write")->required();
      },
      export_entry);
}

}  // namespace ugoki::cli
