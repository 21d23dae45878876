#pragma once
// What the verbs of `ugoki db` share.

#include <functional>
#include <string>
#include <vector>

#include "output.h"
#include "ugoki/store/library.h"
#include "verb.h"

namespace ugoki::cli::db {

struct Options {
  std::string library, author;
  std::vector<std::string> words, tags, kinds, add, remove, entries;
  std::string entry, name, file, order, after, to, before, note, kind;
  int version = 0, based_on = 0;
  std::size_t limit = 1000;
  bool removed = false, latest = false, theirs = false, repair = false, clear = false, json = false;
};

/// Declares a verb below `ugoki db` with --library and --json.
using Declare = std::function<void(CLI::App&, Options&)>;
struct Verbs {
  CLI::App& parent;
  Action& action;
  void add(const char* name, const char* about, const char* example, const Declare& declare, int (*run)(const Options&)) const;
};
void declare_filters(CLI::App& verb, Options& options);
void declare_entry(CLI::App& verb, Options& options);
void declare_entries(CLI::App& verb, Options& options);
void declare_author(CLI::App& verb, Options& options);

/// export, export-set, import-set, copy, check, gc and what else handles many entries or files.
void add_set_verbs(const Verbs& verbs);

/// Whether an entry of this kind can have these bytes. @param place of the problem: the file
[[nodiscard]] Result<void> check_data(store::EntryKind kind, const std::string& bytes, const std::string& place);

enum class Access { read, write };
/// Opens the library and hands it to `work`; a problem is printed.
[[nodiscard]] int with_library(const Options& options, Access access, const std::function<Result<void>(store::Library&)>& work);
[[nodiscard]] store::LibraryQuery query_of(const Options& options, store::LibraryOrder usual);

[[nodiscard]] Json entry_json(const store::LibraryEntry& entry);
[[nodiscard]] Json summary_of(const store::LibraryEntry& entry);
[[nodiscard]] std::string joined(const std::vector<std::string>& words, const char* by);

}  // namespace ugoki::cli::db
