#include "ugoki/base/number.h"
#include "ugoki/content/gait_recipe_json.h"
#include "ugoki/json/fields.h"

namespace ugoki::content {
namespace {

using json::Fields;
using json::Json;

constexpr std::size_t max_stages = 100, max_points = 1000;

}  // namespace

void read_gait_recipe(const Json& value, const std::string& location, GaitRecipe& out, Error& problems) {
  Fields f(value, location, problems);
  f.text("kind", out.kind);
  f.text("style", out.style);
  f.number("speed", out.speed);
  f.number("turn", out.turn);
  f.number("seconds", out.seconds);
  f.boolean("from_stand", out.from_stand);
  f.boolean("to_stand", out.to_stand);
  f.number("step_height", out.step_height);
  if (const Json* list = f.list("stages", max_stages, "stages")) {
    out.stages.clear();
    for (const Json& entry : *list) {
      GaitRecipeStage& stage = out.stages.emplace_back();
      Fields g(entry, f.path("stages") + "/" + std::to_string(out.stages.size() - 1), problems);
      g.require("time", "the time in seconds at which the stage begins");
      g.number("time", stage.time);
      g.text("kind", stage.kind);
      g.number("speed", stage.speed);
      g.number("turn", stage.turn);
      g.refuse_others();
    }
  }
  if (const Json* list = f.list("path", max_points, "points")) {
    out.path.clear();
    for (const Json& entry : *list) f.numbers(entry, f.path("path") + "/" + std::to_string(out.path.size()), out.path.emplace_back());
  }
  f.refuse_others();
}

Json to_json(const GaitRecipe& r) {
  Json json = {{"kind", r.kind},       {"style", r.style},           {"speed", r.speed},      {"turn", r.turn},
               {"seconds", r.seconds}, {"from_stand", r.from_stand}, {"to_stand", r.to_stand}};
  if (r.step_height > 0) json["step_height"] = r.step_height;
  if (!r.stages.empty()) {
    Json stages = Json::array();
    for (const GaitRecipeStage& s : r.stages) stages.push_back({{"time", s.time}, {"kind", s.kind}, {"speed", s.speed}, {"turn", s.turn}});
    json["stages"] = std::move(stages);
  }
  if (!r.path.empty()) json["path"] = r.path;
  return json;
}

void check_gait_recipe(const GaitRecipe& r, const std::string& location, Error& problems) {
  const auto range = [&](const std::string& key, double value, double low, double high, const std::string& unit) {
    if (!(value >= low && value <= high))
      problems.add(ErrorCode::range, location + "/" + key, "The value " + ugoki::to_text(value) + " is out of range.",
                   "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + " " + unit + ".");
  };
  const auto name = [&](const std::string& key, const std::string& text) {
    if (text.empty() || text.size() > 40)
      problems.add(ErrorCode::range, location + "/" + key, "The name is empty or longer than 40 bytes.", "Give a name of docs/gait.md.");
  };
  name("kind", r.kind);
  name("style", r.style);
  if (r.speed != -1) range("speed", r.speed, 0, 30, "m/s, or -1 for the usual speed");
  range("turn", r.turn, -360, 360, "degrees per second");
  range("seconds", r.seconds, 0.5, 600, "s");
  range("step_height", r.step_height, 0, 5, "m");
  for (std::size_t i = 0; i < r.stages.size(); ++i) {
    const std::string at = "stages/" + std::to_string(i) + "/";
    name(at + "kind", r.stages[i].kind);
    range(at + "time", r.stages[i].time, 0, 600, "s");
    range(at + "speed", r.stages[i].speed, 0, 30, "m/s");
    range(at + "turn", r.stages[i].turn, -360, 360, "degrees per second");
  }
  for (std::size_t i = 0; i < r.path.size(); ++i)
    for (const double x : r.path[i]) range("path/" + std::to_string(i), x, -1000, 1000, "m");
}

}  // namespace ugoki::content
