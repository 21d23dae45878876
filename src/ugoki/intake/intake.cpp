#include "ugoki/intake/intake.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "ugoki/base/number.h"
#include "ugoki/capture/capture.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/gltf_unpack.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/formats/trc.h"
#include "ugoki/geometry/prepare.h"
#include "ugoki/intake/animal_size.h"
#include "ugoki/intake/arrange.h"
#include "ugoki/intake/choice.h"
#include "ugoki/intake/joined_motion.h"
#include "ugoki/intake/mesh_intake.h"
#include "ugoki/intake/scale.h"
#include "ugoki/intake/skin_binding.h"
#include "ugoki/intake/support.h"
#include "ugoki/intake/usual_plan.h"
#include "ugoki/robot_formats/robot_file.h"
#include "ugoki/scene_formats/deepmimic.h"
#include "ugoki/scene_formats/meshopt.h"
#include "ugoki/scene_formats/mvnx.h"
#include "ugoki/scene_formats/opensim.h"
#include "ugoki/scene_formats/scene_file.h"
#include "ugoki/scene_formats/smpl.h"
#include "ugoki/scene_formats/usd.h"

namespace ugoki::intake {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

std::string_view base_name(std::string_view path) { return path.substr(path.find_last_of("/\\") + 1); }

std::string stem_of(std::string_view path) {
  const std::string_view base = base_name(path);
  const std::size_t dot = base.rfind('.');
  return std::string(dot == std::string_view::npos || dot == 0 ? base : base.substr(0, dot));
}

/// The body's mechanism with another name and the skin of the file.
Result<MechanismPtr> finished(const body::Body& body, const std::string& name, SkinBinding& skin) {
  MechanismSpec spec = body.mechanism->spec();
  spec.name = name;
  skin.attach(body, spec);
  return Mechanism::make(std::move(spec));
}

Json mechanism_summary(const Mechanism& mechanism, const std::string& source) {
  return {{"dofs", mechanism.nv()}, {"links", mechanism.link_count()}, {"mass", mechanism.mass()}, {"source", source}};
}

/// Library items of one motion: the measured and the converted motion.
/// @param mechanism_id library id of the body's mechanism @param motion out: the converted motion
Result<std::vector<store::LibraryItem>> motion_items(const MeasuredMotion& measured, const body::Body& body,
                                                     const std::string& mechanism_id, const std::string& source,
                                                     const IntakeOptions& options, Motion& motion) {
  motion = body::to_motion(body, measured);
  motion.name = measured.name;
  motion.source = source;
  motion.mechanism = body.mechanism->name();
  if (Error wrong = check_motion(motion, *body.mechanism); !wrong.empty()) return fail(std::move(wrong));
  store::LibraryItem measured_item{store::EntryKind::measured, measured.name, {}, options.tags, formats::write_measured_motion(measured)};
  measured_item.summary = text_of({{"frames", measured.frames},
                                   {"joints", measured.joint_count()},
                                   {"rate", measured.rate},
                                   {"duration", measured.duration()},
                                   {"source", source}});
  store::LibraryItem motion_item{store::EntryKind::motion, measured.name, {}, options.tags, formats::write_motion(motion)};
  motion_item.summary = text_of({{"mechanism", mechanism_id},
                                 {"measured", store::entry_id(store::EntryKind::measured, measured_item.data)},
                                 {"frames", motion.frames},
                                 {"joints", measured.joint_count()},
                                 {"rate", motion.rate},
                                 {"duration", motion.duration()},
                                 {"cyclic", motion.cyclic},
                                 {"dofs", body.mechanism->nv()},
                                 {"mass", body.mass},
                                 {"height", body.height},
                                 {"source", source}});
  return std::vector<store::LibraryItem>{std::move(measured_item), std::move(motion_item)};
}

/// The error of an import that the caller has cancelled; std::nullopt if it is not cancelled.
std::optional<Error> stopped(const IntakeOptions& options, std::string_view file_name) {
  if (!options.cancelled || !options.cancelled()) return std::nullopt;
  return Error(ErrorCode::cancelled, std::string(file_name), "The import was cancelled.", "Nothing was stored; import the file again.");
}

/// `error` with the file's name at the beginning of every location.
Error in_file(Error error, std::string_view file_name) {
  for (Problem& p : error.problems)
    if (!p.location.starts_with(file_name)) p.location = std::string(file_name) + (p.location.empty() ? "" : ", " + p.location);
  return error;
}

/// Rotation to apply to converted data if the reader assumed the usual axes (z_up) but the file has the axes `wanted`.
Mat3 turn_from(bool z_up, const Orientation& wanted) {
  return rotation_to_ours(wanted) * rotation_to_ours(usual_orientation(z_up)).transposed();
}

/// Applies the caller's axes and frame rate, and records the values used in `out`.
void apply_corrections(std::vector<MeasuredMotion>& motions, const formats::ReadNotes& notes, const IntakeOptions& options, Intake& out) {
  out.unit_guessed = notes.unit_guessed;
  out.axes = options.axes.value_or(usual_orientation(notes.z_up));
  const Orientation read_as = usual_orientation(notes.z_up);
  for (MeasuredMotion& m : motions) {
    if (out.axes != read_as) turn(m, turn_from(notes.z_up, out.axes));
    if (options.frame_rate > 0) m.rate = options.frame_rate;
  }
}

/// Lists the takes and characters of the file in `out`, and keeps the character that the caller chose.
Result<void> choose(std::vector<MeasuredMotion>& motions, const IntakeOptions& options, const std::string& location, Intake& out,
                    std::vector<std::string>& remarks) {
  if (motions.size() > 1)
    for (const MeasuredMotion& m : motions) out.takes.push_back(m.name);
  const auto longest = std::ranges::max_element(motions, {}, [](const MeasuredMotion& m) { return m.frames; });
  const std::vector<int> roots = character_roots(*longest);
  std::vector<std::string> names;
  for (const int r : roots) names.push_back(motions[0].skeleton.joints[static_cast<std::size_t>(r)].name);
  if (names.size() > 1) out.characters = names;
  if (!options.character.empty()) return choose_character(motions, roots, options.character, location);
  if (names.size() > 1)
    remarks.push_back("The file contains " + std::to_string(names.size()) + " unconnected characters (roots " + list_of(names) +
                      "); the one whose anatomy is recognised best becomes the body, or all together if none is recognised. Choose one "
                      "with --character.");
  return {};
}

/// Species that the caller or names in the file state.
Result<std::optional<SpeciesMass>> species_of(const std::vector<MeasuredMotion>& motions, const IntakeOptions& options,
                                              const std::string& file_name) {
  if (options.species == "none") return std::optional<SpeciesMass>{};
  if (!options.species.empty()) {
    if (std::optional<SpeciesMass> given = species_mass(options.species)) return given;
    return fail(ErrorCode::unknown, file_name, "The species '" + options.species + "' is not known.",
                "Use one of these, or none: " + known_species() + ".");
  }
  std::vector<std::string> names;
  for (const MeasuredMotion& m : motions) names.push_back(m.name);
  for (const SkeletonJoint& j : motions[0].skeleton.joints)
    if (j.parent < 0) names.push_back(j.name);
  return species_in_names(base_name(file_name), names);
}

/// Scales the motions if another unit of length than the file's is more plausible, and adds a remark about it.
void set_size(std::vector<MeasuredMotion>& motions, const body::Character& character, const std::optional<SpeciesMass>& species,
              formats::ReadNotes& notes, const IntakeOptions& options, Intake& out) {
  if (options.unit != 0 || options.height != 0) return;
  double unit = out.metres_per_unit;
  std::string reason;
  if (const auto size = size_of_animal(character, motions, unit, !notes.unit_guessed, species)) {
    unit = size->unit;
    reason = size->reason;
  } else if (const auto by_height = unit_by_height(character, unit, !notes.unit_guessed)) {
    const double length = character.leg_length;
    unit = *by_height;
    reason = "The unit of length is assumed to be " + to_text(unit) + " m, with which the legs of the character are " +
             to_fixed(length * unit / out.metres_per_unit, 3) + " m long" +
             (notes.unit_guessed ? "" : "; with the unit that the file states the length would be " + to_fixed(length, 3) + " m") +
             ". Set the unit if it is wrong.";
  }
  if (unit != out.metres_per_unit) {
    std::erase_if(notes.remarks, [](const std::string& r) { return r.starts_with("Lengths are assumed to be in "); });
    for (MeasuredMotion& m : motions) scale(m, unit / out.metres_per_unit);
    out.metres_per_unit = notes.metres_per_unit = unit;
    out.unit_guessed = notes.unit_guessed = true;
  }
  if (!reason.empty()) notes.remarks.push_back(std::move(reason));
}

/// Imports skeleton motions. @param motions at least one, all on the same skeleton  @param mesh_ends see arrange()
Result<Intake> from_measured(std::vector<MeasuredMotion> motions, formats::ReadNotes notes, std::string_view file_name,
                             const IntakeOptions& options, bool mesh_ends = false, formats::FileSkin file_skin = {}) {
  Intake out;
  SkinBinding skin(std::move(file_skin), motions);
  out.source = std::string(base_name(file_name));
  if (Result<void> chosen = choose(motions, options, std::string(file_name), out, notes.remarks); !chosen)
    return fail(std::move(chosen.error()));
  std::optional<std::size_t> take;
  if (!options.take.empty()) {
    const Result<std::size_t> chosen = find_take(motions, options.take, std::string(file_name));
    if (!chosen) return fail(chosen.error());
    take = *chosen;
  }
  const bool single = motions.size() == 1 || take;
  for (MeasuredMotion& m : motions) {
    if (!options.name.empty()) m.name = single ? options.name : options.name + " " + m.name;
    if (options.name.empty() && motions.size() == 1 && is_default_name(m.name)) m.name = stem_of(file_name);
    if (m.name.empty()) m.name = out.source;
  }
  // A character with a skin is known by its file, a body that is made for a motion by the motion.
  const bool of_file = options.name.empty() && (!single || skin.exists());
  const std::string name = of_file ? stem_of(file_name) : single ? motions[take.value_or(0)].name : options.name;
  out.metres_per_unit = notes.metres_per_unit > 0 ? notes.metres_per_unit : motions[0].skeleton.unit;
  apply_corrections(motions, notes, options, out);
  skin.turn(turn_from(notes.z_up, out.axes));
  const body::AnatomyMapping* mapping = options.mapping ? &*options.mapping : nullptr;
  if (mapping)
    if (Error wrong = body::check_mapping(*mapping, motions[0].skeleton, "mapping"); !wrong.empty()) return fail(std::move(wrong));
  const Result<std::optional<SpeciesMass>> species = species_of(motions, options, std::string(file_name));
  if (!species) return fail(species.error());
  body::Character character = arrange(motions, notes.remarks, mapping, mesh_ends);
  skin.reduce(motions);
  if (*species && !mapping && character.plan == body::BodyPlan::human)
    if (std::optional<body::Character> animal = animal_of_species(motions, character)) {
      character = *std::move(animal);
      notes.remarks.push_back("The character is an animal by its names (" + (**species).names + "), although its joints suit a person.");
    }
  if (mapping && character.plan == body::BodyPlan::other && mapping->plan != "other")
    return fail(ErrorCode::structure, "mapping", "The mapping does not give a body: " + character.why_not,
                "Correct the joints of its limbs.");
  // Another motion of the file can show the character lying.
  if (take && character.plan == body::BodyPlan::human)
    if (const body::Character own = body::recognise_character(motions[*take]); own.plan == body::BodyPlan::human) character.up = own.up;
  if (const std::optional<Vec3> up = up_by_posture(character); up && !options.axes) {
    const Vec3 in_file = transpose_times(rotation_to_ours(out.axes), *up);
    for (int k = 0; k < 3; ++k)
      if (std::fabs(in_file[k]) > 0.5) out.axes.up = {k, in_file[k] < 0};
    out.axes.forward = {(out.axes.up.axis + 1) % 3, false};
    for (MeasuredMotion& m : motions) turn(m, turn_from(notes.z_up, out.axes));
    skin.turn(turn_from(notes.z_up, out.axes));
    character.up = rotation_to_ours(out.axes) * in_file;
    notes.remarks.push_back("Up is assumed to be the file's axis " + name_of(out.axes.up) +
                            ", along which trunk and legs of the character point; set the axes if it is wrong.");
  }
  const bool animal = character.plan == body::BodyPlan::four_legs;
  // The body is made for all motions together, in which the limbs can begin at other joints than in the longest one.
  const bool together = animal && !mapping && motions.size() > 1;
  const body::Character whole = together ? body::recognise_character(joined(motions)) : character;
  const double unit_before = out.metres_per_unit;
  set_size(motions, whole.plan == body::BodyPlan::four_legs ? whole : character, *species, notes, options, out);
  if (out.metres_per_unit != unit_before) skin.scale(out.metres_per_unit / unit_before);
  character.leg_length *= out.metres_per_unit / unit_before;
  // Parts and size follow from all motions of the file, so that they do not depend on the chosen one.
  if (take) motions = {std::move(motions[*take])};
  std::vector<std::string> checks;
  for (MeasuredMotion& m : motions)
    for (const auto cut : {cut_at_jumps, cut_at_holds})
      if (std::string sentence = cut(character, m); !sentence.empty())
        notes.remarks.push_back((motions.size() > 1 ? m.name + ": " : "") + sentence);
  std::vector<char> on_belt(motions.size(), 0);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    MeasuredMotion& m = motions[i];
    if (const MissingTravel travel = find_missing_travel(character, m); travel.exists()) {
      out.walks_in_place = true;
      const std::string speed = to_fixed(norm(travel.velocity), 2) + " m/s";
      if (options.travel) {
        add_travel(m, travel.shift);
        notes.remarks.push_back(m.name + ": a travel of " + speed +
                                (travel.steady ? "" : " on the average, with the changing speed of its standing feet,") +
                                " was added, because the character walks in place and its standing feet slide.");
      } else {
        on_belt[i] = 1;
        checks.push_back(
            m.name + ": the character walks in place (on a treadmill); its standing feet slide at " + speed +
            (travel.steady ? "" : " on the average") +
            ". Under dynamics it will fall. Add the travel of its steps (in the studio: Add travel; on the command line: --travel).");
      }
    }
  }
  describe(out.conversion, motions);
  if (notes.unit_guessed) out.report.push_back("Unit of length guessed: " + to_text(notes.metres_per_unit) + " m.");
  out.report.insert(out.report.end(), notes.remarks.begin(), notes.remarks.end());

  if (auto error = stopped(options, file_name)) return fail(std::move(*error));
  body::BodyOptions body_options;
  body_options.height = options.height;
  body_options.mass = options.mass;
  body_options.mapping = mapping;
  std::optional<body::AnatomyMapping> found;
  const MeasuredMotion all = motions.size() == 1 ? motions[0] : joined(motions);
  Result<body::Body> body = body::make_body(all, body_options);
  // Jumps, rolls and falls in other motions of the file can hide limbs that are clear in the longest motion, or raise an animal's trunk.
  if (body && !mapping && character.plan != body::BodyPlan::other &&
      body->anatomy.plan != (character.plan == body::BodyPlan::human ? "human" : "four legs")) {
    found = body::mapping_of(character, motions[0].skeleton);
    body::BodyOptions as_found = body_options;
    as_found.mapping = &*found;
    if (Result<body::Body> again = body::make_body(all, as_found); again && again->anatomy.plan == found->plan) {
      body = std::move(again);
      body_options.mapping = &*found;
      if (motions.size() > 1)
        out.report.push_back(
            "The parts of the character are those of its longest motion; in all motions together they were not recognised.");
    }
  }
  if (body && *species && body->anatomy.plan == "four legs" && options.mass == 0)
    if (std::string sentence = limit_mass(*body, **species, all, body_options); !sentence.empty())
      out.report.push_back(std::move(sentence));
  if (!body) return fail(in_file(std::move(body.error()), file_name));
  Result<MechanismPtr> mechanism = finished(*body, name, skin);
  if (!mechanism) return fail(in_file(std::move(mechanism.error()), file_name));
  body->mechanism = *mechanism;
  out.report.insert(out.report.end(), body->report.begin(), body->report.end());
  if (motions.size() > 1) out.report.push_back("The file contains " + std::to_string(motions.size()) + " motions of one skeleton.");
  out.conversion.add_remarks(notes.remarks);
  out.conversion.add_remarks(body->report);
  if (body->mechanism->skin()) out.report.push_back(out.conversion.read.emplace_back(describe(*body->mechanism->skin())));
  describe(out.conversion, *body, motions[0]);
  store::LibraryItem mechanism_item{
      store::EntryKind::mechanism, name, {}, options.tags, bytes_of(formats::write_mechanism(*body->mechanism))};
  Json summary = mechanism_summary(*body->mechanism, out.source);
  summary["height"] = body->height;
  summary["human"] = body->human;
  if (body->mechanism->skin()) summary["skin"] = {{"bytes", bytes_of(*body->mechanism->skin())}};
  mechanism_item.summary = text_of(summary);
  const std::string mechanism_id = store::entry_id(store::EntryKind::mechanism, mechanism_item.data);
  out.items = {std::move(mechanism_item)};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (auto error = stopped(options, file_name)) return fail(std::move(*error));
    if (character.plan != body::BodyPlan::other && options.travel)
      for (const auto& [sentence, far] : suit_to_gravity(motions[i], *body)) {
        if (far) checks.push_back(sentence);
        if (far) continue;
        out.report.push_back(sentence);
        out.conversion.add_remarks({sentence});
      }
    Motion motion;
    auto items = motion_items(motions[i], *body, mechanism_id, out.source, options, motion);
    if (!items) return fail(in_file(std::move(items.error()), file_name));
    for (store::LibraryItem& item : *items) out.items.push_back(std::move(item));
    if (std::string sentence = describe_missing_support(*body->mechanism, motion, body->height, on_belt[i] != 0); !sentence.empty())
      checks.push_back(std::move(sentence));
    if (i == 0) out.motion = std::move(motion);
  }
  out.report.insert(out.report.end(), checks.begin(), checks.end());
  out.conversion.check.insert(out.conversion.check.end(), checks.begin(), checks.end());
  out.mechanism = body->mechanism;
  out.measured = std::move(motions[0]);
  out.body = std::move(*body);
  return out;
}

Result<Intake> from_measured(MeasuredMotion motion, formats::ReadNotes notes, std::string_view file_name, const IntakeOptions& options) {
  std::vector<MeasuredMotion> motions;
  motions.push_back(std::move(motion));
  return from_measured(std::move(motions), std::move(notes), file_name, options);
}

/// Imports a marker recording: solves it for a skeleton motion and reports the quality of the fit.
Result<Intake> from_markers(Result<MarkerMotion> markers, formats::ReadNotes notes, std::string_view file_name, IntakeOptions options) {
  if (!markers) return fail(std::move(markers.error()));
  const Orientation axes = options.axes.value_or(usual_orientation(notes.z_up));
  if (axes != usual_orientation(notes.z_up)) turn(*markers, turn_from(notes.z_up, axes));
  if (options.frame_rate > 0) set_rate(*markers, options.frame_rate);
  options.axes.reset();
  options.frame_rate = 0;
  if (std::string sentence = cut_markers_at_jumps(*markers); !sentence.empty()) notes.remarks.push_back(std::move(sentence));
  if (auto error = stopped(options, file_name)) return fail(std::move(*error));
  capture::CaptureOptions capture_options;
  capture_options.cancelled = options.cancelled;
  capture_options.correct_labels = options.correct_labels;
  Result<capture::Capture> solved = capture::solve_markers(*markers, capture_options);
  if (auto error = stopped(options, file_name)) return fail(std::move(*error));
  if (!solved) return fail(std::move(solved.error()));
  notes.remarks.insert(notes.remarks.end(), solved->report.begin(), solved->report.end());
  const auto worst =
      std::max_element(solved->residuals.begin(), solved->residuals.end(), [](const auto& a, const auto& b) { return a.rms < b.rms; });
  if (worst != solved->residuals.end())
    notes.remarks.push_back("The worst marker is " + worst->label + " with " + to_fixed(1000 * worst->rms, 1) +
                            " mm rms and a maximum of " + to_fixed(1000 * worst->maximum, 1) + " mm in frame " +
                            std::to_string(worst->worst_frame) + ".");
  Result<Intake> out = from_measured(std::move(solved->measured), std::move(notes), file_name, options);
  if (!out) return out;
  out->axes = axes;
  if (worst != solved->residuals.end() && worst->rms > 0.03)
    out->conversion.check.push_back("Marker " + worst->label + " is " + to_fixed(1000 * worst->rms, 0) +
                                    " mm rms away from its position on the body: check that it is labelled correctly.");
  ConversionReport recorded;
  describe(recorded, *markers);
  for (auto part : {&ConversionReport::read, &ConversionReport::left_out, &ConversionReport::check})
    (out->conversion.*part).insert((out->conversion.*part).begin(), (recorded.*part).begin(), (recorded.*part).end());
  out->markers = std::move(*markers);
  return out;
}

/// The mechanism with its base links rotated by R.
Result<MechanismPtr> turned(const Mechanism& mechanism, const Mat3& R) {
  MechanismSpec spec = mechanism.spec();
  for (LinkSpec& link : spec.links)
    if (link.parent.empty() && link.real.empty()) link.joint.X_PJ = Pose{R, {}} * link.joint.X_PJ;
  return Mechanism::make(std::move(spec));
}

/// Imports a mechanism without motion.
Result<Intake> from_mechanism(Result<MechanismPtr> mechanism, std::string_view file_name, const IntakeOptions& options) {
  if (!mechanism) return fail(std::move(mechanism.error()));
  const std::string name = !options.name.empty() ? options.name : !(*mechanism)->name().empty() ? (*mechanism)->name() : stem_of(file_name);
  if ((*mechanism)->name() != name) {
    MechanismSpec spec = (*mechanism)->spec();
    spec.name = name;
    mechanism = Mechanism::make(std::move(spec));
  }
  Intake out;
  if (options.axes) out.axes = *options.axes;
  if (mechanism && out.axes != usual_orientation(true)) mechanism = turned(**mechanism, turn_from(true, out.axes));
  if (auto error = stopped(options, file_name)) return fail(std::move(*error));
  if (mechanism) mechanism = geometry::prepare(*mechanism);
  if (!mechanism) return fail(std::move(mechanism.error()));
  out.source = std::string(base_name(file_name));
  out.mechanism = std::move(*mechanism);
  describe(out.conversion, *out.mechanism);
  out.items = {{store::EntryKind::mechanism, name, text_of(mechanism_summary(*out.mechanism, out.source)), options.tags,
                bytes_of(formats::write_mechanism(*out.mechanism))}};
  return out;
}

Result<Intake> from_robot(std::string_view text, std::string_view file_name, const IntakeOptions& options) {
  Result<robot_formats::RobotModel> robot = robot_formats::read_robot_file(text, file_name, options.robot);
  if (!robot) return fail(std::move(robot.error()));
  Result<Intake> out = from_mechanism(robot->mechanism, file_name, options);
  if (!out) return out;
  out->report = robot->notes;
  out->conversion.add_remarks(robot->notes);
  out->robot = std::move(*robot);
  return out;
}

}  // namespace

std::string Intake::id_of(store::EntryKind kind) const {
  for (const store::LibraryItem& item : items)
    if (item.kind == kind) return store::entry_id(kind, item.data);
  return {};
}

std::optional<FileKind> file_kind(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  std::string ending(file_name.substr(dot + 1));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (ending == "bvh") return FileKind::bvh;
  if (ending == "amc") return FileKind::amc;
  if (ending == "asf") return FileKind::asf;
  if (ending == "c3d") return FileKind::c3d;
  if (ending == "trc") return FileKind::trc;
  if (ending == "csv") return FileKind::csv;
  if (ending == "gltf" || ending == "glb") return FileKind::gltf;
  if (ending == "fbx" || ending == "dae") return FileKind::scene;
  if (ending == "obj" || ending == "stl" || ending == "ply") return FileKind::mesh;
  if (ending == "usda" || ending == "usd" || ending == "usdc" || ending == "usdz") return FileKind::usd;
  if (ending == "mvnx") return FileKind::mvnx;
  if (ending == "npz") return FileKind::smpl;
  if (ending == "mot" || ending == "sto") return FileKind::opensim;
  if (ending == "txt") return FileKind::deepmimic;
  if (ending == "json") return FileKind::mechanism_json;
  if (ending == "urdf" || ending == "sdf" || ending == "xml" || ending == "xacro" || ending == "osim") return FileKind::robot;
  return std::nullopt;
}

std::string skeleton_name_for(std::string_view amc_name) {
  const std::string stem = stem_of(amc_name);
  const std::size_t underscore = stem.rfind('_');
  return std::string(amc_name.substr(0, amc_name.size() - base_name(amc_name).size())) + stem.substr(0, underscore) + ".asf";
}

Result<Intake> take_in(std::string_view bytes, std::string_view file_name, const formats::Asf* asf, const IntakeOptions& options) {
  std::optional<FileKind> kind = file_kind(file_name);
  const std::string location(file_name);
  if (kind == FileKind::deepmimic) {  // other texts have this extension too
    const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos || bytes[begin] != '{') kind.reset();
  }
  if (options.axes && !options.axes->valid())
    return fail(ErrorCode::range, location, "Up and forward cannot be the same axis.", "Choose another forward axis.");
  if (!kind)
    return fail(
        ErrorCode::unsupported, location, "Files with this extension cannot be imported.",
        "Use a .bvh, .amc (with its .asf), .c3d, .trc, .csv, .gltf, .glb, .fbx, .dae, .usda, .mvnx, .npz, .mot, .sto, .txt (DeepMimic), "
        ".obj, .stl, .ply, mechanism .json, .urdf, .sdf, .osim or MJCF .xml file.");
  if (auto error = stopped(options, file_name)) return fail(std::move(*error));
  if ((*kind == FileKind::gltf || *kind == FileKind::scene) && is_still(bytes))
    if (Result<Intake> mesh = take_in_mesh(bytes, file_name, options)) return mesh;
  formats::ReadNotes notes;
  switch (*kind) {
    case FileKind::bvh: {
      formats::BvhOptions bvh;
      bvh.metres_per_unit = options.unit;
      Result<MeasuredMotion> measured = formats::read_bvh(bytes, file_name, bvh, &notes);
      if (!measured) return fail(std::move(measured.error()));
      return from_measured(std::move(*measured), std::move(notes), file_name, options);
    }
    case FileKind::amc: {
      if (!asf)
        return fail(ErrorCode::structure, location, "An AMC file needs its skeleton.",
                    "Add the ASF file that belongs to it (" + skeleton_name_for(base_name(file_name)) + ").");
      formats::AmcOptions amc;
      amc.rate = options.rate;
      Result<MeasuredMotion> measured = formats::read_amc(bytes, file_name, *asf, amc, &notes);
      if (!measured) return fail(std::move(measured.error()));
      if (options.unit > 0) scale(*measured, options.unit / measured->skeleton.unit);
      return from_measured(std::move(*measured), std::move(notes), file_name, options);
    }
    case FileKind::c3d:
    case FileKind::trc:
    case FileKind::csv: {
      if (*kind == FileKind::csv && formats::csv_kind(bytes) == formats::CsvKind::coordinates)
        return fail(ErrorCode::structure, location, "The file contains the coordinates of a mechanism, but not the mechanism.",
                    "Convert it with its mechanism: ugoki convert FILE OUT --mechanism MECHANISM.");
      Result<MarkerMotion> markers = read_markers(bytes, file_name, options, notes);
      return from_markers(std::move(markers), std::move(notes), file_name, options);
    }
    case FileKind::scene: {
      const std::span raw(bytes.data(), bytes.size());
      Result<std::vector<MeasuredMotion>> motions =
          scene_formats::read_scene(std::as_bytes(raw), file_name, {.metres_per_unit = options.unit, .mesh_ends = true}, &notes);
      if (!motions) return fail(std::move(motions.error()));
      if (std::optional<Intake> parts = take_in_rigid_parts(bytes, file_name, options, *motions)) return std::move(*parts);
      formats::FileSkin skin = skin_of_scene(std::as_bytes(raw), file_name, options, notes);
      return from_measured(std::move(*motions), std::move(notes), file_name, options, true, std::move(skin));
    }
    case FileKind::usd: {
      Result<MeasuredMotion> measured = scene_formats::read_usd(bytes, file_name, {.metres_per_unit = options.unit}, &notes);
      if (!measured) return fail(std::move(measured.error()));
      return from_measured(std::move(*measured), std::move(notes), file_name, options);
    }
    case FileKind::gltf: {
      const std::span raw(bytes.data(), bytes.size());
      Result<std::vector<MeasuredMotion>> motions =
          formats::read_gltf(std::as_bytes(raw), file_name, {.metres_per_unit = options.unit, .mesh_ends = true, .files = options.files},
                             scene_formats::unpack_meshopt, &notes);
      if (!motions) return fail(std::move(motions.error()));
      if (std::optional<Intake> parts = take_in_rigid_parts(bytes, file_name, options, *motions)) return std::move(*parts);
      formats::FileSkin skin = skin_of_gltf(std::as_bytes(raw), file_name, options, notes);
      return from_measured(std::move(*motions), std::move(notes), file_name, options, true, std::move(skin));
    }
    case FileKind::mvnx:
    case FileKind::opensim:
    case FileKind::deepmimic:
    case FileKind::smpl: {
      if (*kind == FileKind::opensim && options.model.empty())
        return fail(ErrorCode::structure, location, "A motion of OpenSim contains coordinates, but not the model.",
                    "Name its model with --skeleton MODEL.osim.");
      const scene_formats::SmplModelFile model{std::as_bytes(std::span(options.model)), options.model_name};
      Result<MeasuredMotion> measured =
          *kind == FileKind::mvnx      ? scene_formats::read_mvnx(bytes, file_name, &notes)
          : *kind == FileKind::opensim ? scene_formats::read_opensim(bytes, file_name, options.model, options.model_name, &notes)
          : *kind == FileKind::deepmimic
              ? scene_formats::read_deepmimic(bytes, file_name, options.model, options.model_name, &notes)
              : scene_formats::read_smpl(std::as_bytes(std::span(bytes.data(), bytes.size())), file_name, model, &notes);
      if (!measured) return fail(std::move(measured.error()));
      if (options.unit > 0) scale(*measured, options.unit);
      return from_measured(std::move(*measured), std::move(notes), file_name, options);
    }
    case FileKind::asf:
      return fail(ErrorCode::structure, location, "An ASF file contains a skeleton without motion.",
                  "Import an AMC file that belongs to it.");
    case FileKind::mechanism_json: return from_mechanism(formats::read_mechanism(bytes, file_name), file_name, options);
    case FileKind::mesh: return take_in_mesh(bytes, file_name, options);
    case FileKind::robot: return from_robot(bytes, file_name, options);
  }
  return fail(ErrorCode::unsupported, location, "This kind of file cannot be imported.", "Use a .bvh or .amc file.");
}

Result<MarkerMotion> read_markers(std::string_view bytes, std::string_view file_name, const IntakeOptions& options,
                                  formats::ReadNotes& notes) {
  const std::optional<FileKind> kind = file_kind(file_name);
  const formats::MarkerOptions reading{.metres_per_unit = options.unit};
  Result<MarkerMotion> markers =
      kind == FileKind::c3d   ? formats::read_c3d(std::as_bytes(std::span(bytes.data(), bytes.size())), file_name, reading, &notes)
      : kind == FileKind::trc ? formats::read_trc(bytes, file_name, reading, &notes)
      : kind == FileKind::csv
          ? formats::read_csv(bytes, file_name, reading, &notes)
          : fail(ErrorCode::unsupported, std::string(file_name), "This is not a recording of markers.", "Use a .c3d, .trc or .csv file.");
  if (!markers || !options.mapping) return markers;
  for (const auto& [own, known] : options.mapping->labels) {
    const int marker = markers->find(own);
    if (marker < 0)
      return fail(ErrorCode::unknown, "mapping:labels/" + own, "The recording has no marker '" + own + "'.",
                  "List its markers with `ugoki info FILE`.");
    markers->labels[static_cast<std::size_t>(marker)] = known;
  }
  std::vector<std::string> sorted = markers->labels;
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
    return fail(ErrorCode::duplicate, "mapping:labels", "Two markers have the label '" + *twice + "'.", "Give each marker another label.");
  return markers;
}

Result<std::vector<std::string>> put(store::Library& library, const Intake& intake) { return library.put(intake.items); }

}  // namespace ugoki::intake
