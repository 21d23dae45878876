// Fuzz target of projects (changed_database.h).
#include <string>
#include <string_view>
#include <utility>

#include "changed_database.h"
#include "fixture.h"
#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/project/project.h"

namespace ugoki {
namespace {

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty());
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

std::string good_project(const Folder& folder) {
  const std::string path = folder.file("good.ugoki");
  {
    auto project = project::Project::create(path, content::testing::make_scenario(), content::testing::make_resources());
    UGOKI_CHECK(project.has_value());
    for (const char* start : {"4.5", "4.6"})
      UGOKI_CHECK(
          project->execute(R"({"type": "clip.set", "character": "human", "id": "k3", "start": )" + std::string(start) + "}").has_value());
    UGOKI_CHECK(project->undo().has_value());
  }
  into_one_file(path);
  return read_all(path);
}

}  // namespace

void fuzz_project(const std::uint8_t* data, std::size_t size) {
  static const Folder folder;
  static const std::string good = good_project(folder);
  static bool good_was_read = false;
  folder.clear();
  const std::string path = folder.file("fuzz.ugoki");
  const bool changed = make_changed(good, {reinterpret_cast<const char*>(data), size}, path);
  if (!changed && std::exchange(good_was_read, true)) return;
  auto project = project::Project::open(path);
  if (!project) return check_error(project.error());
  UGOKI_CHECK(content::write_scenario(project->scenario()) == project->document());
  UGOKI_CHECK(content::check_scenario(project->scenario(), &project->catalogue()).empty());
  if (const auto made = project->generate(); !made) check_error(made.error());
  for (int i = 0; i < 3 && project->can_undo(); ++i)
    if (const auto done = project->undo(); !done) return check_error(done.error());
  for (int i = 0; i < 4 && project->can_redo(); ++i)
    if (const auto done = project->redo(); !done) return check_error(done.error());
  UGOKI_CHECK(content::check_scenario(project->scenario(), &project->catalogue()).empty());
}

}  // namespace ugoki
