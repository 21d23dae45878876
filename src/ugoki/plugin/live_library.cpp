#include "ugoki/plugin/live_library.h"

#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <utility>

#include "ugoki/fmi/messages.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/load.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::plugin {
namespace {

namespace fs = std::filesystem;

/// Changes when the file does: it is replaced, or written.
std::string stamp_of(const std::string& path) {
  struct stat s{};
  if (::stat(path.c_str(), &s) != 0) return "missing";
  return std::to_string(s.st_ino) + " " + std::to_string(s.st_size) + " " + std::to_string(s.st_mtim.tv_sec) + "." +
         std::to_string(s.st_mtim.tv_nsec);
}

std::string stamp_of_shelf(const std::string& folder) {
  std::string out;
  std::error_code ec;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, ec))
    if (file.path().extension() == ".json") out += file.path().filename().string() + " " + stamp_of(file.path().string()) + "\n";
  return out;
}

struct Kept {
  circuit::Library library;
  std::vector<std::shared_ptr<void>> code;
};

}  // namespace

struct LiveLibrary::Source {
  std::string path, hash, stamp, name, refusal;
  std::optional<LoadedLibrary> loaded;
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
    Source* old = nullptr;
    for (Source& o : sources_)
      if (o.path == s.path || (o.loaded && !s.hash.empty() && fs::path(o.path).parent_path() == fs::path(s.path).parent_path() &&
                               s.path.starts_with(fs::path(o.path).parent_path().string() + "/" + o.loaded->name + "-")))
        old = &o;
    if (old && old->path == s.path && old->stamp == s.stamp && old->loaded) {
      s.loaded = old->loaded;
      continue;
    }
    set_phase("The library '" + fs::path(s.path).filename().string() + "' was being loaded");
    Result<LoadedLibrary> loaded = load_library(s.path, s.hash);
    set_phase({});
    if (loaded) {
      s.loaded = std::move(*loaded);
    } else {
      messages_.push_back(loaded.error().text());
      s.refusal = loaded.error().problems[0].message;
      if (old) s.loaded = old->loaded;  // what runs goes on until there is something better
    }
  }
  sources_ = std::move(next);
  assemble();
  return true;
}

void LiveLibrary::assemble() {
  auto kept = std::make_shared<Kept>();
  kept->library = base_;
  for (const Source& s : sources_) {
    if (!s.loaded) kept->library.note_refused(s.name, s.refusal);
    if (!s.loaded) continue;
    for (const circuit::LsiClass& c : s.loaded->classes) {
      if (kept->library.has(c.name))
        messages_.push_back(s.path + ": there is an LSI '" + c.name + "' already; this one is left out. Give the library another name.");
      else
        kept->library.add(c);
    }
    kept->code.push_back(s.loaded->code);
  }
  library_ = std::shared_ptr<const circuit::Library>(kept, &kept->library);
}

std::vector<std::string> LiveLibrary::take_messages() {
  std::vector<std::string> out = std::exchange(messages_, {});
  for (std::string& said : fmi::take_messages()) out.push_back(std::move(said));
  return out;
}

}  // namespace ugoki::plugin
