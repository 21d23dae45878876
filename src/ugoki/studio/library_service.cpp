#include "ugoki/studio/library_service.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/intake/intake.h"
#include "ugoki/studio/display_json.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return text;
}

/// True if every word of `words` stands in `text`, in any case.
bool has_words(const std::string& text, std::string_view words) {
  const std::string in = lower(text), all = lower(std::string(words));
  std::size_t at = 0;
  while (at < all.size()) {
    const std::size_t end = std::min(all.find(' ', at), all.size());
    if (in.find(all.substr(at, end - at)) == std::string::npos) return false;
    at = end + 1;
  }
  return true;
}

/// "4.37 s · 120 Hz · cyclic"
std::string motion_words(double duration, double rate, bool cyclic) {
  return to_fixed(duration, 2) + " s · " + to_fixed(rate, rate == std::round(rate) ? 0 : 2) + " Hz" + (cyclic ? " · cyclic" : "");
}
/// "62 freedoms · 70 kg"
std::string mechanism_words(int freedoms, double mass) {
  return std::to_string(freedoms) + (freedoms == 1 ? " freedom · " : " freedoms · ") + to_fixed(mass, mass < 10 ? 1 : 0) + " kg";
}

Json project_entry_json(const ProjectEntry& entry) {
  Json j = {{"id", entry.id}, {"tags", {"project"}}, {"created", ""}};
  if (entry.motion) {
    const Motion& m = *entry.motion;
    j.update({{"kind", "motion"},
              {"name", m.name},
              {"mechanism", entry.mechanism_id},
              {"duration", m.duration()},
              {"rate", m.rate},
              {"frames", m.frames},
              {"cyclic", m.cyclic},
              {"summary", motion_words(m.duration(), m.rate, m.cyclic)}});
    if (entry.mechanism) j["curve"] = thumbnail_curve(m, *entry.mechanism);
  } else {
    const Mechanism& m = *entry.mechanism;
    j.update({{"kind", "mechanism"},
              {"name", m.name()},
              {"freedoms", m.nv()},
              {"mass", m.mass()},
              {"height", shown_height(m)},
              {"summary", mechanism_words(m.nv(), m.mass())}});
  }
  return j;
}

}  // namespace

Result<store::Library*> LibraryService::library() {
  if (!library_) {
    Result<store::Library> opened = store::Library::open(path_);
    if (!opened) return fail(std::move(opened.error()));
    library_.emplace(std::move(*opened));
  }
  return &*library_;
}

Result<std::string> LibraryService::list(std::string_view kind, std::string_view words, const std::vector<ProjectEntry>& project) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  if (!kind.empty() && kind != "mechanism" && kind != "motion") {
    return fail(ErrorCode::range, "kind", "The kind must be \"mechanism\" or \"motion\".", "Leave it out for both.");
  }
  store::LibraryQuery query;
  query.text = std::string(words);
  query.kinds = kind.empty() ? std::vector<std::string>{"mechanism", "motion"} : std::vector<std::string>{std::string(kind)};
  Result<std::vector<store::LibraryEntry>> found = (*open)->find(query);
  if (!found) return fail(std::move(found.error()));

  // Drawings of motions that were never listed cost a read of their data: some in each answer, so that none is late.
  constexpr int new_curves = 40;
  int budget = new_curves;
  std::set<std::string, std::less<>> ids;
  std::string entries;
  for (const store::LibraryEntry& entry : *found) {
    ids.insert(entry.id);
    const bool drawn = curves_.contains(entry.id);
    const bool draw = entry.kind == store::EntryKind::motion && (drawn || budget > 0);
    if (draw && !drawn) --budget;
    entries += (entries.empty() ? "" : ",") + entry_json(entry, draw);
  }
  for (const ProjectEntry& entry : project) {
    if (ids.contains(entry.id)) continue;
    const Json j = project_entry_json(entry);
    if (!kind.empty() && j["kind"] != kind) continue;
    if (!has_words(j["name"].get<std::string>() + " project " + j["summary"].get<std::string>(), words)) continue;
    entries += (entries.empty() ? "" : ",") + text_of(j);
  }
  return "{\"entries\":[" + entries + "]}";
}

std::string LibraryService::entry_json(const store::LibraryEntry& entry, bool with_curve) {
  Json j = Json::parse(entry.summary, nullptr, false);
  if (!j.is_object()) j = Json::object();
  const auto number = [&](const char* key) { return j.contains(key) && j[key].is_number() ? j[key].get<double>() : 0.0; };
  const bool cyclic = j.contains("cyclic") && j["cyclic"].is_boolean() && j["cyclic"].get<bool>();
  j["summary"] = entry.kind == store::EntryKind::motion ? motion_words(number("duration"), number("rate"), cyclic)
                                                        : mechanism_words(static_cast<int>(number("freedoms")), number("mass"));
  j["id"] = entry.id;
  j["kind"] = store::name_of(entry.kind);
  j["name"] = entry.name;
  j["tags"] = entry.tags;
  j["created"] = entry.created;
  if (with_curve) {
    auto known = curves_.find(entry.id);
    if (known == curves_.end()) {
      std::string curve = "[]";
      const Result<std::vector<std::byte>> data = library_->data(entry.id);
      const Result<Motion> motion = data ? formats::read_motion(*data, entry.name) : fail(Error());
      const std::string mechanism_id = j.contains("mechanism") && j["mechanism"].is_string() ? j["mechanism"].get<std::string>() : "";
      const Result<MechanismPtr> body = mechanism(mechanism_id);
      if (motion && body) curve = text_of(thumbnail_curve(*motion, **body));
      known = curves_.emplace(entry.id, std::move(curve)).first;
    }
    j["curve"] = Json::parse(known->second);
  }
  return text_of(j);
}

Result<MechanismPtr> LibraryService::mechanism(std::string_view id) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  Result<std::vector<std::byte>> data = (*open)->data(id);
  if (!data) return fail(std::move(data.error()));
  return formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, id);
}

Result<std::string> LibraryService::import(std::string_view file_name, std::string_view bytes) {
  const std::optional<intake::FileKind> kind = intake::file_kind(file_name);
  if (!kind) {
    return fail(ErrorCode::unsupported, file_name.empty() ? "name" : std::string(file_name), "Files of this kind cannot be imported.",
                "Import BVH, AMC (with its ASF), C3D, TRC, GLB, a mechanism's JSON, URDF, SDF or MJCF; the name must have that ending.");
  }
  if (*kind == intake::FileKind::asf) return import_skeleton(file_name, bytes);

  const formats::Asf* skeleton = nullptr;
  if (*kind == intake::FileKind::amc) {
    const auto named = skeletons_.find(lower(intake::skeleton_name_for(file_name)));
    const auto sent = named != skeletons_.end() ? named : skeletons_.find(last_skeleton_);
    if (sent == skeletons_.end()) {
      return fail(ErrorCode::structure, std::string(file_name), "An AMC file has no skeleton of its own.",
                  "Import " + intake::skeleton_name_for(file_name) + " first, or both files together.");
    }
    skeleton = &sent->second;
  }
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  const Result<intake::Intake> taken = intake::take_in(bytes, file_name, skeleton);
  if (!taken) return fail(taken.error());
  const Result<std::vector<std::string>> ids = intake::put(**open, *taken);
  if (!ids) return fail(ids.error());
  std::string entries;
  for (const std::string& id : *ids) {
    const Result<store::LibraryEntry> entry = (*open)->get(id);
    if (!entry) return fail(entry.error());
    if (entry->kind == store::EntryKind::measured) continue;
    entries += (entries.empty() ? "" : ",") + entry_json(*entry, entry->kind == store::EntryKind::motion);
  }
  return "{\"entries\":[" + entries + "],\"report\":" + text_of(taken->report) + "}";
}

Result<std::string> LibraryService::import_skeleton(std::string_view file_name, std::string_view bytes) {
  Result<formats::Asf> skeleton = formats::read_asf(bytes, file_name);
  if (!skeleton) return fail(std::move(skeleton.error()));
  constexpr std::size_t most = 64;
  if (skeletons_.size() >= most) skeletons_.clear();
  last_skeleton_ = lower(std::string(file_name));
  skeletons_.insert_or_assign(last_skeleton_, std::move(*skeleton));
  return "{\"entries\":[],\"report\":" + text_of(Json::array({"The skeleton is ready; import its AMC files now."})) + "}";
}

}  // namespace ugoki::studio
