#include "ugoki/plugin/live_library.h"

#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <utility>

#include "ugoki/fmi/messages.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/inspect.h"
#include "ugoki/plugin/load.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::plugin {
namespace {

namespace fs = std::filesystem;

/// Stamp of a file: inode, size and modification time. It changes when the file is replaced or written.
std::string stamp_of(const std::string& path) {
  struct stat s{};
  if (::stat(path.c_str(), &s) != 0) return "missing";
  return std::to_string(s.st_ino) + " " + std::to_string(s.st_size) + " " + std::to_string(s.st_mtim.tv_sec) + "." +
         std::to_string(s.st_mtim.tv_nsec);
}

/// Names and stamps of all manifests of a shelf. It changes when a library is installed or removed.
std::string stamp_of_shelf(const std::string& folder) {
  std::string out;
  std::error_code ec;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, ec))
    if (file.path().extension() == ".json") out += file.path().filename().string() + " " + stamp_of(file.path().string()) + "\n";
  return out;
}

/// A set of LSIs with the references that keep the code of these LSIs in memory.
struct Kept {
  circuit::Library library;
  std::vector<std::shared_ptr<void>> code;
};

}  // namespace

struct LiveLibrary::Source {
  std::string path, hash, stamp, name, refusal;  // refusal: why the file could not be loaded
  std::optional<LoadedLibrary> loaded;           // the last code that could be loaded; empty: none yet
  bool writable = false;                         // true: the code has global or static variables that it can change
};

LiveLibrary::LiveLibrary(const circuit::Library& base, std::string shelf, std::vector<std::string> files)
    : base_(base), shelf_(std::move(shelf)), files_(std::move(files)) {
  poll();
  if (!library_) assemble();
}
LiveLibrary::~LiveLibrary() = default;

void LiveLibrary::find_sources(std::vector<Source>& out) const {
  for (const std::string& file : files_) out.push_back({file, {}, {}, fs::path(file).stem().string(), {}, {}});
  if (!shelf_.empty())
    for (const ShelfEntry& e : read_shelf(shelf_)) out.push_back({e.file, e.hash, {}, e.name, {}, {}});
}

bool LiveLibrary::poll() {
  const std::string shelf_stamp = shelf_.empty() ? "" : stamp_of_shelf(shelf_);
  bool changed = shelf_stamp != shelf_stamp_;
  for (const Source& s : sources_) changed = changed || stamp_of(s.path) != s.stamp;
  if (!changed && library_) return false;
  shelf_stamp_ = shelf_stamp;
  std::vector<Source> next;
  find_sources(next);
  for (Source& s : next) {
    s.stamp = stamp_of(s.path);
    Source* old = nullptr;  // the previous version: the same path, or a file LIBRARY-HASH of the same library on the shelf
    for (Source& o : sources_)
      if (o.path == s.path || (o.loaded && !s.hash.empty() && fs::path(o.path).parent_path() == fs::path(s.path).parent_path() &&
                               s.path.starts_with(fs::path(o.path).parent_path().string() + "/" + o.loaded->name + "-")))
        old = &o;
    if (old && old->path == s.path && old->stamp == s.stamp && old->loaded) {
      s.loaded = old->loaded;
      s.writable = old->writable;
      continue;
    }
    set_phase("The library '" + fs::path(s.path).filename().string() + "' was being loaded");
    Result<LoadedLibrary> loaded = load_library(s.path, s.hash);
    set_phase({});
    if (loaded) {
      s.loaded = std::move(*loaded);
      const Result<Inspection> file = inspect_library(s.path);
      s.writable = file && !file->writable.empty();
    } else {
      messages_.push_back(loaded.error().text());
      s.refusal = loaded.error().problems[0].message;
      if (old) s.loaded = old->loaded;  // keep the previous code until a file can be loaded
    }
  }
  sources_ = std::move(next);
  assemble();
  return true;
}

bool LiveLibrary::renew() {
  bool renewed = false;
  for (Source& s : sources_) {
    if (!s.loaded || !s.writable) continue;
    set_phase("The library '" + s.loaded->name + "' was being loaded");
    Result<LoadedLibrary> loaded = load_library(s.path, s.loaded->hash);
    set_phase({});
    if (!loaded) continue;  // the file was replaced or removed; poll() reports it
    s.loaded = std::move(*loaded);
    renewed = true;
  }
  if (renewed) assemble();
  return renewed;
}

void LiveLibrary::assemble() {
  auto kept = std::make_shared<Kept>();
  kept->library = base_;
  for (const Source& s : sources_) {
    if (!s.loaded) kept->library.note_refused(s.name, s.refusal);
    if (!s.loaded) continue;
    for (const circuit::LsiClass& c : s.loaded->classes) {
      if (kept->library.has(c.name))
        messages_.push_back(s.path + ": the LSI '" + c.name +
                            "' is left out, because another library has an LSI of this name. Rename the library.");
      else
        kept->library.add(c);
    }
    kept->code.push_back(s.loaded->code);
  }
  library_ = std::shared_ptr<const circuit::Library>(kept, &kept->library);
}

std::vector<std::string> LiveLibrary::take_messages() {
  std::vector<std::string> out = std::exchange(messages_, {});
  for (std::string& text : fmi::take_messages()) out.push_back(std::move(text));
  return out;
}

}  // namespace ugoki::plugin
