// Members of Session for operations on the motions of clips. Operations run on a background thread. The result of an operation is applied
// as one command, so that one undo reverts it.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/content/gait_recipe_json.h"
#include "ugoki/content/layered_motions.h"
#include "ugoki/content/track.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/gait_clip.h"
#include "ugoki/studio/motion_edits.h"
#include "ugoki/studio/motion_source.h"
#include "ugoki/studio/session_request.h"

namespace ugoki::studio {
namespace {

using json::Json;

std::string text_field(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

/// The first unused id of the form `letter` + number in the document.
std::string free_id(const content::Scenario& scenario, char letter) {
  std::set<std::string> used;
  for (const content::ScenarioCharacter& c : scenario.characters) {
    used.insert(c.id);
    for (const content::ScenarioClip& clip : c.track) used.insert(clip.id);
  }
  for (const content::ScenarioEvent& e : scenario.events) used.insert(e.id);
  for (const content::Rule& r : scenario.rules) used.insert(r.id);
  for (int n = 1;; ++n)
    if (std::string id = letter + std::to_string(n); !used.contains(id)) return id;
}

/// The closest start position to the right of `origin` at which no other character starts.
content::ScenarioPlace find_free_place(const content::Scenario& scenario, const content::ScenarioPlace& origin) {
  constexpr double spacing = 1.2;  // distance between neighbouring start positions, m
  const double heading = origin.heading * std::numbers::pi / 180;
  content::ScenarioPlace spot = origin;
  const auto occupied = [&](const content::ScenarioCharacter& c) {
    return std::hypot(c.place.x - spot.x, c.place.y - spot.y) < 0.9 * spacing;
  };
  for (int n = 1; n == 1 || std::ranges::any_of(scenario.characters, occupied); ++n) {
    spot.x = origin.x + n * spacing * std::sin(heading);
    spot.y = origin.y - n * spacing * std::cos(heading);
  }
  return spot;
}

std::span<const std::byte> bytes_of(const std::string& text) { return {reinterpret_cast<const std::byte*>(text.data()), text.size()}; }

Json timing_of(const content::ScenarioClip& clip) {
  return {{"start", clip.start}, {"length", clip.length}, {"offset", clip.offset},
          {"speed", clip.speed}, {"blend", clip.blend},   {"loop", clip.loop}};
}

}  // namespace

/// A running operation on a motion.
struct Session::MotionTask {
  std::string name;
  ClientId client = 0;
  std::string reply_to;
  std::string scenario;  ///< id of the inner scenario that was shown; empty: the document
  std::string character;
  std::string body_id;  ///< id of the mechanism to retarget to, if the project or the library has it
  MotionEdit edit;
  std::optional<GaitRequest> gait;  ///< request `gait`, instead of `edit`
  bool adds_clip = false;           ///< the result is played by a new clip
  Result<EditedMotion> made;
  std::atomic<bool> cancelled = false;
};

namespace {

/// The mechanism to retarget to, with its id; the id is empty for a built-in sample.
struct Body {
  MechanismPtr mechanism;
  std::string id;
};

/// The body that a request names: a mechanism of the project or the library by its id, or a sample by its name or height [m].
/// @param of_library what was read from the library; null: nothing was read
Result<Body> find_body(const Json& request, MechanismPtr of_project, const Result<ProjectEntry>* of_library) {
  const std::string id = text_field(request, "mechanism"), sample = text_field(request, "sample");
  if (of_project) return Body{std::move(of_project), id};
  if (sample == "dog") return Body{samples::make_dog(), ""};
  if (sample == "human" || (request.contains("height") && request["height"].is_number())) {
    constexpr double usual_height = 1.75;
    Result<MechanismPtr> person = samples::make_person(sample == "human" ? usual_height : request["height"].get<double>());
    if (!person) return fail(std::move(person.error()));
    return Body{std::move(*person), ""};
  }
  if (id.empty() || of_library == nullptr)
    return fail(ErrorCode::structure, "mechanism", "The body is missing.", "Give \"mechanism\", \"height\" or \"sample\".");
  if (!*of_library) return fail(of_library->error());
  return Body{(*of_library)->mechanism, (*of_library)->mechanism_id};
}

}  // namespace

Result<std::shared_ptr<Session::MotionTask>> Session::new_motion_task(const Request& request) const {
  constexpr std::size_t max_tasks = 16;
  auto task = std::make_shared<MotionTask>();
  task->name = text_field(request.json, "task");
  task->client = request.client;
  task->reply_to = request.reply_to;
  task->scenario = shown_.id();
  task->character = text_field(request.json, "character");
  if (task->name.empty() || task->name.size() > 40 || motion_tasks_.contains(task->name))
    return Request::invalid_field("task", "a new name of at most 40 characters");
  if (motion_tasks_.size() >= max_tasks)
    return fail(ErrorCode::conflict, "task", std::to_string(max_tasks) + " operations are already running.",
                "Wait until one has ended, or cancel one.");
  return task;
}

Result<void> Session::start_motion(const Request& request) {
  Result<std::shared_ptr<MotionTask>> fresh = new_motion_task(request);
  if (!fresh) return fail(std::move(fresh.error()));
  const std::shared_ptr<MotionTask> task = *fresh;
  MotionEdit& edit = task->edit;
  edit.operation = text_field(request.json, "operation");
  const Result<Needs> needs = needs_of(edit.operation);
  if (!needs) return fail(needs.error());
  if (request.json.contains("options")) edit.options = request.json["options"];

  const content::ScenarioCharacter* character = shown_.scenario().find_character(task->character);
  const std::string clip_id = text_field(request.json, "clip");
  if (character == nullptr) return Request::invalid_field("character", "a character's id");
  const auto clip = std::ranges::find_if(character->track, [&](const content::ScenarioClip& c) { return c.id == clip_id; });
  if (clip == character->track.end()) return Request::invalid_field("clip", "the id of a clip of that character");
  const content::Resources& resources = project_.resources();
  edit.mechanism = find_mechanism(character->mechanism);
  // The operation works on the motion with its layers, and the clip that plays the result has none.
  Error problems;
  const auto motion_of = [&](content::ScenarioClip c) {
    const auto found = resources.motions.find(c.motion);
    if (found == resources.motions.end() || !edit.mechanism) return ClipMotion{c, nullptr};
    Result<MotionPtr> motion = content::layered_motion(c, *edit.mechanism, found->second);
    c.layers.clear();
    if (motion) return ClipMotion{c, std::move(*motion)};
    problems = std::move(motion.error());
    return ClipMotion{c, nullptr};
  };
  edit.target = motion_of(*clip);
  if (!problems.empty()) return fail(std::move(problems));
  if (!edit.mechanism || !edit.target.motion)
    return fail(ErrorCode::unknown, "clip " + clip_id, "The project does not contain its motion or its mechanism.",
                "Remove the clip and add the motion again.");
  if (*needs == Needs::next_clip && clip + 1 != character->track.end()) edit.next = motion_of(*(clip + 1));
  if (*needs == Needs::other_motion) {
    const std::string id = text_field(request.json, "motion");
    if (id.empty()) return Request::invalid_field("motion", "the id of the second motion");
    Result<ProjectEntry> other = request.read_library ? request.motion : find_motion(id, project_entries(), nullptr);
    if (!other) return fail(std::move(other.error()));
    edit.other = std::move(other->motion);
    edit.other_mechanism = std::move(other->mechanism);
  }
  if (*needs == Needs::body) {
    Result<Body> body =
        find_body(request.json, find_mechanism(text_field(request.json, "mechanism")), request.read_library ? &request.body : nullptr);
    if (!body) return fail(std::move(body.error()));
    edit.body = std::move(body->mechanism);
    task->body_id = std::move(body->id);
  }

  edit.cancelled = &task->cancelled;
  post_motion_task(task);
  return {};
}

/// Makes a gait and lets a clip play it: a new clip, or the clip that the request names.
Result<void> Session::start_gait(const Request& request) {
  Result<std::shared_ptr<MotionTask>> fresh = new_motion_task(request);
  if (!fresh) return fail(std::move(fresh.error()));
  const std::shared_ptr<MotionTask> task = *fresh;
  task->edit.operation = "gait";
  const content::ScenarioCharacter* character = shown_.scenario().find_character(task->character);
  if (character == nullptr) return Request::invalid_field("character", "a character's id");
  GaitRequest& gait = task->gait.emplace();
  gait.mechanism = find_mechanism(character->mechanism);
  if (!gait.mechanism)
    return fail(ErrorCode::unknown, "character " + task->character, "The project does not contain its mechanism.",
                "Remove the character and add it again.");
  const std::string clip_id = text_field(request.json, "clip");
  task->adds_clip = clip_id.empty();
  if (task->adds_clip) {
    gait.clip.id = free_id(shown_.scenario(), 'k');
    if (request.json.contains("start")) {
      if (!request.json["start"].is_number()) return Request::invalid_field("start", "a time in seconds");
      gait.clip.start = request.json["start"].get<double>();
    }
  } else {
    const auto clip = std::ranges::find_if(character->track, [&](const content::ScenarioClip& c) { return c.id == clip_id; });
    if (clip == character->track.end()) return Request::invalid_field("clip", "the id of a clip of that character");
    gait.clip = *clip;
    const auto old = project_.resources().motions.find(clip->motion);
    if (old != project_.resources().motions.end()) gait.old = old->second;
  }
  if (!gait.clip.gait) gait.clip.gait.emplace();
  if (request.json.contains("gait")) {
    Error problems;
    content::read_gait_recipe(request.json["gait"], "gait", *gait.clip.gait, problems);
    if (!problems.empty()) return fail(std::move(problems));
  }
  const Vec3 gravity = shown_.scenario().gravity;
  gait.gravity = std::sqrt(gravity.x * gravity.x + gravity.y * gravity.y + gravity.z * gravity.z);
  gait.cancelled = &task->cancelled;
  post_motion_task(task);
  return {};
}

Result<std::string> Session::list_gaits(const Request& request) const {
  const content::ScenarioCharacter* character = shown_.scenario().find_character(text_field(request.json, "character"));
  const MechanismPtr mechanism = character ? find_mechanism(character->mechanism) : nullptr;
  if (!mechanism) return Request::invalid_field("character", "a character's id");
  Result<Json> gaits = describe_gaits(mechanism);
  if (!gaits) return fail(gaits.error());
  const std::string clip_id = text_field(request.json, "clip");
  const auto clip = std::ranges::find_if(character->track, [&](const content::ScenarioClip& c) { return c.id == clip_id; });
  const auto& motions = project_.resources().motions;
  const bool complete = std::ranges::all_of(character->track, [&](const content::ScenarioClip& c) { return motions.contains(c.motion); });
  if (clip != character->track.end() && complete) {
    const std::vector<Clip> track = content::lay_track(*character, *mechanism, project_.resources());
    const Clip& laid = track[static_cast<std::size_t>(clip - character->track.begin())];
    const Placement at = floor_placement(laid, *motions.at(clip->motion), *mechanism, clip->start);
    (*gaits)["start"] = {{"x", at.x}, {"y", at.y}, {"heading", at.heading * 180 / std::numbers::pi}};
  }
  return ",\"gaits\":" + json::to_text(*gaits);
}

void Session::post_motion_task(const std::shared_ptr<MotionTask>& task) {
  motion_tasks_[task->name] = task;
  motion_queue_.post([this, task] {
    if (task->cancelled) return;
    try {
      task->made = task->gait ? make_gait_clip(*task->gait) : edit_motion(task->edit);
    } catch (const std::exception& e) {  // out of memory
      task->made = fail(ErrorCode::io, task->edit.operation, std::string("The operation failed: ") + e.what() + ".",
                        "Use a shorter section of the motion.");
    }
    post_([this, task] { finish_motion(*task); });
  });
}

Result<std::string> Session::cancel_motion(const Request& request) {
  const auto found = motion_tasks_.find(text_field(request.json, "task"));
  if (found == motion_tasks_.end()) return std::string();  // the operation has already ended
  const std::shared_ptr<MotionTask> task = found->second;
  motion_tasks_.erase(found);
  task->cancelled = true;  // the operation ends soon, and its result is discarded
  reply(task->client, task->reply_to, std::string(",\"cancelled\":true"));
  return std::string();
}

void Session::cancel_motions() {
  for (const auto& [name, task] : std::exchange(motion_tasks_, {})) {
    task->cancelled = true;
    reply(task->client, task->reply_to,
          fail(ErrorCode::conflict, task->edit.operation, "The project was closed while the operation was running.",
               "Repeat this in the project that is open now."));
  }
}

void Session::finish_motion(MotionTask& task) {
  if (task.cancelled) return;
  motion_tasks_.erase(task.name);
  reply(task.client, task.reply_to, task.made ? insert_motion(task) : Result<std::string>(fail(task.made.error())));
}

/// Adds the resulting motion to the project and to the clip (or, for a retargeting, to a new character), as one command.
Result<std::string> Session::insert_motion(const MotionTask& task) {
  const EditedMotion& made = *task.made;
  const std::vector<std::byte> data = formats::write_motion(made.motion);
  const std::string id = made_motion_prefix + store::entry_id(store::EntryKind::motion, data).substr(2);
  const content::Scenario scenario = shown_.find(task.scenario);
  const content::ScenarioCharacter* character = scenario.find_character(task.character);
  if (character == nullptr)
    return fail(ErrorCode::conflict, "character " + task.character, "The character was removed while the operation was running.",
                "Undo the removal, then try again.");
  Json commands = Json::array();
  std::string on = task.character, clip = made.clip.id;
  if (task.edit.body) {
    std::string mechanism = task.body_id;
    if (mechanism.empty()) {
      const std::string text = formats::write_mechanism(*task.edit.body);
      mechanism = store::entry_id(store::EntryKind::mechanism, bytes_of(text));
      for (const auto& [known, body] :
           project_.resources().mechanisms)  // reuse an identical mechanism that the project has under another id
        if (!content::is_prop_mechanism(known) && formats::write_mechanism(*body) == text) mechanism = known;
      if (Result<void> put = project_.add_resource(mechanism, "mechanism", bytes_of(text)); !put) return fail(std::move(put.error()));
    }
    on = free_id(scenario, 'c');
    clip = free_id(scenario, 'k');
    const content::ScenarioPlace spot = find_free_place(scenario, character->place);
    const Json place = {{"x", spot.x}, {"y", spot.y}, {"heading", spot.heading}};
    commands.push_back({{"type", "character.add"}, {"id", on}, {"mechanism", mechanism}, {"place", place}});
    Json add = timing_of(made.clip);
    add.update({{"type", "clip.add"}, {"character", on}, {"id", clip}, {"motion", id}});
    commands.push_back(std::move(add));
  } else if (task.gait) {
    Json gait = timing_of(made.clip);
    gait.update({{"type", task.adds_clip ? "clip.add" : "clip.set"},
                 {"character", on},
                 {"id", clip},
                 {"motion", id},
                 {"gait", content::to_json(*made.clip.gait)}});
    commands.push_back(std::move(gait));
    const double end = made.clip.start + made.clip.length;
    if (end > scenario.duration) commands.push_back({{"type", "scenario.set"}, {"duration", std::ceil(end * 10) / 10}});
  } else {
    Json set = timing_of(made.clip);
    set.update({{"type", "clip.set"}, {"character", on}, {"id", clip}, {"motion", id}, {"layers", Json::array()}});
    commands.push_back(std::move(set));
    if (task.edit.operation == "join") commands.push_back({{"type", "clip.remove"}, {"character", on}, {"id", task.edit.next.clip.id}});
  }
  if (Result<void> put = project_.add_resource(id, "motion", data); !put) return fail(std::move(put.error()));
  Result<std::string> fields =
      apply(command_in(task.scenario, json::to_text({{"type", "group"}, {"label", made.label}, {"commands", std::move(commands)}})));
  if (!fields) return fields;
  const Json report = made.report;
  return *fields + ",\"character\":" + json::to_text(on) + ",\"clip\":" + json::to_text(clip) + ",\"motion\":" + json::to_text(id) +
         ",\"report\":" + json::to_text(report);
}

}  // namespace ugoki::studio
