#include "ugoki/plugin/carry.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "ugoki/circuit/flatten.h"
#include "ugoki/files/files.h"
#include "ugoki/plugin/load.h"

namespace ugoki::plugin {
namespace {

/// Adds the names of all installed classes that the circuit and its nested circuits use: "library/name".
void add_classes(const circuit::Circuit& circuit, const circuit::Library& known, std::set<std::string>& out) {
  for (const circuit::Instance& lsi : circuit.lsis) {
    const circuit::LsiClass* found = known.find(lsi.type);
    if (found && found->name.find('/') != std::string::npos) out.insert(found->name);
  }
  for (const circuit::Circuit& nested : circuit.circuits) add_classes(nested, known, out);
}

}  // namespace

Result<std::vector<CarriedFile>> libraries_of(const circuit::Circuit& circuit, const circuit::Library& own,
                                              std::span<const ShelfEntry> shelf) {
  circuit::Library known = own;
  for (const ShelfEntry& entry : shelf)
    for (const circuit::LsiClass& each : entry.classes)
      if (!known.has(each.name)) known.add(each);
  Error problems;
  (void)circuit::flatten(circuit, known, problems);
  if (!problems.empty()) return fail(std::move(problems));
  std::set<std::string> classes;
  add_classes(circuit, known, classes);
  std::vector<CarriedFile> out;
  for (const ShelfEntry& entry : shelf) {
    if (std::ranges::none_of(classes, [&](const std::string& name) { return name.starts_with(entry.name + "/"); })) continue;
    if (entry.file.ends_with(".fmu"))
      return fail(ErrorCode::unsupported, entry.name, "The library '" + entry.name + "' is an FMU. Native programs cannot carry FMUs.",
                  "Replace its LSIs, or run the content with `ugoki run`.");
    if (const Result<void> good = check_library_file(entry.file, entry.hash); !good) return fail(good.error());
    Result<std::string> bytes = files::read_file(entry.file);
    if (!bytes) return fail(std::move(bytes.error()));
    out.push_back({entry.name, std::filesystem::path(entry.file).filename().string(), entry.hash, std::move(*bytes)});
  }
  return out;
}

}  // namespace ugoki::plugin
