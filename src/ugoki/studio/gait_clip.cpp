#include "ugoki/studio/gait_clip.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/gait/gait.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::studio {
namespace {

constexpr double degree = pi / 180;

Result<gait::GaitKind> kind_of(const std::string& name) {
  if (const std::optional<gait::GaitKind> kind = gait::kind_named(name)) return *kind;
  return fail(ErrorCode::unknown, "kind", "There is no gait '" + name + "'.", "docs/gait.md lists the kinds.");
}

/// Options of the recipe; usual speeds are written into the recipe.
Result<gait::GaitOptions> options_of(const MechanismPtr& mechanism, content::GaitRecipe& recipe, double gravity) {
  gait::GaitOptions o;
  const std::optional<gait::GaitStyle> style = gait::style_named(recipe.style);
  if (!style) return fail(ErrorCode::unknown, "style", "There is no style '" + recipe.style + "'.", "docs/gait.md lists the styles.");
  o.style = *style;
  o.gravity = gravity;
  o.seconds = recipe.seconds;
  o.from_stand = recipe.from_stand;
  o.to_stand = recipe.to_stand;
  o.step_height = recipe.step_height;
  const Result<gait::GaitKind> kind = kind_of(recipe.kind);
  if (!kind) return fail(kind.error());
  if (recipe.speed < 0) {
    const Result<double> usual = gait::usual_speed(mechanism, *kind, gravity);
    if (!usual) return fail(usual.error());
    recipe.speed = std::round(*usual * 100) / 100;
  }
  o.stages = {{0, *kind, recipe.speed, recipe.turn * degree}};
  for (const content::GaitRecipeStage& s : recipe.stages) {
    const Result<gait::GaitKind> next = kind_of(s.kind);
    if (!next) return fail(next.error());
    o.stages.push_back({s.time, *next, s.speed, s.turn * degree});
  }
  std::ranges::sort(o.stages, {}, &gait::GaitStage::time);
  if (!recipe.path.empty()) {
    // A clip is placed by the root's heading in its first frame, so the path begins straight ahead.
    constexpr double max_lead = 0.3, lead_share = 0.25;  // m; of the distance of the first point
    const double lead = std::min(max_lead, lead_share * std::hypot(recipe.path[0][0], recipe.path[0][1]));
    o.path = {{0, 0, 0}, {lead, 0, 0}};
    for (const std::array<double, 2>& p : recipe.path) o.path.push_back({p[0], p[1], 0});
    if (Result<void> fitted = gait::fit_to_path(mechanism, o); !fitted) return fail(fitted.error());
    recipe.seconds = o.seconds;
    recipe.from_stand = recipe.to_stand = true;
  }
  return o;
}

}  // namespace

Result<EditedMotion> make_gait_clip(const GaitRequest& request) {
  EditedMotion out;
  out.clip = request.clip;
  out.label = request.old ? "Change gait" : "Make a gait";
  content::GaitRecipe& recipe = *out.clip.gait;
  Error problems;
  content::check_gait_recipe(recipe, "gait", problems);
  if (!problems.empty()) return fail(std::move(problems));
  Result<gait::GaitOptions> options = options_of(request.mechanism, recipe, request.gravity);
  if (!options) return fail(options.error());
  options->cancelled = [flag = request.cancelled] { return flag != nullptr && *flag; };
  gait::GaitReport report;
  Result<Motion> made = gait::make_gait(request.mechanism, *options, &report);
  if (!made) return fail(made.error());
  if (recipe.stages.empty() && recipe.speed - options->stages.back().speed > 0.01)  // fit_to_path() lowered it
    out.report.push_back("The path is short, so the speed is " + to_fixed(options->stages.back().speed, 2) + " m/s.");
  if (report.max_miss > 0.01)
    out.report.push_back("A foot misses its place by " + to_fixed(100 * report.max_miss, 1) + " cm: the steps are too long for the legs.");
  out.report.insert(out.report.end(), report.notes.begin(), report.notes.end());
  content::ScenarioClip& clip = out.clip;
  const double usable = std::max(0.001, (made->duration() - clip.offset) / clip.speed);
  const bool to_the_end =
      !request.old || clip.offset + clip.length * clip.speed > request.old->duration() - 1.5 / std::max(1.0, request.old->rate);
  if (clip.offset >= made->duration()) clip.offset = 0;
  clip.loop = false;
  clip.length = to_the_end ? std::max(0.001, (made->duration() - clip.offset) / clip.speed) : std::min(clip.length, usable);
  out.motion = std::move(*made);
  return out;
}

Result<json::Json> describe_gaits(const MechanismPtr& mechanism) {
  const Result<std::vector<gait::GaitKind>> kinds = gait::kinds_of(mechanism);
  if (!kinds) return fail(kinds.error());
  json::Json out = {{"kinds", json::Json::array()}, {"styles", json::Json::array()}};
  for (const gait::GaitKind kind : *kinds) {
    const Result<double> usual = gait::usual_speed(mechanism, kind);
    out["kinds"].push_back({{"kind", gait::name_of(kind)}, {"speed", usual ? *usual : 1}});
  }
  for (const std::string_view style : gait::style_names()) out["styles"].push_back(style);
  return out;
}

}  // namespace ugoki::studio
