// `ugoki db`: verbs for many entries at once, and maintenance of a library.

#include <memory>

#include "db_library.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/store/copy.h"

namespace ugoki::cli::db {
namespace {

using store::Library;
using store::LibraryEntry;

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

int export_entry(const Options& options) {
  return with_library(options, Access::read, [&](Library& library) -> Result<void> {
    const Result<LibraryEntry> entry = library.resolve(options.entry);
    if (!entry) return fail(entry.error());
    Result<std::vector<std::byte>> data = library.data(entry->id, options.version);
    if (!data) return fail(std::move(data.error()));
    const bool text_form = entry->kind != store::EntryKind::motion;
    std::string form = entry->kind == store::EntryKind::mechanism ? "mechanism JSON" : text_form ? "JSON" : "motion bytes";
    if (entry->kind == store::EntryKind::measured) {
      const Result<MeasuredMotion> measured = formats::read_measured_motion(*data, "library entry " + entry->id);
      if (!measured) return fail(measured.error());
      *data = bytes_of(formats::write_bvh(*measured));
      form = "BVH";
    }
    if (Result<void> may = check_outputs({}, {{"the output", options.file}}); !may) return may;
    if (Result<void> written = files::write_file(options.file, std::span<const std::byte>(*data)); !written) return written;
    if (options.json)
      print_json({{"id", entry->id}, {"file", options.file}, {"form", form}, {"bytes", data->size()}});
    else
      print_line("Wrote " + options.file + " (" + form + ", " + std::to_string(data->size()) + " bytes).");
    return {};
  });
}

/// Ids of the named entries, or of all entries that match the filters.
Result<std::vector<std::string>> chosen(const Options& options, const Library& library) {
  std::vector<std::string> ids;
  for (const std::string& name : options.entries) {
    Result<LibraryEntry> entry = library.resolve(name);
    if (!entry) return fail(std::move(entry.error()));
    ids.push_back(entry->id);
  }
  if (!options.entries.empty() && options.words.empty() && options.tags.empty() && options.kinds.empty()) return ids;
  store::LibraryQuery query = query_of(options, store::LibraryOrder::name);
  query.limit = 10'000;
  do {
    Result<store::LibraryPage> page = library.find(query);
    if (!page) return fail(std::move(page.error()));
    for (const LibraryEntry& entry : page->entries) ids.push_back(entry.id);
    query.after = page->next;
  } while (!query.after.empty());
  return ids;
}

store::CopyOptions copy_options(const Options& options, Progress& progress) {
  store::CopyOptions copy;
  copy.latest_only = options.latest;
  copy.save_differing = options.theirs;
  copy.progress = [&progress](double done) { progress.show(done); };
  copy.stop = [] { return interrupted(); };
  return copy;
}

void print_report(const Options& options, const store::CopyReport& report, const std::string& to) {
  if (options.json)
    return print_json({{"to", to},
                       {"added", report.added},
                       {"continued", report.continued},
                       {"equal", report.equal},
                       {"saved", report.saved},
                       {"differing", report.differing},
                       {"versions", report.versions},
                       {"blobs", report.blobs}});
  print_line(to + ": " + std::to_string(report.added) + " entries are new, " + std::to_string(report.continued) +
             " received newer versions, " + std::to_string(report.equal) + " were already present" +
             (report.saved ? ", " + std::to_string(report.saved) + " were saved as newer versions of entries changed on both sides" : "") +
             " (" + std::to_string(report.versions) + " versions written).");
  for (const std::string& entry : report.differing) print_line("changed on both sides, kept as in the destination: " + entry);
  if (!report.differing.empty())
    print_line("Compare them, then use --theirs to save the source's versions as the newest; both stay in the history.");
}

int export_set(const Options& options) {
  catch_interrupt();
  return with_library(options, Access::read, [&](Library& library) -> Result<void> {
    const Result<std::vector<std::string>> ids = chosen(options, library);
    if (!ids) return fail(ids.error());
    if (ids->empty())
      return fail(ErrorCode::unknown, library.path(), "No entry matches, so there is nothing to export.", "Change the filters.");
    Progress progress("export");
    const Result<store::CopyReport> report = store::export_set(library, *ids, options.file, copy_options(options, progress));
    progress.clear();
    if (!report) return fail(report.error());
    print_report(options, *report, options.file);
    return {};
  });
}

/// Copies from one library to another, both given by file or address.
int copy_between(const Options& options, const std::string& from_place, const std::string& to_place) {
  catch_interrupt();
  if (!Library::exists(from_place))
    return print_error({ErrorCode::io, from_place, "The library does not exist.", "Check its name."}, options.json);
  const Result<Library> from = Library::open_read_only(from_place);
  if (!from) return print_error(from.error(), options.json);
  print_warning(from->warning());
  Result<Library> to = Library::open(to_place);
  if (!to) return print_error(to.error(), options.json);
  print_warning(to->warning());
  Progress progress("copy");
  const Result<store::CopyReport> report = store::copy_entries(*from, *to, copy_options(options, progress));
  progress.clear();
  if (!report) return print_error(report.error(), options.json);
  print_report(options, *report, to->path());
  return report->differing.empty() ? 0 : 1;
}

int import_set(const Options& options) { return copy_between(options, options.file, library_path(options.library)); }
int copy(const Options& options) { return copy_between(options, options.file, options.to); }

/// Adds one new entry to the library and prints the entry.
int put_entry(const Options& options, store::LibraryItem item) {
  item.tags = options.tags;
  item.note = options.note;
  return with_library(options, Access::write, [&](Library& library) -> Result<void> {
    const Result<std::vector<std::string>> ids = library.put({&item, 1});
    if (!ids) return fail(ids.error());
    const Result<LibraryEntry> entry = library.get(ids->front());
    if (!entry) return fail(entry.error());
    options.json ? print_json(entry_json(*entry)) : print_line(entry->id + "  " + entry->name);
    return {};
  });
}

int add(const Options& options) {
  const Result<std::string> text = files::read_file(options.file);
  if (!text) return print_error(text.error(), options.json);
  if (const Result<void> good = check_data(store::EntryKind::circuit, *text, options.file); !good)
    return print_error(good.error(), options.json);
  store::LibraryItem item;
  item.kind = store::EntryKind::circuit;
  const std::string file = options.file.substr(options.file.find_last_of('/') + 1);
  item.name = options.name.empty() ? file.substr(0, file.rfind('.')) : options.name;
  item.summary = json::to_text({{"source", file}});
  item.data = bytes_of(*text);
  return put_entry(options, std::move(item));
}

int collect(const Options& options) {
  store::LibraryItem item;
  item.kind = store::EntryKind::set;
  item.name = options.name;
  Json list = Json::array();
  const int status = with_library(options, Access::write, [&](Library& library) -> Result<void> {
    const Result<std::vector<std::string>> ids = chosen(options, library);
    if (!ids) return fail(ids.error());
    if (ids->empty())
      return fail(ErrorCode::unknown, library.path(), "No entry matches, so there is nothing to collect.",
                  "Name entries, or change the filters.");
    for (const std::string& id : *ids) list.push_back(id);
    return {};
  });
  if (status != 0) return status;
  item.summary = json::to_text({{"entries", list.size()}});
  item.data = bytes_of(json::to_text(list));
  Options plain = options;
  plain.tags.clear();  // --tag selected the entries; the set has no tags
  return put_entry(plain, std::move(item));
}

int check(const Options& options) {
  bool well = true;
  const int status = with_library(options, options.repair ? Access::write : Access::read, [&](Library& library) -> Result<void> {
    Progress progress("check");
    const Result<store::LibraryCheck> report = library.check(options.repair, [&](double done) { progress.show(done); });
    progress.clear();
    if (!report) return fail(report.error());
    well = report->problems.empty();
    if (options.json) {
      Json problems = json::error_json(report->problems)["problems"];
      print_json({{"library", library.path()},
                  {"entries", report->entries},
                  {"versions", report->versions},
                  {"blobs", report->blobs},
                  {"bytes", report->bytes},
                  {"problems", std::move(problems)}});
      return {};
    }
    print_line(std::to_string(report->entries) + " entries, " + std::to_string(report->versions) + " versions, " +
               std::to_string(report->blobs) + " data blobs (" + std::to_string(report->bytes) +
               " bytes): " + (well ? "no problems found." : "problems were found."));
    for (const Problem& problem : report->problems.problems) print_line(problem.text());
    return {};
  });
  return status != 0 ? status : well ? 0 : 1;
}

int collect_garbage(const Options& options) {
  return with_library(options, Access::write, [&](Library& library) -> Result<void> {
    const Result<std::uint64_t> bytes = library.collect_garbage();
    if (!bytes) return fail(bytes.error());
    options.json ? print_json({{"library", library.path()}, {"freed_bytes", *bytes}})
                 : print_line("Freed " + std::to_string(*bytes) + " bytes.");
    return {};
  });
}

int empty_trash(const Options& options) {
  return with_library(options, Access::write, [&](Library& library) -> Result<void> {
    const Result<std::size_t> count = library.empty_trash(options.before);
    if (!count) return fail(count.error());
    const Result<std::uint64_t> bytes = library.collect_garbage();
    if (!bytes) return fail(bytes.error());
    if (options.json)
      print_json({{"library", library.path()}, {"removed", *count}, {"freed_bytes", *bytes}});
    else
      print_line(std::to_string(*count) + " entries were deleted permanently; freed " + std::to_string(*bytes) + " bytes.");
    return {};
  });
}

void declare_new(Verb verb, Options& o) {
  verb.add_option("--note", o.note, "Note of the entry");
  declare_author(verb, o);
}

void declare_file(Verb verb, Options& o, const char* about) { verb.add_option("file", o.file, about).required(); }

void declare_choice(Verb verb, Options& o) {
  verb.add_option("entries", o.entries, "Names, ids or first characters of ids (default: all that match the filters)");
  verb.add_option("--find", o.words, "Only entries with these words");
  declare_filters(verb, o);
}

}  // namespace

Result<void> check_data(store::EntryKind kind, const std::string& bytes, const std::string& location) {
  const auto result_of = [](const auto& read) -> Result<void> {
    if (!read) return fail(read.error());
    return {};
  };
  switch (kind) {
    case store::EntryKind::mechanism: return result_of(formats::read_mechanism(bytes, location));
    case store::EntryKind::motion: return result_of(formats::read_motion(std::as_bytes(std::span(bytes)), location));
    case store::EntryKind::measured: return result_of(formats::read_measured_motion(std::as_bytes(std::span(bytes)), location));
    case store::EntryKind::circuit: return result_of(circuit::read_circuit(bytes, location));
    case store::EntryKind::set: return result_of(json::parse_json(bytes, location));
  }
  return {};
}

void add_set_verbs(const Verbs& verbs) {
  verbs.add(
      "export", "Write an entry to a file: a mechanism or circuit as JSON, measured data as BVH, a motion as bytes.",
      "ugoki db export walk walk.bvh",
      [](Verb verb, Options& o) {
        declare_entry(verb, o);
        declare_file(verb, o, "The file to write");
        verb.add_option("--version", o.version, "Version to export (default: the newest)").check(range(1, 1'000'000'000));
      },
      export_entry);
  verbs.add(
      "export-set", "Write entries, all entries that they need, and their versions into one file.",
      "ugoki db export-set walks.ugoki-set --tag walk",
      [](Verb verb, Options& o) {
        declare_file(verb, o, "The file to write; it is a complete library");
        declare_choice(verb, o);
        verb.add_flag("--latest", o.latest, "Only the newest versions");
      },
      export_set);
  verbs.add(
      "import-set", "Import a file written by `db export-set`; entries that already exist are not changed.",
      "ugoki db import-set walks.ugoki-set",
      [](Verb verb, Options& o) {
        declare_file(verb, o, "The file");
        verb.add_flag("--theirs", o.theirs, "Entries changed on both sides: save the file's version as the newest");
      },
      import_set);
  verbs.add(
      "copy", "Copy a library into another one, between files and servers; run it again to continue after an interruption.",
      "ugoki db copy ~/.local/share/ugoki/library.db postgresql://anna@server/motions",
      [](Verb verb, Options& o) {
        verb.add_option("from", o.file, "Library to read: a file or postgresql://USER@HOST/DATABASE").required();
        verb.add_option("to", o.to, "Library to write").required();
        verb.add_flag("--theirs", o.theirs, "Entries changed on both sides: save the version of FROM as the newest");
      },
      copy);
  verbs.add(
      "add", "Add a circuit (JSON) to the library; use `ugoki import` for mechanisms and motions.",
      "ugoki db add balance.json --tags control",
      [](Verb verb, Options& o) {
        declare_file(verb, o, "The file");
        verb.add_option("--name", o.name, "Name of the entry (default: the file's name)");
        verb.add_option("--tags", o.tags, "Tags of the entry").delimiter(',');
        declare_new(verb, o);
      },
      add);
  verbs.add(
      "collect", "Create a set: a named list of entries.", "ugoki db collect 'walks for the park' --tag walk",
      [](Verb verb, Options& o) {
        verb.add_option("name", o.name, "Name of the set").required();
        declare_choice(verb, o);
        declare_new(verb, o);
      },
      collect);
  verbs.add(
      "check", "Read all data and verify their hashes.", "ugoki db check",
      [](Verb verb, Options& o) { verb.add_flag("--repair", o.repair, "Rebuild the search index first"); }, check);
  verbs.add("gc", "Delete data that no version uses.", "ugoki db gc", [](Verb, Options&) {}, collect_garbage);
  verbs.add(
      "empty-trash", "Delete the entries in the trash permanently.", "ugoki db empty-trash --before 2026-01-01",
      [](Verb verb, Options& o) { verb.add_option("--before", o.before, "Only entries removed before this date or time (UTC)"); },
      empty_trash);
}

}  // namespace ugoki::cli::db
