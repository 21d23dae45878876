// `ugoki info`: prints the contents of a file or an entry of the library.

#include <memory>

#include "fmu.h"
#include "mechanism_info.h"
#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/content/executable.h"
#include "ugoki/content/flatten.h"
#include "ugoki/content/ugx.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/intake/mapping_file.h"
#include "ugoki/project/project.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string target;
  SourceOptions source;
  std::string mapping_out;
  bool tree = false, json = false;
};

Json motion_json(const Motion& m) {
  Json contacts = Json::array();
  for (const ContactTrack& c : m.contacts) {
    long on = 0;
    for (const std::uint8_t x : c.on) on += x != 0;
    contacts.push_back({{"link", c.link}, {"share", m.frames > 0 ? static_cast<double>(on) / m.frames : 0.0}});
  }
  return {{"name", m.name},      {"source", m.source}, {"mechanism", m.mechanism},
          {"frames", m.frames},  {"rate", m.rate},     {"duration_s", m.duration()},
          {"coordinates", m.nq}, {"cyclic", m.cyclic}, {"contacts", std::move(contacts)}};
}

Json measured_json(const MeasuredMotion& m) {
  Json joints = Json::array();
  for (const SkeletonJoint& j : m.skeleton.joints)
    joints.push_back(
        {{"name", j.name}, {"parent", j.parent}, {"dofs", j.dofs.size()}, {"order", j.rotation_order}, {"translates", j.translates}});
  return {{"name", m.name},
          {"source", m.source},
          {"frames", m.frames},
          {"rate", m.rate},
          {"duration_s", m.duration()},
          {"joints_count", m.joint_count()},
          {"height_m", rest_height(m.skeleton)},
          {"metres_per_unit", m.skeleton.unit},
          {"joints", std::move(joints)}};
}

Json anatomy_json(const body::AnatomyMapping& anatomy) {
  Json limbs = Json::array();
  for (const body::LimbMapping& l : anatomy.limbs) {
    std::string sections;
    for (const body::SectionJoint& s : l.sections)
      if (!s.joint.empty()) sections += (sections.empty() ? "" : ", ") + s.section + " = " + s.joint;
    limbs.push_back({{"limb", l.name}, {"confidence", l.confidence}, {"sections", sections}, {"evidence", l.evidence}});
  }
  return {{"plan", anatomy.plan}, {"confidence", anatomy.confidence}, {"limbs", std::move(limbs)}};
}

/// @param document whose nested scenarios are described by the characters that they add
Json scenario_json(const content::Scenario& document) {
  const content::Scenario s = content::flatten(document);
  Json characters = Json::array();
  for (const content::ScenarioCharacter& c : s.characters)
    characters.push_back(
        {{"id", c.id}, {"name", c.name}, {"mechanism", c.mechanism}, {"mode", name_of(c.control.mode)}, {"clips", c.track.size()}});
  return {{"name", s.name},
          {"duration_s", s.duration},
          {"frame_rate", s.frame_rate},
          {"step_s", s.step},
          {"characters", std::move(characters)},
          {"events", s.events.size()},
          {"instances", document.instances.size()},
          {"circuit", s.circuit.empty() ? "default" : "own"}};
}

Result<Json> info_of_entry(const Options& options) {
  const Result<store::Library> library = store::Library::open_read_only(library_path(options.source.library));
  if (!library) return fail(library.error());
  print_warning(library->warning());
  const Result<store::LibraryEntry> entry = library->resolve(options.target);
  if (!entry) return fail(entry.error());
  const Result<std::vector<std::byte>> data = library->data(entry->id);
  if (!data) return fail(data.error());
  const std::string location = "library entry " + entry->id;
  Json json = {{"kind", store::name_of(entry->kind)}, {"id", entry->id}, {"tags", entry->tags}};
  if (entry->kind == store::EntryKind::mechanism) {
    const Result<MechanismPtr> mechanism = formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, location);
    if (!mechanism) return fail(mechanism.error());
    json.update(mechanism_json(**mechanism));
  } else if (entry->kind == store::EntryKind::motion) {
    const Result<Motion> motion = formats::read_motion(*data, location);
    if (!motion) return fail(motion.error());
    json.update(motion_json(*motion));
  } else {
    const Result<MeasuredMotion> measured = formats::read_measured_motion(*data, location);
    if (!measured) return fail(measured.error());
    json.update(measured_json(*measured));
  }
  json["name"] = entry->name;
  return json;
}

Result<Json> info_of_executable(const std::string& path) {
  const Result<std::string> text = files::read_file(path);
  if (!text) return fail(text.error());
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(text->data()), text->size());
  const Result<content::Executable> executable = content::read_executable(bytes, path);
  if (!executable) return fail(executable.error());
  const auto file = content::read_ugx(bytes);
  Json sections = Json::array();
  for (const content::UgxSection& s : file->sections()) sections.push_back({{"name", s.name}, {"bytes", s.bytes.size()}});
  Json characters = Json::array();
  for (const content::ExecutableCharacter& c : executable->characters)
    characters.push_back({{"id", c.id},
                          {"name", c.name},
                          {"mechanism", executable->mechanism_ids[static_cast<std::size_t>(c.mechanism)]},
                          {"clips", c.track.size()}});
  return Json{{"kind", "executable data"},
              {"name", executable->name},
              {"version", content::ugx_version},
              {"bytes", bytes.size()},
              {"duration_s", executable->duration},
              {"frame_rate", executable->frame_rate},
              {"step_s", executable->step},
              {"mechanisms", executable->mechanisms.size()},
              {"motions", executable->motions.size()},
              {"characters", std::move(characters)},
              {"events", executable->events.size()},
              {"sections", std::move(sections)}};
}

/// A mesh file, from which props are made.
Json info_of_mesh(const intake::Intake& loaded) {
  const intake::MeshBody& mesh = *loaded.mesh;
  Json json = {{"kind", "mesh"},           {"triangles", mesh.triangles}, {"size_m", {mesh.size.x, mesh.size.y, mesh.size.z}},
               {"volume_m3", mesh.volume}, {"closed", mesh.closed},       {"parts", mesh.parts},
               {"colors", mesh.colors}};
  if (!loaded.report.empty()) json["report"] = loaded.report;
  return json;
}

/// Labels of a recording of markers to which no body could be fitted, with the reason. Other files: the error.
Result<Json> info_of_recording(const Options& options, const Error& why) {
  const Result<std::string> bytes = files::read_file(options.target);
  if (!bytes) return fail(bytes.error());
  formats::ReadNotes notes;
  const Result<MarkerMotion> m = intake::read_markers(*bytes, options.target, options.source.intake, notes);
  if (!m) return fail(why);
  Json problems = Json::array();
  for (const Problem& p : why.problems) problems.push_back(p.text());
  if (!options.mapping_out.empty()) {
    body::AnatomyMapping mapping;
    for (const std::string& label : m->labels) mapping.labels.emplace_back(label, "");
    if (Result<void> written = files::write_file(options.mapping_out, intake::write_mapping(mapping)); !written)
      return fail(std::move(written.error()));
  }
  return Json{{"kind", "recording of markers"},
              {"name", m->name},
              {"frames", m->frames},
              {"rate", m->rate},
              {"duration_s", m->duration()},
              {"metres_per_unit", m->unit},
              {"seen_share", seen_share(*m)},
              {"labels", m->labels},
              {"no_body", std::move(problems)},
              {"report", notes.remarks}};
}

Result<Json> info_of(const Options& options) {
  if (options.target.ends_with(".fmu")) return fmu_info(options.target);
  const Result<TargetKind> kind = kind_of(options.target);
  if (!kind) return fail(kind.error());
  switch (*kind) {
    case TargetKind::entry: return info_of_entry(options);
    case TargetKind::executable: return info_of_executable(options.target);
    case TargetKind::project: {
      const Result<project::Project> project = project::Project::open_read_only(options.target);
      if (!project) return fail(project.error());
      print_warning(project->warning());
      Json json = {{"kind", "project"}};
      json.update(scenario_json(project->scenario()));
      json["unsaved"] = project->unsaved();
      Json mechanisms = Json::array(), motions = Json::array();
      for (const auto& [id, m] : project->resources().mechanisms)
        if (!content::is_prop_mechanism(id))
          mechanisms.push_back({{"id", id}, {"name", m->name()}, {"links", m->link_count()}, {"dofs", m->nv()}, {"mass_kg", m->mass()}});
      for (const auto& [id, m] : project->resources().motions)
        motions.push_back({{"id", id}, {"name", m->name}, {"frames", m->frames}, {"duration_s", m->duration()}, {"cyclic", m->cyclic}});
      json["mechanisms"] = std::move(mechanisms);
      json["motions"] = std::move(motions);
      return json;
    }
    case TargetKind::library: {
      const Result<store::Library> library = store::Library::open_read_only(options.target);
      if (!library) return fail(library.error());
      print_warning(library->warning());
      Json json = {{"kind", "library"}, {"file", options.target}};
      for (const store::EntryKind of : store::entry_kinds) {
        const Result<std::size_t> count = library->count(of);
        if (!count) return fail(count.error());
        json[std::string(store::name_of(of))] = *count;
      }
      return json;
    }
    case TargetKind::mechanism_file: {
      const Result<intake::Intake> loaded = take_in_file(options.target, options.source);
      if (!loaded) return fail(loaded.error());
      if (loaded->mesh) return info_of_mesh(*loaded);
      Json json = {{"kind", "mechanism"}};
      json.update(mechanism_json(*loaded->mechanism, loaded->robot ? &*loaded->robot : nullptr));
      if (!loaded->report.empty()) json["report"] = loaded->report;
      return json;
    }
    case TargetKind::measured_file: {
      const Result<intake::Intake> loaded = take_in_file(options.target, options.source);
      if (!loaded) return info_of_recording(options, loaded.error());
      if (loaded->mesh) return info_of_mesh(*loaded);
      Json json = {{"kind", "measured"}};
      json.update(measured_json(*loaded->measured));
      json["height_m"] = loaded->body->height;
      json["mass_kg"] = loaded->body->mass;
      if (!options.mapping_out.empty())
        if (Result<void> written = files::write_file(options.mapping_out, intake::write_mapping(loaded->body->anatomy)); !written)
          return fail(std::move(written.error()));
      json["characters"] = loaded->characters;
      json["takes"] = loaded->takes;
      json["anatomy"] = anatomy_json(loaded->body->anatomy);
      json["body"] = mechanism_json(*loaded->mechanism);
      json["report"] = loaded->report;
      return json;
    }
  }
  return fail(ErrorCode::unsupported, options.target, "The kind of this file is unknown.",
              "Name a file of a kind that `ugoki info --help` lists.");
}

/// Prints JSON as text: one line for each scalar value, a table for each list of objects.
void print_text(const Json& json, const std::string& indent) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object()) {
      print_line(indent + key);
      print_text(value, indent + "  ");
    } else if (value.is_array() && !value.empty() && value[0].is_object()) {
      print_line(indent + key);
      std::vector<std::vector<std::string>> rows(1);
      for (const auto& [column, ignored] : value[0].items()) rows[0].push_back(indent + "  " + column);
      for (const Json& row : value) {
        std::vector<std::string> cells;
        for (const auto& [column, cell] : row.items())
          cells.push_back(indent + "  " +
                          (cell.is_string()         ? cell.get<std::string>()
                           : cell.is_number_float() ? to_fixed(cell.get<double>(), 3)
                                                    : cell.dump()));
        rows.push_back(std::move(cells));
      }
      print_table(rows);
    } else if (value.is_array()) {
      std::string line = indent + key + std::string(key.size() < 18 ? 18 - key.size() : 1, ' ');
      if (value.empty()) print_line(line + "none");
      for (const Json& item : value) {
        print_line(line + (item.is_string() ? item.get<std::string>() : item.dump()));
        line = indent + std::string(18, ' ');
      }
    } else {
      const std::string text = value.is_string()         ? value.get<std::string>()
                               : value.is_number_float() ? to_text(value.get<double>())
                                                         : value.dump();
      print_line(indent + key + std::string(key.size() < 18 ? 18 - key.size() : 1, ' ') + text);
    }
  }
}

int run_info(const Options& options) {
  if (Result<void> may = check_outputs(input_files(options.target, options.source), {{"--mapping-out", options.mapping_out}}); !may)
    return print_error(may.error(), options.json);
  const Result<Json> json = info_of(options);
  if (!json) return print_error(json.error(), options.json);
  if (options.json)
    print_json(*json);
  else
    print_text(*json, "");
  return 0;
}

}  // namespace

void add_info_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb =
      app.add_subcommand("info", "Print the contents of a file or an entry of the library: counts, tree, masses, degrees of freedom.");
  verb.add_option("target", options->target,
                  "BVH, AMC, mechanism JSON, URDF, SDF, MJCF, *.fmu, *.ugoki, *.ugx, a library, or an entry's name or id")
      .required();
  add_skeleton_option(verb, options->source);
  add_robot_options(verb, options->source.robot);
  add_correction_options(verb, options->source);
  add_library_option(verb, options->source.library);
  verb.add_option("--mapping-out", options->mapping_out,
                  "Write the recognised anatomy of a motion file as JSON, to edit it and use it with --mapping");
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki info walk.bvh\n  ugoki info robot.urdf --base fixed\n  ugoki info park.ugoki --json");
  verb.callback([options, &action] { action = [options] { return run_info(*options); }; });
}

}  // namespace ugoki::cli
