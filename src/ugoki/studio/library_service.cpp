#include "ugoki/studio/library_service.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/content/prop.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/intake/intake.h"
#include "ugoki/json/fields.h"
#include "ugoki/studio/display_json.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/security.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return text;
}

/// True if `text` contains every word of `words`, ignoring case.
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

/// Summary of a motion for lists: "4.37 s · 120 Hz · cyclic".
std::string motion_words(double duration, double rate, bool cyclic) {
  return to_fixed(duration, 2) + " s · " + to_fixed(rate, rate == std::round(rate) ? 0 : 2) + " Hz" + (cyclic ? " · cyclic" : "");
}
/// Summary of a mechanism for lists: "62 degrees of freedom · 70 kg".
std::string mechanism_words(int dofs, double mass) {
  return std::to_string(dofs) + (dofs == 1 ? " degree of freedom · " : " degrees of freedom · ") + to_fixed(mass, mass < 10 ? 1 : 0) +
         " kg";
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
              {"dofs", m.nv()},
              {"mass", m.mass()},
              {"height", shown_height(m)},
              {"summary", mechanism_words(m.nv(), m.mass())}});
    if (content::is_mesh_body(m)) j["mesh"] = Json::object();
  }
  return j;
}

}  // namespace

Result<store::Library*> LibraryService::library() {
  wanted_ = true;
  if (!library_) {
    Result<store::Library> opened = store::Library::open(location_);
    away_ = !opened;
    if (!opened) return fail(std::move(opened.error()));
    warning_ = opened->warning();
    library_.emplace(std::move(*opened));
  }
  return &*library_;
}

LibraryService::Poll LibraryService::poll() {
  if (!wanted_) return {};
  const bool was_away = away_;
  const Result<store::Library*> open = library();
  if (!open) return {.responds = false};
  const Result<bool> changed = (*open)->changed_elsewhere();
  away_ = !changed;
  if (!changed) return {.responds = false};
  return {.responds = true, .changed = *changed || was_away};
}

bool LibraryService::answers(std::string_view path) {
  return path == "/api/library" || path == "/api/library/tags" || path.starts_with("/api/entry/") || path.starts_with("/api/thumbnail/");
}

ApiReply LibraryService::answer(const ApiRequest& request, const std::vector<ProjectEntry>& project, bool& changed) {
  const auto reply = [](const Result<std::string>& result) {
    return result ? ApiReply{200, *result} : ApiReply{http_status_of(result.error()), error_body(result.error())};
  };
  const std::string_view path = request.path;
  const bool get = request.method == "GET", post = request.method == "POST";
  if (path == "/api/library" && get) return reply(list(request.query, project));
  if (path == "/api/library/tags" && get) return reply(tags(request.query));
  constexpr std::string_view thumbnails = "/api/thumbnail/", entries = "/api/entry/";
  if (path.starts_with(thumbnails)) return thumbnail(request, path.substr(thumbnails.size()));
  if (path.starts_with(entries)) {
    const std::string_view rest = path.substr(entries.size()), id = rest.substr(0, rest.find('/'));
    const std::string_view action = id.size() < rest.size() ? rest.substr(id.size() + 1) : "";
    if (get && action.empty()) return reply(entry(id, project));
    const bool known = action.empty() || action == "restore" || action == "duplicate" || action == "remove" || action == "undelete";
    if (post && known) {
      const Result<store::LibraryEntry> now = change(id, action, request.body);
      changed = now.has_value();
      if (now) return {200, "{\"entry\":" + entry_json(*now, false) + "}"};
      ApiReply refused = reply(fail(now.error()));
      if (now.error().problems.front().code != ErrorCode::conflict || !library_) return refused;
      if (const Result<store::LibraryEntry> theirs = library_->get(id); theirs) {
        refused.body.pop_back();
        refused.body += ",\"entry\":" + entry_json(*theirs, false) + "}";
      }
      return refused;
    }
  }
  return reply(fail(ErrorCode::unknown, std::string(path), "The studio has no address " + request.method + " " + request.path + ".",
                    "See docs/studio-protocol.md."));
}

Result<std::string> LibraryService::list(std::string_view query, const std::vector<ProjectEntry>& project) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  store::LibraryQuery wanted;
  wanted.text = query_value(query, "q").value_or("");
  wanted.kinds = query_values(query, "kind");
  std::erase(wanted.kinds, "");
  for (const std::string& kind : wanted.kinds)
    if (!store::entry_kind_named(kind))
      return fail(ErrorCode::range, "kind", "There is no kind of entry '" + kind + "'.", "Omit \"kind\" to list mechanisms and motions.");
  if (wanted.kinds.empty()) wanted.kinds = {"mechanism", "motion"};
  wanted.tags = query_values(query, "tag");
  std::erase(wanted.tags, "");
  wanted.after = query_value(query, "after").value_or("");
  const std::string removed = query_value(query, "removed").value_or("");
  if (!removed.empty() && removed != "0" && removed != "1")
    return fail(ErrorCode::range, "removed", "\"removed\" must be 0 or 1.", "See docs/studio-protocol.md.");
  wanted.removed = removed == "1";
  constexpr double usual = 100, maximum = 500;
  const Result<std::optional<double>> limit = query_number(query, "limit", 1, maximum);
  if (!limit) return fail(limit.error());
  if (const double n = limit->value_or(usual); n != std::floor(n))
    return fail(ErrorCode::range, "limit", "\"limit\" must be a whole number.", "See docs/studio-protocol.md.");
  wanted.limit = static_cast<std::size_t>(limit->value_or(usual));
  const std::string order = query_value(query, "order").value_or("");
  const Result<store::LibraryOrder> known = store::library_order_named(!order.empty() ? order : wanted.text.empty() ? "name" : "relevance");
  if (!known) return fail(known.error());
  wanted.order = *known;
  Result<store::LibraryPage> found = (*open)->find(wanted);
  if (!found) return fail(std::move(found.error()));

  // The curve of a motion that was not listed before requires reading the motion's data. An answer makes only a limited number of new
  // curves, so that a list is not delayed.
  constexpr int new_curves = 40;  // maximum in one answer; answers to later requests add the others
  int budget = new_curves;
  std::set<std::string, std::less<>> ids;
  std::string entries;
  for (const store::LibraryEntry& entry : found->entries) {
    ids.insert(entry.id);
    ids.insert(entry.content);
    const bool drawn = curves_.contains(entry.content);
    const bool draw = entry.kind == store::EntryKind::motion && (drawn || budget > 0);
    if (draw && !drawn) --budget;
    entries += (entries.empty() ? "" : ",") + entry_json(entry, draw);
  }
  const bool with_project = wanted.after.empty() && wanted.tags.empty() && !wanted.removed;
  for (const ProjectEntry& entry : project) {
    if (!with_project || !entry.used || ids.contains(entry.id) || (*open)->get(entry.id)) continue;
    const Json j = project_entry_json(entry);
    if (std::ranges::find(wanted.kinds, j["kind"].get<std::string>()) == wanted.kinds.end()) continue;
    if (!has_words(j["name"].get<std::string>() + " project " + j["summary"].get<std::string>(), wanted.text)) continue;
    entries += (entries.empty() ? "" : ",") + text_of(j);
    ++found->total;
  }
  Json rest = {{"next", nullptr}, {"total", found->total}, {"total_exact", found->total_exact}};
  if (!found->next.empty()) rest["next"] = found->next;
  return "{\"entries\":[" + entries + "]," + text_of(rest).substr(1);
}

Result<std::string> LibraryService::tags(std::string_view query) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  std::vector<std::string> kinds = query_values(query, "kind");
  std::erase(kinds, "");
  if (kinds.empty()) kinds = {"mechanism", "motion"};
  const auto found = (*open)->tags(kinds);
  if (!found) return fail(found.error());
  Json rows = Json::array();
  for (const auto& [name, count] : *found) rows.push_back({{"name", name}, {"count", count}});
  return text_of({{"tags", std::move(rows)}});
}

Result<std::string> LibraryService::entry(std::string_view id, const std::vector<ProjectEntry>& project) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  Result<store::LibraryEntry> found = (*open)->get(id);
  if (!found) {
    const Result<store::LibraryEntry> removed = (*open)->get_removed(id);
    const auto own = std::ranges::find_if(project, [&](const ProjectEntry& e) { return e.id == id; });
    if (!removed && own != project.end()) {
      Json j = project_entry_json(*own);
      j["versions"] = Json::array();
      return text_of(j);
    }
    if (!removed) return fail(std::move(found.error()));
    found = *removed;
  }
  const Result<std::vector<store::LibraryVersion>> versions = (*open)->history(found->id);
  if (!versions) return fail(versions.error());
  Json rows = Json::array();
  for (const store::LibraryVersion& v : *versions)
    rows.push_back({{"version", v.version},
                    {"content", v.content},
                    {"name", v.name},
                    {"note", v.note},
                    {"by", v.author},
                    {"when", v.saved},
                    {"size", v.size}});
  std::string json = entry_json(*found, true);
  json.pop_back();
  return json + ",\"versions\":" + text_of(rows) + "}";
}

Result<store::LibraryEntry> LibraryService::change(std::string_view id, std::string_view action, std::string_view body) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  store::Library& l = **open;
  if (action.empty()) return edit(id, body);
  if (action == "remove") {
    if (Result<void> done = l.remove(id); !done) return fail(std::move(done.error()));
    return l.get_removed(id);
  }
  if (action == "undelete") {
    if (Result<void> done = l.undelete(id); !done) return fail(std::move(done.error()));
    return l.get(id);
  }
  const Result<json::Json> parsed = json::parse_json(body, "body");
  if (!parsed) return fail(parsed.error());
  Error problems;
  json::Fields fields(*parsed, "body:", problems);
  int base = 0, version = 0;
  std::string name;
  if (action == "restore") {
    fields.integer("base", base);
    fields.integer("version", version);
    fields.require("base", "the version of the entry that the page shows");
    fields.require("version", "the version to restore");
  } else {
    fields.text("name", name);
    fields.require("name", "the name of the new entry");
  }
  if (!problems.empty()) return fail(std::move(problems));
  return action == "restore" ? l.restore(id, base, version) : l.duplicate(id, name);
}

Result<store::LibraryEntry> LibraryService::edit(std::string_view id, std::string_view body) {
  const Result<json::Json> parsed = json::parse_json(body, "body");
  if (!parsed) return fail(parsed.error());
  Error problems;
  json::Fields fields(*parsed, "body:", problems);
  store::LibrarySave save{.id = std::string(id)};
  fields.integer("base", save.base);
  fields.require("base", "the version that the edit is based on");
  for (auto& [key, value] : {std::pair{"name", &save.name}, {"note", &save.note}})
    if (fields.has(key)) fields.text(key, value->emplace());
  std::vector<std::string> add, remove;
  for (auto& [key, tags] : {std::pair{"add_tags", &add}, {"remove_tags", &remove}})
    if (const json::Json* list = fields.list(key, 1000, "tags"))
      for (const json::Json& tag : *list) {
        if (!tag.is_string()) return fail(ErrorCode::syntax, std::string("body: ") + key, "A tag must be a text.", "Give a list of texts.");
        tags->push_back(tag.get<std::string>());
      }
  fields.refuse_others();
  if (!problems.empty()) return fail(std::move(problems));
  Result<store::LibraryEntry> saved = library_->save(save);
  if (!saved || (add.empty() && remove.empty())) return saved;
  if (Result<void> done = library_->set_tags(id, add, remove); !done) return fail(std::move(done.error()));
  return library_->get(id);
}

ApiReply LibraryService::thumbnail(const ApiRequest& request, std::string_view id) {
  const auto refused = [](const Error& error) { return ApiReply{http_status_of(error), error_body(error)}; };
  Result<store::Library*> open = library();
  if (!open) return refused(open.error());
  if (request.method == "POST") {
    const Result<void> set = (*open)->set_thumbnail(id, std::as_bytes(std::span(request.body)));
    return set ? ApiReply{200, "{}"} : refused(set.error());
  }
  const Result<std::vector<std::byte>> picture = (*open)->thumbnail(id);
  if (!picture) return refused(picture.error());
  if (picture->empty()) return refused({ErrorCode::unknown, std::string(id), "The entry has no thumbnail.", "Send one with POST."});
  std::string bytes(reinterpret_cast<const char*>(picture->data()), picture->size());
  const char* type = bytes.starts_with("RIFF") ? "image/webp" : "image/png";
  return {200, std::move(bytes), type};
}

std::string LibraryService::entry_json(const store::LibraryEntry& entry, bool with_curve) {
  Json j = Json::parse(entry.summary, nullptr, false);
  if (!j.is_object()) j = Json::object();
  json::rename_field(j, "freedoms", "dofs");  // summaries of earlier versions have the old field
  const auto number = [&](const char* key) { return j.contains(key) && j[key].is_number() ? j[key].get<double>() : 0.0; };
  const bool cyclic = j.contains("cyclic") && j["cyclic"].is_boolean() && j["cyclic"].get<bool>();
  std::string summary;
  if (entry.kind == store::EntryKind::motion || entry.kind == store::EntryKind::measured)
    summary = motion_words(number("duration"), number("rate"), cyclic);
  else if (entry.kind == store::EntryKind::mechanism)
    summary = mechanism_words(static_cast<int>(number("dofs")), number("mass"));
  j.update({{"summary", summary},
            {"id", entry.id},
            {"kind", store::name_of(entry.kind)},
            {"name", entry.name},
            {"note", entry.note},
            {"tags", entry.tags},
            {"version", entry.version},
            {"content", entry.content},
            {"created", entry.created},
            {"changed", entry.changed},
            {"by", entry.author},
            {"size", entry.size},
            {"thumbnail", entry.thumbnail},
            {"removed", entry.removed}});
  if (with_curve && entry.kind == store::EntryKind::motion) {
    auto known = curves_.find(entry.content);
    if (known == curves_.end()) {
      std::string curve = "[]";
      const Result<std::vector<std::byte>> data = library_->content(entry.content);
      const Result<Motion> motion = data ? formats::read_motion(*data, entry.name) : fail(Error());
      const std::string mechanism_id = j.contains("mechanism") && j["mechanism"].is_string() ? j["mechanism"].get<std::string>() : "";
      const Result<MechanismPtr> body = mechanism(mechanism_id);
      if (motion && body && check_motion(*motion, **body).empty()) curve = text_of(thumbnail_curve(*motion, **body));
      constexpr std::size_t max_curves = 20'000;
      if (curves_.size() >= max_curves) curves_.clear();
      known = curves_.emplace(entry.content, std::move(curve)).first;
    }
    j["curve"] = Json::parse(known->second);
  }
  return text_of(j);
}

Result<MechanismPtr> LibraryService::mechanism(std::string_view id) {
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  Result<std::vector<std::byte>> data = (*open)->content(id);
  if (!data) return fail(std::move(data.error()));
  return formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, id);
}

Result<std::string> LibraryService::import(std::string_view file_name, std::string_view bytes) {
  const std::optional<intake::FileKind> kind = intake::file_kind(file_name);
  if (!kind) return fail(intake::take_in({}, file_name.empty() ? "name" : file_name).error());
  if (*kind == intake::FileKind::asf) return import_skeleton(file_name, bytes);

  const formats::Asf* skeleton = nullptr;
  if (*kind == intake::FileKind::amc) {
    const auto named = skeletons_.find(lower(intake::skeleton_name_for(file_name)));
    const auto sent = named != skeletons_.end() ? named : skeletons_.find(last_skeleton_);
    if (sent == skeletons_.end()) {
      return fail(ErrorCode::structure, std::string(file_name), "An AMC file contains no skeleton.",
                  "Import " + intake::skeleton_name_for(file_name) + " first, or both files together.");
    }
    skeleton = &sent->second;
  }
  Result<store::Library*> open = library();
  if (!open) return fail(std::move(open.error()));
  const Result<intake::Intake> intake_result = intake::take_in(bytes, file_name, skeleton);
  if (!intake_result) return fail(intake_result.error());
  const Result<std::vector<std::string>> ids = intake::put(**open, *intake_result);
  if (!ids) return fail(ids.error());
  std::string entries;
  for (const std::string& id : *ids) {
    const Result<store::LibraryEntry> entry = (*open)->get(id);
    if (!entry) return fail(entry.error());
    if (entry->kind == store::EntryKind::measured) continue;
    entries += (entries.empty() ? "" : ",") + entry_json(*entry, entry->kind == store::EntryKind::motion);
  }
  return "{\"entries\":[" + entries + "],\"report\":" + text_of(intake_result->report) + "}";
}

Result<std::string> LibraryService::import_skeleton(std::string_view file_name, std::string_view bytes) {
  Result<formats::Asf> skeleton = formats::read_asf(bytes, file_name);
  if (!skeleton) return fail(std::move(skeleton.error()));
  constexpr std::size_t maximum = 64;
  if (skeletons_.size() >= maximum) skeletons_.clear();
  last_skeleton_ = lower(std::string(file_name));
  skeletons_.insert_or_assign(last_skeleton_, std::move(*skeleton));
  return "{\"entries\":[],\"report\":" + text_of(Json::array({"The skeleton was read. Import its AMC files now."})) + "}";
}

}  // namespace ugoki::studio
