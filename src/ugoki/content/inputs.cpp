#include "ugoki/content/inputs.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "ugoki/content/generate.h"
#include "ugoki/content/json_fields.h"

namespace ugoki::content {
namespace {

using lsi::EventKind;
using lsi::EventRecord;

constexpr double max_step = 1e12;  // steps; an upper bound for any run (at 500 steps/s this number takes 63 years)

/// Reads one list of recorded inputs.
class Reader {
 public:
  Reader(const Executable& content, std::string_view name) : content_(content), name_(name) {}

  Result<std::vector<PlayerInput>> read(std::string_view text) {
    const Result<Json> json = parse_json(text, name_);
    if (!json) return fail(json.error());
    Fields f(*json, name_ + ":", problems_);
    f.require("inputs", "the list of recorded inputs");
    if (const Json* list = f.list("inputs", max_recorded_inputs, "inputs"))
      for (std::size_t i = 0; i < list->size(); ++i) read_one((*list)[i], f.path("inputs") + "/" + std::to_string(i));
    if (!problems_.empty()) return fail(std::move(problems_));
    return std::move(out_);
  }

 private:
  void read_one(const Json& json, std::string path) {
    Fields f(json, path, problems_);
    if (!f.is_object()) return;
    double step = -1;
    std::string type;
    f.require("step", "the number of the step from which the input acts, 0 for the first");
    f.require("type", "push, grab, drag, release, throw or input");
    f.number("step", step);
    f.text("type", type);
    if (f.has("step") && !(step >= 0 && step <= max_step && step == std::floor(step)))
      f.report(ErrorCode::range, f.path("step"), "The step is not a whole number from 0 to 1e12.", "Give the number of a step.");
    if (!out_.empty() && step >= 0 && static_cast<double>(out_.back().step) > step)
      f.report(ErrorCode::structure, f.path("step"), "The step is before the step of the previous input.", "Sort the inputs by step.");
    PlayerInput input;
    if (step >= 0 && step <= max_step) input.step = static_cast<std::uint64_t>(step);
    EventRecord& e = input.record;
    if (type == "push") {
      e.kind = EventKind::push;
      read_link(f, e);
      vector(f, "force", e.a, "the force in N, world axes");
      f.require("duration", "the duration of the push in s");
      f.number("duration", e.duration);
      if (f.has("duration") && !(e.duration > 0))
        f.report(ErrorCode::range, f.path("duration"), "The duration of a push must be above 0 s.", "Give the duration of the push in s.");
    } else if (type == "grab") {
      e.kind = EventKind::grab;
      read_link(f, e);
      vector(f, "point", e.a, "the grabbed point in m, in the frame of the link");
      vector(f, "target", e.b, "the target in m, world");
    } else if (type == "drag") {
      e.kind = EventKind::drag;
      vector(f, "target", e.b, "the target in m, world");
    } else if (type == "release") {
      e.kind = EventKind::release;
    } else if (type == "throw") {
      e.kind = EventKind::throwing;
      read_character(f, e);
      vector(f, "from", e.a, "the position of the root in m, world");
      vector(f, "velocity", e.b, "the velocity in m/s, world");
      vector(f, "spin", e.c, "the angular velocity in rad/s, world");
    } else if (type == "input") {
      const auto change = circuit::read_device_change(to_text(json), path);
      if (!change) {
        problems_.problems.insert(problems_.problems.end(), change.error().problems.begin(), change.error().problems.end());
        return;
      }
      circuit::apply(*change, held_);
      f.number("wheel", held_.mouse.wheel);
      input.held = std::make_shared<const circuit::DeviceState>(held_);
    } else if (f.has("type")) {
      f.report(ErrorCode::unknown, f.path("type"), "'" + type + "' is not a type of input.",
               "Use push, grab, drag, release, throw or input.");
    }
    out_.push_back(std::move(input));
  }

  void vector(Fields& f, const char* key, Vec3& value, const char* meaning) {
    f.require(key, meaning);
    f.vec3(key, value);
  }

  void read_character(Fields& f, EventRecord& e) {
    f.require("character", "the id or the index of a character");
    const Json* c = f.find("character");
    if (!c) return;
    const std::size_t count = content_.characters.size();
    std::size_t index = count;
    if (c->is_number_unsigned()) index = static_cast<std::size_t>(std::min<std::uint64_t>(c->get<std::uint64_t>(), count));
    if (c->is_string())
      index = static_cast<std::size_t>(std::ranges::find(content_.characters, c->get<std::string>(), &ExecutableCharacter::id) -
                                       content_.characters.begin());
    if (index < count) {
      e.character = static_cast<std::uint32_t>(index);
      return;
    }
    std::string ids;
    for (const ExecutableCharacter& one : content_.characters) ids += (ids.empty() ? "" : ", ") + one.id;
    f.report(ErrorCode::unknown, f.path("character"), "The content has no character " + to_text(*c) + ".", "It has: " + ids + ".");
  }

  void read_link(Fields& f, EventRecord& e) {
    const std::size_t problems = problems_.problems.size();
    read_character(f, e);
    f.require("link", "the name or the index of a link");
    const Json* l = f.find("link");
    if (!l || problems_.problems.size() > problems) return;
    const Mechanism& mechanism = *content_.mechanisms[static_cast<std::size_t>(content_.characters[e.character].mechanism)];
    int index = -1;
    if (l->is_number_unsigned() && l->get<std::uint64_t>() < static_cast<std::uint64_t>(mechanism.link_count()))
      index = static_cast<int>(l->get<std::uint64_t>());
    if (l->is_string()) index = find_link(mechanism, l->get<std::string>());
    if (index < 0)
      f.report(ErrorCode::unknown, f.path("link"), "The character has no link " + to_text(*l) + ".",
               "`ugoki info` lists the links of a mechanism.");
    e.link = std::max(index, 0);
  }

  const Executable& content_;
  std::string name_;
  Error problems_;
  circuit::DeviceState held_;
  std::vector<PlayerInput> out_;
};

/// Returns the complete state of the devices as JSON. In messages of a web page, mouse.wheel is the difference from the previous message. A
/// recording stores the sum of these differences in the field `wheel`, because the sum is the devices' state and can be restored exactly.
Json devices_json(const circuit::DeviceState& state) {
  const circuit::MouseState& m = state.mouse;
  Json pads = Json::array();
  for (const circuit::GamepadState& pad : state.gamepads)
    pads.push_back(pad == circuit::GamepadState{} ? Json(nullptr) : Json{{"axes", pad.axes}, {"buttons", pad.buttons}});
  return {{"keyboard", state.keys},
          {"mouse", {{"x", m.x}, {"y", m.y}, {"left", m.left}, {"middle", m.middle}, {"right", m.right}}},
          {"wheel", m.wheel},
          {"gamepads", std::move(pads)}};
}

}  // namespace

Result<std::vector<PlayerInput>> read_inputs(std::string_view text, const Executable& content, std::string_view name) {
  return Reader(content, name).read(text);
}

std::string write_inputs(const std::vector<PlayerInput>& inputs, const Executable& content) {
  Json list = Json::array();
  for (const PlayerInput& input : inputs) {
    Json json = {{"step", input.step}};
    const EventRecord& e = input.record;
    const auto add_character = [&] { json["character"] = content.characters[e.character].id; };
    if (input.held) {
      json["type"] = "input";
      json.update(devices_json(*input.held));
    } else if (e.kind == EventKind::push) {
      json["type"] = "push";
      add_character();
      json["link"] = e.link;
      json["force"] = to_json(e.a);
      json["duration"] = e.duration;
    } else if (e.kind == EventKind::grab) {
      json["type"] = "grab";
      add_character();
      json["link"] = e.link;
      json["point"] = to_json(e.a);
      json["target"] = to_json(e.b);
    } else if (e.kind == EventKind::drag) {
      json["type"] = "drag";
      json["target"] = to_json(e.b);
    } else if (e.kind == EventKind::release) {
      json["type"] = "release";
    } else if (e.kind == EventKind::throwing) {
      json["type"] = "throw";
      add_character();
      json["from"] = to_json(e.a);
      json["velocity"] = to_json(e.b);
      json["spin"] = to_json(e.c);
    } else {
      continue;
    }
    list.push_back(std::move(json));
  }
  return to_text(Json{{"inputs", std::move(list)}});
}

}  // namespace ugoki::content
