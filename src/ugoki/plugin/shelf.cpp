#include "ugoki/plugin/shelf.h"

#include <cstdlib>
#include <filesystem>

#include "ugoki/base/sha256.h"
#include "ugoki/circuit/class_json.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/json/fields.h"
#include "ugoki/plugin/load.h"

namespace ugoki::plugin {
namespace {

namespace fs = std::filesystem;
using json::Json;

constexpr std::size_t max_manifest = std::size_t{64} << 20;  // maximum size, bytes; larger manifests are refused

/// Takes the place of the functions of an installed LSI, because its code is not loaded; stops the circuit with a message.
std::int32_t not_here(const circuit::Call* call) {
  return circuit::stop(call, "This LSI of an installed library can run only in the process of the interpreter.");
}

/// Reads a manifest: the description of describe_library, plus the fields "file" and "source".
ShelfEntry read_entry(const Json& json, const std::string& location, Error& problems) {
  ShelfEntry e;
  json::Fields f(json, location, problems);
  for (const char* field : {"name", "sha256", "classes"}) f.require(field, "as `ugoki lsi install` writes it");
  f.text("name", e.name);
  f.text("version", e.version);
  f.text("doc", e.doc);
  f.text("sha256", e.hash);
  f.text("file", e.file);
  f.text("source", e.source);
  if (const Json* classes = f.list("classes", 10000, "LSIs"))
    for (std::size_t i = 0; i < classes->size(); ++i) {
      circuit::LsiClass c = circuit::read_class((*classes)[i], f.path("classes") + "/" + std::to_string(i), problems);
      c.from = e.name;
      bool delayed = false;
      for (const circuit::OutputPin& pin : c.outputs) delayed = delayed || pin.delayed;
      c.step = not_here;
      if (delayed) c.advance = not_here;
      e.classes.push_back(std::move(c));
    }
  return e;
}

std::string manifest_path(const std::string& folder, const std::string& name) { return folder + "/" + name + ".json"; }

}  // namespace

std::string default_shelf() {
  if (const char* given = std::getenv("UGOKI_LSI"); given && *given) return given;
  if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data) return std::string(data) + "/ugoki/lsi";
  const char* home = std::getenv("HOME");
  return std::string(home && *home ? home : ".") + "/.local/share/ugoki/lsi";
}

std::vector<ShelfEntry> read_shelf(const std::string& folder, Error* problems) {
  std::vector<ShelfEntry> out;
  std::error_code ec;
  Error ignored;
  Error& reported = problems ? *problems : ignored;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, ec)) {
    if (file.path().extension() != ".json") continue;
    const std::string path = file.path().string();
    const Result<std::string> text = files::read_regular_file(path, max_manifest);
    if (!text) {
      reported.problems.insert(reported.problems.end(), text.error().problems.begin(), text.error().problems.end());
      continue;
    }
    Error wrong;
    const Result<Json> json = json::parse_json(*text, path);
    if (!json) {
      wrong = json.error();
    } else {
      ShelfEntry e = read_entry(*json, path + ":", wrong);
      if (wrong.empty() && manifest_path(folder, e.name) != path)
        wrong.add(ErrorCode::structure, path, "The manifest describes the library '" + e.name + "', but has another name.",
                  "Install the library again.");
      e.file = folder + "/" + fs::path(e.file).filename().string();
      if (wrong.empty()) out.push_back(std::move(e));
    }
    reported.problems.insert(reported.problems.end(), wrong.problems.begin(), wrong.problems.end());
  }
  std::sort(out.begin(), out.end(), [](const ShelfEntry& a, const ShelfEntry& b) { return a.name < b.name; });
  return out;
}

Result<std::string> describe_library(const std::string& path, const std::string& hash) {
  const Result<LoadedLibrary> library = load_library(path, hash);
  if (!library) return fail(library.error());
  Json classes = Json::array();
  for (const circuit::LsiClass& c : library->classes) classes.push_back(circuit::class_json(c));
  const Json out = {
      {"name", library->name}, {"version", library->version}, {"doc", library->doc}, {"sha256", library->hash}, {"classes", classes}};
  return json::to_text(out, 1);
}

Result<ShelfEntry> put_on_shelf(const std::string& folder, const std::string& path, std::string_view description) {
  Result<Json> json = json::parse_json(description, path);
  if (!json) return fail(std::move(json.error()));
  Error problems;
  ShelfEntry entry = read_entry(*json, path + ":", problems);
  if (!problems.empty()) return fail(std::move(problems));
  const Result<std::string> bytes = files::read_regular_file(path);
  if (!bytes) return fail(bytes.error());
  if (sha256(*bytes) != entry.hash)
    return fail(ErrorCode::conflict, path, "The file has changed since its hash was confirmed.", "Install it again.");
  std::error_code ec;
  fs::create_directories(folder, ec);
  if (ec)
    return fail(ErrorCode::io, folder, "The folder for installed LSIs cannot be created: " + ec.message() + ".",
                "Set UGOKI_LSI to a folder that you may write to.");
  // Write the library first, under a name that contains its hash. Writing the manifest then installs it in one step.
  const std::string start = entry.name + "-", extension = fmi::is_zip(*bytes) ? ".fmu" : ".so";
  const std::string name = start + entry.hash.substr(0, 16) + extension;
  entry.file = folder + "/" + name;
  if (Result<void> done = files::write_file(entry.file, std::string_view(*bytes)); !done) return fail(done.error());
  entry.source = fs::absolute(path, ec).lexically_normal().string();
  (*json)["file"] = name;
  (*json)["source"] = entry.source;
  if (Result<void> done = files::write_file(manifest_path(folder, entry.name), std::string_view(json::to_text(*json, 1) + "\n")); !done)
    return fail(done.error());
  // Remove the files of older versions: NAME- and 16 digits of the hash.
  for (const fs::directory_entry& file : fs::directory_iterator(folder, ec)) {
    const std::string other = file.path().filename().string();
    const bool version = other.starts_with(start) && fs::path(other).stem().string().size() == start.size() + 16;
    if (other != name && version && (other.ends_with(".so") || other.ends_with(".fmu"))) fs::remove(file.path(), ec);
  }
  return entry;
}

Result<void> remove_from_shelf(const std::string& folder, const std::string& name) {
  for (const ShelfEntry& e : read_shelf(folder)) {
    if (e.name != name) continue;
    std::error_code ec;
    fs::remove(manifest_path(folder, name), ec);
    if (ec)
      return fail(ErrorCode::io, manifest_path(folder, name), "The library cannot be removed: " + ec.message() + ".",
                  "Check that you may delete files in this folder.");
    fs::remove(e.file, ec);
    return {};
  }
  return fail(ErrorCode::unknown, name, "No library of this name is installed.", "`ugoki lsi list` shows the installed libraries.");
}

}  // namespace ugoki::plugin
