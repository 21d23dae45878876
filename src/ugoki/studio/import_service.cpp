#include "ugoki/studio/import_service.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <utility>

#include "ugoki/body/body.h"
#include "ugoki/intake/mapping_file.h"
#include "ugoki/samples/samples.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/display_json.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

constexpr std::size_t max_stages = 64;
constexpr std::size_t max_bytes = std::size_t{768} << 20;  // maximum size of all stages (files not yet stored) and companion files together

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// The file name in lower case without folders: "folder/Left.STL" -> "left.stl".
std::string plain_name(std::string_view path) {
  std::string name(path.substr(path.find_last_of("/\\") + 1));
  std::ranges::transform(name, name.begin(), [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return name;
}

const char* name_of(intake::FileKind kind) {
  switch (kind) {
    case intake::FileKind::bvh: return "BVH";
    case intake::FileKind::amc: return "AMC";
    case intake::FileKind::asf: return "ASF";
    case intake::FileKind::c3d: return "C3D";
    case intake::FileKind::trc: return "TRC";
    case intake::FileKind::csv: return "CSV";
    case intake::FileKind::gltf: return "glTF";
    case intake::FileKind::scene: return "FBX or COLLADA";
    case intake::FileKind::usd: return "USD";
    case intake::FileKind::mvnx: return "MVNX";
    case intake::FileKind::smpl: return "SMPL";
    case intake::FileKind::opensim: return "OpenSim";
    case intake::FileKind::deepmimic: return "DeepMimic";
    case intake::FileKind::mechanism_json: return "Mechanism";
    case intake::FileKind::robot: return "Robot description";
    case intake::FileKind::mesh: return "Mesh";
    default: return "Motion";
  }
}

Json report_json(const intake::ConversionReport& r) {
  return {{"read", r.read}, {"guessed", r.guessed}, {"changed", r.changed}, {"left_out", r.left_out}, {"check", r.check}};
}

/// JSON of the recognised anatomy: plan, limbs with the links that belong to them, and the joints from which sections can be chosen.
Json anatomy_json(const body::Body& body, const MeasuredMotion& measured) {
  Json document = Json::parse(intake::write_mapping(body.anatomy));
  for (std::size_t k = 0; k < body.anatomy.limbs.size(); ++k) {
    Json links = Json::array();
    for (const int joint : body.anatomy.limbs[k].joints) links.push_back(body.link_of_joint[static_cast<std::size_t>(joint)]);
    document["limbs"][k]["links"] = std::move(links);
  }
  Json joints = Json::array();
  for (const SkeletonJoint& j : measured.skeleton.joints) joints.push_back(j.name);
  document["joints"] = std::move(joints);
  return document;
}

/// JSON list of the library entries that storing will create. Measured data are not listed, because they belong to their motion.
Json entries_json(const intake::Intake& intake_result) {
  Json entries = Json::array();
  for (const store::LibraryItem& item : intake_result.items)
    if (item.kind != store::EntryKind::measured)
      entries.push_back({{"kind", store::name_of(item.kind)}, {"name", item.name}, {"bytes", item.data.size()}});
  return entries;
}

/// JSON of a stage (a file that was read but not stored): settings used, conversion report, mechanism and motion.
std::string stage_json(std::string_view id, const std::string& file, const intake::Intake& intake_result, const ImportSettings& chosen) {
  const intake::FileKind kind = intake::file_kind(file).value_or(intake::FileKind::bvh);
  const bool moves = intake_result.motion.has_value();
  Json j = {{"stage", id},
            {"file", file},
            {"format", name_of(kind)},
            {"settings",
             {{"unit", intake_result.metres_per_unit},
              {"unit_guessed", intake_result.unit_guessed},
              {"up", intake::name_of(intake_result.axes.up)},
              {"forward", intake::name_of(intake_result.axes.forward)},
              {"rate", moves ? intake_result.motion->rate : 0.0},
              {"rate_specified", kind != intake::FileKind::amc},
              {"mapping", chosen.mapping},
              {"character", chosen.character},
              {"take", chosen.take},
              {"travel", chosen.travel}}},
            {"characters", intake_result.characters},
            {"takes", intake_result.takes},
            {"can",
             {{"unit", moves || intake_result.mesh},
              {"axes", intake_result.mechanism != nullptr},
              {"rate", moves},
              {"travel", intake_result.walks_in_place}}},
            {"entries", entries_json(intake_result)},
            {"report", report_json(intake_result.conversion)}};
  if (intake_result.mesh) j["mesh"] = {{"colors", intake_result.mesh->colors}};
  if (intake_result.mechanism) j["mechanism"] = Json::parse(mechanism_json(id, *intake_result.mechanism));
  // The height of the library entry, and not the extent of the neutral position, which depends on the pose of the file's skeleton at rest.
  if (intake_result.body) j["mechanism"]["height"] = intake_result.body->height;
  if (intake_result.body && intake_result.measured) j["anatomy"] = anatomy_json(*intake_result.body, *intake_result.measured);
  if (moves) j["motion"] = Json::parse(motion_json(id, *intake_result.motion, *intake_result.mechanism));
  if (intake_result.markers && moves) j["markers"] = Json::parse(markers_json(*intake_result.markers));
  if (intake_result.markers && intake_result.body && intake_result.measured) {
    const Pose X = body::calc_floor_pose(*intake_result.body, *intake_result.measured);
    j["markers"]["pose"] = pose_json(X);
  }
  return text_of(j);
}

}  // namespace

Result<const formats::Asf*> ImportService::skeleton_for(const std::string& file) const {
  const auto named = skeletons_.find(plain_name(intake::skeleton_name_for(file)));
  const auto sent = named != skeletons_.end() ? named : skeletons_.find(last_skeleton_);
  if (sent != skeletons_.end()) return &sent->second;
  return fail(ErrorCode::structure, file, "An AMC file contains no skeleton.",
              "Choose " + intake::skeleton_name_for(file) + " together with this file.");
}

Result<std::string> ImportService::companion(std::string_view file_name, std::string bytes) {
  const std::string name = plain_name(file_name);
  if (name.ends_with(".asf")) {
    Result<formats::Asf> skeleton = formats::read_asf(bytes, file_name);
    if (!skeleton) return fail(std::move(skeleton.error()));
    if (skeletons_.size() >= max_stages) skeletons_.clear();
    last_skeleton_ = name;
    skeletons_.insert_or_assign(name, std::move(*skeleton));
    return "{}";
  }
  make_room(bytes.size());
  companions_.insert_or_assign(name, std::move(bytes));
  return "{}";
}

Result<intake::Intake> ImportService::read(const std::string& file, const std::string& bytes, const ImportSettings& settings) const {
  const std::optional<intake::FileKind> kind = intake::file_kind(file);
  intake::IntakeOptions options;
  options.unit = settings.unit;
  options.frame_rate = settings.rate;
  if (!settings.up.empty() || !settings.forward.empty()) {
    const auto up = intake::file_axis_named(settings.up), forward = intake::file_axis_named(settings.forward);
    if (!up || !forward)
      return fail(ErrorCode::range, "up", "The axes must be x, -x, y, -y, z or -z, both up and forward.",
                  "Choose both axes from the lists.");
    options.axes = intake::Orientation{*up, *forward};
  }
  options.character = settings.character;
  options.take = settings.take;
  options.travel = settings.travel;
  if (!settings.mapping.empty()) {
    Result<body::AnatomyMapping> mapping = intake::read_mapping(settings.mapping, "mapping");
    if (!mapping) return fail(std::move(mapping.error()));
    options.mapping = std::move(*mapping);
  }
  const auto read_companion = [this](std::string_view path) -> Result<std::string> {
    const auto found = companions_.find(plain_name(path));
    if (found != companions_.end()) return found->second;
    return fail(ErrorCode::io, std::string(path), "This file is missing.", "Choose it together with the file that refers to it.");
  };
  options.robot.read_asset = read_companion;
  options.files = [read_companion](std::string_view uri) -> Result<std::vector<std::byte>> {
    Result<std::string> found = read_companion(uri);
    if (!found) return fail(std::move(found.error()));
    const auto* p = reinterpret_cast<const std::byte*>(found->data());
    return std::vector<std::byte>(p, p + found->size());
  };
  if (kind == intake::FileKind::opensim)
    for (const auto& [name, text] : companions_)
      if (name.ends_with(".osim")) {
        options.model = text;
        options.model_name = name;
      }
  const formats::Asf* skeleton = nullptr;
  if (kind == intake::FileKind::amc) {
    const Result<const formats::Asf*> found = skeleton_for(file);
    if (!found) return fail(found.error());
    skeleton = *found;
  }
  return intake::take_in(bytes, file, skeleton, options);
}

Result<std::string> ImportService::stage(std::string_view file_name, std::string bytes, const ImportSettings& settings) {
  const std::string file(file_name.substr(file_name.find_last_of("/\\") + 1));
  Result<intake::Intake> intake_result = read(file, bytes, settings);
  if (!intake_result) return fail(std::move(intake_result.error()));
  make_room(bytes.size());
  const std::uint64_t number = next_++;
  const std::string id = "i" + std::to_string(number);
  const Stage& made = stages_.insert_or_assign(id, Stage{number, file, std::move(bytes), std::move(*intake_result)}).first->second;
  return stage_json(id, made.file, made.intake, settings);
}

Result<std::string> ImportService::restage(std::string_view id, const ImportSettings& settings) {
  const Result<Stage*> found = find(id);
  if (!found) return fail(found.error());
  Stage& stage = **found;
  Result<intake::Intake> intake_result = read(stage.file, stage.bytes, settings);
  if (!intake_result) return fail(std::move(intake_result.error()));
  stage.intake = std::move(*intake_result);
  return stage_json(id, stage.file, stage.intake, settings);
}

Result<intake::Intake> ImportService::prepare(std::string_view id, std::string_view name, const std::vector<std::string>& tags) {
  const Result<Stage*> found = find(id);
  if (!found) return fail(found.error());
  intake::Intake intake_result = (*found)->intake;
  const std::string shown = intake_result.items.front().name;
  for (store::LibraryItem& item : intake_result.items) {
    if (!name.empty() && item.name == shown) item.name = std::string(name);
    item.tags.insert(item.tags.end(), tags.begin(), tags.end());
  }
  return intake_result;
}

Result<std::string> ImportService::store(const intake::Intake& intake_result, store::Library& library) {
  const Result<std::vector<std::string>> ids = intake::put(library, intake_result);
  if (!ids) return fail(ids.error());
  Json entries = Json::array();
  for (std::size_t i = 0; i < ids->size(); ++i) {
    const store::LibraryItem& item = intake_result.items[i];
    if (item.kind != store::EntryKind::measured)
      entries.push_back({{"id", (*ids)[i]}, {"kind", store::name_of(item.kind)}, {"name", item.name}});
  }
  return text_of({{"entries", std::move(entries)}});
}

Result<ImportService::Stage*> ImportService::find(std::string_view id) {
  const auto found = stages_.find(id);
  if (found != stages_.end()) return &found->second;
  return fail(ErrorCode::unknown, std::string(id), "This import has ended or was dropped to free memory.", "Import the file again.");
}

void ImportService::make_room(std::size_t bytes) {
  std::size_t total = bytes;
  for (const auto& [id, stage] : stages_) total += stage.bytes.size();
  for (const auto& [name, data] : companions_) total += data.size();
  if (total > max_bytes) companions_.clear();
  while (!stages_.empty() && (stages_.size() >= max_stages || total > max_bytes)) {
    const auto oldest = std::ranges::min_element(stages_, {}, [](const auto& s) { return s.second.number; });
    total -= std::min(total, oldest->second.bytes.size());
    stages_.erase(oldest);
  }
}

Result<std::string> reference_character_json(double height) {
  MeasuredMotion stand = samples::make_human_stand();
  body::BodyOptions options;
  options.height = height;
  intake::scale(stand, height / 1.75);  // `stand` is 1.75 m tall before scaling
  Result<body::Body> body = body::make_body(stand, options);
  if (!body) return fail(std::move(body.error()));
  const Motion motion = body::to_motion(*body, stand);
  return mechanism_json("reference", *body->mechanism, {motion.frame(0), static_cast<std::size_t>(motion.nq)});
}

}  // namespace ugoki::studio
