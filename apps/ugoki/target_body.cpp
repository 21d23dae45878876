#include "target_body.h"

#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/mechanism_edit/cut.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

/// Removes links that are not part of the robot: descriptions may contain the floor and other objects fixed to the world.
Result<MechanismPtr> without_surroundings(MechanismPtr mechanism) {
  if (mechanism->link(0).joint.type == JointType::floating) return mechanism;
  for (const Link& link : mechanism->links())
    if (link.parent < 0 && link.joint.type == JointType::floating) {
      Result<Edited> part = cut(*mechanism, link.name, {.keep = Keep::part});
      if (!part) return fail(std::move(part.error()));
      return part->mechanism;
    }
  return mechanism;
}

}  // namespace

Result<MechanismPtr> load_body(const std::string& to, double height, const SourceOptions& options) {
  if (height > 0) return samples::make_person(height);
  if (to == "dog") return samples::make_dog();
  if (to == "human") return samples::make_person(1.75);
  const Result<TargetKind> kind = kind_of(to);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::mechanism_file) {
    SourceOptions source = options;
    if (source.robot.base.empty()) source.robot.base = "floating";  // a walking robot has a floating base
    Result<intake::Intake> loaded = take_in_file(to, source);
    if (!loaded) return fail(std::move(loaded.error()));
    return without_surroundings(loaded->mechanism);
  }
  if (*kind == TargetKind::entry) {
    const Result<store::Library> library = library_of(to, options);
    if (!library) return fail(library.error());
    if (const Result<store::LibraryEntry> entry = library->resolve(to, "mechanism")) {
      const Result<std::vector<std::byte>> data = library->data(entry->id);
      if (!data) return fail(data.error());
      return formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, "library entry " + entry->id);
    }
  }
  Result<ClipSource> clip = load_clip(to, options);
  if (!clip) return fail(std::move(clip.error()));
  return clip->mechanism;
}

}  // namespace ugoki::cli
