#include "motion_files.h"

#include <algorithm>

#include "output.h"
#include "ugoki/base/number.h"
#include "ugoki/body/body.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/feet.h"
#include "ugoki/motion_edit/to_measured.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki::cli {
namespace {

bool same_mechanism(const Mechanism& a, const Mechanism& b) {
  if (&a == &b) return true;
  if (a.nq() != b.nq() || a.link_count() != b.link_count()) return false;
  for (int i = 0; i < a.link_count(); ++i) {
    const Link &l = a.link(i), &k = b.link(i);
    const Joint &p = l.joint, &q = k.joint;
    if (l.name != k.name || l.parent != k.parent || p.type != q.type || norm(p.X_PJ.p - q.X_PJ.p) > 1e-6 || norm(p.axis - q.axis) > 1e-6)
      return false;
  }
  return true;
}

bool same_skeleton(const Skeleton& a, const Skeleton& b) {
  if (a.joints.size() != b.joints.size()) return false;
  for (std::size_t i = 0; i < a.joints.size(); ++i)
    if (a.joints[i].name != b.joints[i].name || a.joints[i].parent != b.joints[i].parent ||
        norm(a.joints[i].offset - b.joints[i].offset) > 1e-6)
      return false;
  return true;
}

/// Whether two skeletons have the same joints and parallel bones at rest, so that rotations can be copied and only lengths differ.
bool same_build(const Skeleton& a, const Skeleton& b) {
  if (a.joints.size() != b.joints.size()) return false;
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    const SkeletonJoint &j = a.joints[i], &k = b.joints[i];
    if (j.name != k.name || j.parent != k.parent) return false;
    const double lengths = norm(j.offset) * norm(k.offset);
    if (j.parent >= 0 && lengths > 1e-4 && dot(j.offset, k.offset) < 0.94 * lengths) return false;
  }
  return true;
}

/// A loaded input; `measured` is set if it comes from a measured file.
struct Loaded {
  std::optional<MeasuredMotion> measured;
  ClipSource clip;
};

Result<Loaded> load_one(const std::string& target, const SourceOptions& options) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  if (*kind != TargetKind::measured_file) {
    Result<ClipSource> clip = load_clip(target, options);
    if (!clip) return fail(std::move(clip.error()));
    return Loaded{std::nullopt, std::move(*clip)};
  }
  Result<intake::Intake> loaded = take_in_file(target, options);
  if (!loaded) return fail(std::move(loaded.error()));
  if (!loaded->motion)
    return fail(ErrorCode::structure, target, "The file contains a mechanism without a motion.", "Name a file with a motion.");
  Loaded out{std::move(loaded->measured), {}};
  out.clip = {loaded->motion->name, loaded->mechanism, std::make_shared<const Motion>(std::move(*loaded->motion)),
              loaded->body ? loaded->body->height : 0};
  return out;
}

/// Makes a body whose joints allow all recordings of the first one's skeleton. Recordings of other skeletons are ignored.
Result<body::Body> common_body(const std::vector<Loaded>& all, const SourceOptions& options) {
  MeasuredMotion combined = *all[0].measured;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (!all[i].measured || !same_skeleton(all[i].measured->skeleton, combined.skeleton)) continue;
    const MeasuredMotion& m = *all[i].measured;
    combined.frames += m.frames;
    combined.translations.insert(combined.translations.end(), m.translations.begin(), m.translations.end());
    combined.rotations.insert(combined.rotations.end(), m.rotations.begin(), m.rotations.end());
  }
  body::BodyOptions body_options;
  body_options.height = options.intake.height;
  body_options.mass = options.intake.mass;
  return body::make_body(combined, body_options);
}

}  // namespace

Result<MotionSet> load_motions(const std::vector<std::string>& targets, const SourceOptions& options) {
  std::vector<Loaded> all;
  Error errors;
  for (const std::string& target : targets) {
    Result<Loaded> one = load_one(target, options);
    if (one)
      all.push_back(std::move(*one));
    else
      errors.problems.insert(errors.problems.end(), one.error().problems.begin(), one.error().problems.end());
  }
  if (!errors.empty()) return fail(std::move(errors));
  MotionSet out{all[0].clip.mechanism, {*all[0].clip.motion}, all[0].clip.height, {}};
  if (all.size() == 1) return out;
  std::optional<body::Body> body;
  if (all[0].measured) {
    Result<body::Body> made = common_body(all, options);
    if (!made) return fail(std::move(made.error()));
    body = std::move(*made);
    out.mechanism = body->mechanism;
    out.motions[0] = body::to_motion(*body, *all[0].measured);
    out.motions[0].name = all[0].clip.name;
    out.motions[0].source = all[0].clip.motion->source;
  }
  for (std::size_t i = 1; i < all.size(); ++i) {
    const ClipSource& clip = all[i].clip;
    if (body && all[i].measured && same_skeleton(all[i].measured->skeleton, all[0].measured->skeleton)) {
      out.motions.push_back(body::to_motion(*body, *all[i].measured));
    } else if (body && all[i].measured && same_build(all[i].measured->skeleton, all[0].measured->skeleton)) {
      const double own_leg = motion_edit::mean_leg_length(motion_edit::find_foot_limbs(*clip.mechanism)),
                   target_leg = motion_edit::mean_leg_length(motion_edit::find_foot_limbs(*out.mechanism));
      const double factor = own_leg > 0 && target_leg > 0 ? target_leg / own_leg
                                                          : rest_height(all[0].measured->skeleton) / rest_height(all[i].measured->skeleton);
      Result<Motion> scaled = motion_edit::scale(*out.mechanism, body::to_motion(*body, *all[i].measured), {.length = factor});
      if (!scaled) return fail(std::move(scaled.error()));
      out.motions.push_back(std::move(*scaled));
      out.report.push_back(clip.name + " was made for a body with the same joints; its path is scaled to the leg length of " +
                           all[0].clip.name + ", by " + to_fixed(factor, 3) + ".");
    } else if (same_mechanism(*clip.mechanism, *out.mechanism)) {
      out.motions.push_back(*clip.motion);
    } else {
      Result<retarget::Retargeted> moved = retarget::retarget(clip.mechanism, *clip.motion, out.mechanism);
      if (!moved) return fail(std::move(moved.error()));
      out.motions.push_back(std::move(moved->motion));
      out.report.push_back(clip.name + " was made for another body; it is retargeted to the body of " + all[0].clip.name +
                           ", lengths scaled by " + to_fixed(moved->report.scale, 3) + ".");
    }
    out.motions.back().name = clip.name;
    out.motions.back().source = clip.motion->source;
  }
  return out;
}

bool writes_file(const std::string& out) { return out.ends_with(".bvh") || out.ends_with(".glb"); }

Result<std::string> put_motion(const Mechanism& mechanism, const Motion& motion, double height, const std::string& out,
                               const SourceOptions& options) {
  if (out.ends_with(".bvh")) {
    if (Result<void> written = files::write_file(out, formats::write_bvh(motion_edit::to_measured(mechanism, motion))); !written)
      return fail(std::move(written.error()));
    return "Written to " + out + ".";
  }
  if (out.ends_with(".glb")) {
    const std::vector<std::byte> bytes = formats::write_glb(motion_edit::to_measured(mechanism, motion));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (Result<void> written = files::write_file(out, std::string(text)); !written) return fail(std::move(written.error()));
    return "Written to " + out + ".";
  }
  if (out.find('.') != std::string::npos || out.find('/') != std::string::npos)
    return fail(ErrorCode::unsupported, out, "Motions cannot be written to files with this extension.",
                "Name a .bvh or .glb file, or an entry of the library (a name without a dot).");
  Result<store::Library> library = store::Library::open(library_path(options.library));
  if (!library) return fail(std::move(library.error()));
  print_warning(library->warning());
  const std::string text = formats::write_mechanism(mechanism);
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  Motion named = motion;
  named.name = out;
  std::vector<store::LibraryItem> items(2);
  items[0].kind = store::EntryKind::mechanism;
  items[0].name = mechanism.name().empty() ? out : mechanism.name();
  items[0].data.assign(bytes, bytes + text.size());
  items[0].summary = Json{
      {"dofs", mechanism.nv()},
      {"links", mechanism.link_count()},
      {"mass", mechanism.mass()},
      {"height", height},
      {"source",
       motion.source}}.dump();
  items[1].kind = store::EntryKind::motion;
  items[1].name = out;
  items[1].data = formats::write_motion(named);
  items[1].summary = Json{
      {"mechanism", store::entry_id(store::EntryKind::mechanism, items[0].data)},
      {"frames", motion.frames},
      {"joints", mechanism.link_count()},
      {"rate", motion.rate},
      {"duration", motion.duration()},
      {"cyclic", motion.cyclic},
      {"dofs", mechanism.nv()},
      {"mass", mechanism.mass()},
      {"height", height},
      {"source",
       motion.source}}.dump();
  const Result<std::vector<std::string>> ids = library->put(items);
  if (!ids) return fail(ids.error());
  return "Stored in the library as " + out + " (" + ids->back() + ").";
}

}  // namespace ugoki::cli
