#pragma once
// Options and functions that the verbs of `ugoki db` share.

#include <functional>
#include <string>
#include <vector>

#include "output.h"
#include "ugoki/store/library.h"
#include "verb.h"

namespace ugoki::cli::db {

/// Options of all verbs; each verb declares and uses some of them.
struct Options {
  std::string library, author;
  std::vector<std::string> words, tags, kinds, add, remove, entries;
  std::string entry, name, file, order, after, to, before, note, kind;
  int version = 0, based_on = 0;
  std::size_t limit = 1000;
  bool removed = false, latest = false, theirs = false, repair = false, clear = false, json = false;
};

/// Function that declares the options of a verb.
using Declare = std::function<void(Verb, Options&)>;
/// Adds verbs to `ugoki db`. add() declares a verb with --library and --json, then calls `declare` for its other options.
struct Verbs {
  Verb parent;
  Action& action;
  void add(const char* name, const char* about, const char* example, const Declare& declare, int (*run)(const Options&)) const;
};
void declare_filters(Verb verb, Options& options);
void declare_entry(Verb verb, Options& options);
void declare_entries(Verb verb, Options& options);
void declare_author(Verb verb, Options& options);

/// Adds the verbs for many entries or files: export, export-set, import-set, copy, add, collect, check, gc, empty-trash.
void add_set_verbs(const Verbs& verbs);

/// Checks that the bytes are valid data of an entry of this kind. @param location the file's path, for error messages
[[nodiscard]] Result<void> check_data(store::EntryKind kind, const std::string& bytes, const std::string& location);

enum class Access { read, write };
/// Opens the library and calls `work` with it. Prints the error if one of them fails. @return exit status
[[nodiscard]] int with_library(const Options& options, Access access, const std::function<Result<void>(store::Library&)>& work);
/// Query from the filter options. @param usual order if --order is not given
[[nodiscard]] store::LibraryQuery query_of(const Options& options, store::LibraryOrder usual);

[[nodiscard]] Json entry_json(const store::LibraryEntry& entry);
[[nodiscard]] Json summary_of(const store::LibraryEntry& entry);
[[nodiscard]] std::string joined(const std::vector<std::string>& words, const char* by);

}  // namespace ugoki::cli::db
