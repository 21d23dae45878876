#include "ugoki/studio/content_recipes.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "ugoki/content/flatten.h"
#include "ugoki/content/gait_recipe_json.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/intake/intake.h"
#include "ugoki/json/fields.h"
#include "ugoki/mechanism_edit/combine.h"
#include "ugoki/mechanism_edit/scale.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/gait_clip.h"
#include "ugoki/studio/motion_edits.h"

namespace ugoki::studio {
namespace {

using content::Resources;
using json::Fields;
using json::Json;

constexpr double max_still = 3600;                 // s: maximum duration of a still motion
constexpr std::size_t max_loops = 1000;            // loops that one recipe adds
constexpr std::size_t max_depth = 100;             // recipes that use each other
constexpr std::string_view body_suffix = "-body";  // id of the body of a measured motion: that of the motion and this

/// Makes the resources of a text. Recipes are followed when they are needed, so that their order in the text does not matter.
class Recipes {
 public:
  Recipes(const Json& text, std::string name, const std::function<bool()>& cancelled)
      : text_(text), name_(std::move(name)), cancelled_(cancelled) {}

  Result<MechanismPtr> mechanism(const std::string& id) {
    if (const auto known = made_.mechanisms.find(id); known != made_.mechanisms.end()) return known->second;
    if (const Json* recipe = entry("mechanisms", id)) {
      const std::string place = name_ + ", mechanism " + id;
      if (Result<void> begun = begin(place); !begun) return fail(std::move(begun.error()));
      Result<MechanismPtr> made = make_mechanism(*recipe, place);
      open_.erase(place);
      if (made) made_.mechanisms[id] = *made;
      return made;
    }
    if (id.ends_with(body_suffix)) {
      const std::string source = id.substr(0, id.size() - body_suffix.size());
      if (entry("measured", source)) {
        if (Result<void> read = take_in(source); !read) return fail(std::move(read.error()));
        return made_.mechanisms[id];
      }
    }
    const auto found = sample().mechanisms.find(id);
    if (found == sample().mechanisms.end())
      return fail(ErrorCode::unknown, name_ + ", mechanism " + id, "The text does not define the mechanism '" + id + "'.",
                  "Add it to `mechanisms`, or use `human`, `dog` or `ball`.");
    return made_.mechanisms[id] = found->second;
  }

  Result<MotionPtr> motion(const std::string& id) {
    if (const auto known = made_.motions.find(id); known != made_.motions.end()) return known->second;
    if (const Json* recipe = entry("motions", id)) {
      if (cancelled_ && cancelled_()) return fail(ErrorCode::cancelled, name_, "Cancelled.", "");
      const std::string place = name_ + ", motion " + id;
      if (Result<void> begun = begin(place); !begun) return fail(std::move(begun.error()));
      Result<Motion> made = make_motion(*recipe, place);
      open_.erase(place);
      if (!made) return fail(std::move(made.error()));
      if (recipe->contains("name")) made->name = (*recipe)["name"].get<std::string>();
      return made_.motions[id] = std::make_shared<const Motion>(std::move(*made));
    }
    if (entry("measured", id)) {
      if (Result<void> read = take_in(id); !read) return fail(std::move(read.error()));
      return made_.motions[id];
    }
    const auto found = sample().motions.find(id);
    if (found == sample().motions.end())
      return fail(ErrorCode::unknown, name_ + ", motion " + id, "The text does not define the motion '" + id + "'.",
                  "Add it to `motions`, or use `human-walk`, `human-stand`, `dog-trot` or `dog-stand`.");
    return made_.motions[id] = found->second;
  }

  Resources take() { return std::move(made_); }

  /// The recipe of a motion that is a gait; null for other motions.
  const content::GaitRecipe* gait_of(const std::string& motion) const {
    const auto found = gaits_.find(name_ + ", motion " + motion);
    return found == gaits_.end() ? nullptr : &found->second;
  }

 private:
  const Json* entry(const char* list, const std::string& id) const {
    if (!text_.contains(list) || !text_[list].is_object() || !text_[list].contains(id)) return nullptr;
    return &text_[list][id];
  }
  /// Error `structure` if the recipe is being followed already.
  Result<void> begin(const std::string& place) {
    if (open_.size() >= max_depth || !open_.insert(place).second)
      return fail(ErrorCode::structure, place, "The recipe needs its own result, or too many others.", "Name another mechanism or motion.");
    return {};
  }
  static const Resources& sample() {
    static const Resources resources = samples::make_sample().resources;
    return resources;
  }

  Result<MechanismPtr> make_mechanism(const Json& recipe, const std::string& place) {
    Error problems;
    Fields f(recipe, place, problems);
    if (!f.is_object()) return fail(std::move(problems));
    if (f.has("person")) {
      double height = 0;
      f.number("person", height);
      f.refuse_others();
      if (!problems.empty()) return fail(std::move(problems));
      return samples::make_person(height);
    }
    if (f.has("scale")) return scaled(f);
    if (f.has("combine")) return combined(f);
    return formats::read_mechanism(json::to_text(recipe), place);
  }

  Result<MechanismPtr> scaled(Fields& f) {
    std::string of;
    ScaleOptions options;
    f.text("scale", of);
    f.number("factor", options.length);
    f.refuse_others();
    if (!f.problems().empty()) return fail(f.problems());
    const Result<MechanismPtr> mechanism = this->mechanism(of);
    if (!mechanism) return mechanism;
    Result<Edited> made = scale(**mechanism, options);
    if (!made) return fail(std::move(made.error()));
    return made->mechanism;
  }

  /// The link `to` of a second mechanism becomes a child of the link `at` of the first one. `loops` are added, in the form of the file of
  /// a mechanism: the feet of a cyclist on the pedals.
  Result<MechanismPtr> combined(Fields& f) {
    std::string first, second, type = "fixed";
    CombineOptions options;
    f.text("combine", first);
    f.text("with", second);
    f.text("at", options.link_a);
    f.text("to", options.link_b);
    f.text("name", options.name);
    f.text("prefix", options.prefix_b);
    f.text("joint", type);
    std::array<double, 3> position{};
    f.numbers("position", position);
    options.X_AB.p = {position[0], position[1], position[2]};
    if (type != "fixed" && type != "spherical")
      f.report(ErrorCode::range, f.path("joint"), "It must be fixed or spherical.", "fixed is a weld.");
    options.joint.type = type == "fixed" ? JointType::fixed : JointType::spherical;
    const Json* loops = f.list("loops", max_loops, "loops");
    f.refuse_others();
    if (!f.problems().empty()) return fail(f.problems());
    const Result<MechanismPtr> a = mechanism(first);
    if (!a) return a;
    const Result<MechanismPtr> b = mechanism(second);
    if (!b) return b;
    Result<Combined> made = combine(**a, **b, options);
    if (!made) return fail(std::move(made.error()));
    if (loops == nullptr || loops->empty()) return made->mechanism;
    Result<Json> whole = json::parse_json(formats::write_mechanism(*made->mechanism), f.path());
    if (!whole) return fail(std::move(whole.error()));
    for (const Json& loop : *loops) (*whole)["loops"].push_back(loop);
    return formats::read_mechanism(json::to_text(*whole), f.path());
  }

  /// Reads a measured motion: a file of any format for skeletons, as text.
  Result<void> take_in(const std::string& id) {
    Error problems;
    Fields f(*entry("measured", id), name_ + ", measured " + id, problems);
    std::string file, text;
    f.require("file", "the name of the file, whose extension is that of its format");
    f.require("text", "the content of the file");
    f.text("file", file);
    f.text("text", text);
    f.refuse_others();
    if (!problems.empty()) return fail(std::move(problems));
    intake::IntakeOptions options;
    options.name = id;
    options.cancelled = cancelled_;
    Result<intake::Intake> read = intake::take_in(text, file, nullptr, options);
    if (!read) return fail(std::move(read.error()));
    if (!read->mechanism || !read->motion)
      return fail(ErrorCode::structure, f.path(), "The file contains no motion of a skeleton.", "Use a file such as BVH.");
    made_.mechanisms[id + std::string(body_suffix)] = read->mechanism;
    made_.motions[id] = std::make_shared<const Motion>(std::move(*read->motion));
    return {};
  }

  Result<Motion> make_motion(const Json& recipe, const std::string& place) {
    Error problems;
    Fields f(recipe, place, problems);
    if (!f.is_object()) return fail(std::move(problems));
    std::string name;
    f.text("name", name);
    return f.has("still") ? still(f) : f.has("gait") ? gait(f, place) : operation(f);
  }

  /// The neutral position for a time; with `with`, the joints of another motion for the links of the same name.
  Result<Motion> still(Fields& f) {
    std::string of, with, of_with;
    double duration = 1, rate = 60;
    bool cyclic = true;
    f.text("still", of);
    f.text("with", with);
    f.text("of", of_with);
    f.number("duration", duration);
    f.number("rate", rate);
    f.boolean("cyclic", cyclic);
    if (!(duration > 0 && duration <= max_still))
      f.report(ErrorCode::range, f.path("duration"), "It must be above 0 and at most 3600 s.", "1 is usual.");
    if (!(rate >= 1 && rate <= 1000))
      f.report(ErrorCode::range, f.path("rate"), "It must be from 1 to 1000 frames per second.", "60 is usual.");
    f.refuse_others();
    if (!f.problems().empty()) return fail(f.problems());
    const Result<MechanismPtr> mechanism = this->mechanism(of);
    if (!mechanism) return fail(mechanism.error());
    const Mechanism& m = **mechanism;
    Motion out;
    out.mechanism = m.name();
    out.nq = m.nq();
    out.rate = rate;
    out.frames = static_cast<int>(duration * rate + 0.5) + 1;
    out.cyclic = cyclic;
    out.name = "still";
    Result<MotionPtr> source = MotionPtr();
    Result<MechanismPtr> source_of = MechanismPtr();
    if (!with.empty()) {
      source = motion(with);
      if (!source) return fail(source.error());
      source_of = this->mechanism(of_with);
      if (!source_of) return fail(source_of.error());
      if (Error wrong = check_motion(**source, **source_of); !wrong.empty()) return fail(std::move(wrong));
      out.rate = (*source)->rate;
      out.frames = (*source)->frames;
      out.cyclic = (*source)->cyclic;
      out.name = (*source)->name;
      for (const ContactTrack& track : (*source)->contacts)
        if (m.find_link(track.link) >= 0) out.contacts.push_back(track);
    }
    const std::vector<double> neutral = m.neutral();
    for (int i = 0; i < out.frames; ++i) out.q.insert(out.q.end(), neutral.begin(), neutral.end());
    if (with.empty()) return out;
    for (const Link& to : m.links()) {
      const int index = (*source_of)->find_link(to.name);
      if (index < 0 || (*source_of)->link(index).joint.type != to.joint.type) continue;
      const int from = (*source_of)->link(index).q_index;
      for (int i = 0; i < out.frames; ++i) std::copy_n((*source)->frame(i) + from, to.joint.nq(), out.frame(i) + to.q_index);
    }
    return out;
  }

  /// A gait without measurement.
  Result<Motion> gait(Fields& f, const std::string& place) {
    std::string of;
    f.require("of", "the id of the mechanism that walks");
    f.text("of", of);
    GaitRequest request;
    content::read_gait_recipe(*f.find("gait"), f.path("gait"), request.clip.gait.emplace(), f.problems());
    f.refuse_others();
    if (!f.problems().empty()) return fail(f.problems());
    const Result<MechanismPtr> mechanism = this->mechanism(of);
    if (!mechanism) return fail(mechanism.error());
    request.mechanism = *mechanism;
    Result<EditedMotion> made = make_gait_clip(request);
    if (!made) return fail(std::move(made.error()));
    gaits_[place] = *made->clip.gait;
    return std::move(made->motion);
  }

  /// An operation of motion_edits.h on a whole motion.
  Result<Motion> operation(Fields& f) {
    MotionEdit edit;
    std::string of, from, other, other_of, body;
    f.require("operation", "the name of an operation, see docs/studio-protocol.md");
    f.require("motion", "the id of the motion on which it operates");
    f.require("of", "the id of the mechanism that this motion moves");
    f.text("operation", edit.operation);
    f.text("motion", from);
    f.text("of", of);
    f.text("other", other);
    f.text("other_of", other_of);
    f.text("for", body);
    if (const Json* options = f.find("options")) edit.options = *options;
    f.refuse_others();
    if (!f.problems().empty()) return fail(f.problems());
    const Result<Needs> needs = needs_of(edit.operation);
    if (!needs) return fail(needs.error());
    if (*needs == Needs::next_clip)
      return fail(ErrorCode::unsupported, f.path("operation"), "'" + edit.operation + "' needs a second clip.", "Use another operation.");
    const Result<MechanismPtr> mechanism = this->mechanism(of);
    if (!mechanism) return fail(mechanism.error());
    const Result<MotionPtr> source = motion(from);
    if (!source) return fail(source.error());
    edit.mechanism = *mechanism;
    edit.target.motion = *source;
    edit.target.clip.length = (*source)->duration();
    edit.target.clip.loop = (*source)->cyclic;
    if (*needs == Needs::other_motion) {
      const Result<MotionPtr> second = motion(other);
      if (!second) return fail(second.error());
      const Result<MechanismPtr> second_of = this->mechanism(other_of.empty() ? of : other_of);
      if (!second_of) return fail(second_of.error());
      edit.other = *second;
      edit.other_mechanism = *second_of;
    }
    if (*needs == Needs::body) {
      const Result<MechanismPtr> to = this->mechanism(body);
      if (!to) return fail(to.error());
      edit.body = *to;
    }
    Result<EditedMotion> made = edit_motion(edit);
    if (!made) return fail(std::move(made.error()));
    return std::move(made->motion);
  }

  const Json& text_;
  std::string name_;
  const std::function<bool()>& cancelled_;
  Resources made_;
  std::map<std::string, content::GaitRecipe> gaits_;
  std::set<std::string> open_;  // places of the recipes that are being followed
};

}  // namespace

Result<content::ContentText> make_content(std::string_view text, std::string_view name, const std::function<bool()>& cancelled) {
  const std::string place(name);
  const Result<Json> json = json::parse_json(text, place);
  if (!json) return fail(json.error());
  Json plain = Json::object();  // scenario and circuit, which content::read_content() checks
  if (json->is_object())
    for (const char* part : {"scenario", "circuit"})
      if (json->contains(part)) plain[part] = (*json)[part];
  plain["mechanisms"] = Json::object();
  Result<content::ContentText> content = content::read_content(json::to_text(plain), place);
  if (!content) return content;
  Recipes recipes(*json, place, cancelled);
  const auto mechanism = [&](const std::string& id) -> Result<void> {
    if (Result<MechanismPtr> made = recipes.mechanism(id); !made) return fail(std::move(made.error()));
    return {};
  };
  const auto motion = [&](const std::string& id) -> Result<void> {
    if (Result<MotionPtr> made = recipes.motion(id); !made) return fail(std::move(made.error()));
    return {};
  };
  const auto character = [&](content::ScenarioCharacter& c) -> Result<void> {
    if (c.prop) return {};  // its mechanism follows from the scenario
    if (Result<void> made = mechanism(c.mechanism); !made) return made;
    for (content::ScenarioClip& clip : c.track) {
      if (Result<void> made = motion(clip.motion); !made) return made;
      const content::GaitRecipe* gait = recipes.gait_of(clip.motion);
      if (gait == nullptr) continue;
      if (!clip.gait) clip.gait = *gait;  // the clip can be changed in the inspector
      // a text cannot know how long a gait along a path lasts
      if (!clip.loop && clip.speed > 0)
        clip.length = std::min(clip.length, (recipes.motion(clip.motion).value()->duration() - clip.offset) / clip.speed);
    }
    return {};
  };
  Error problems;
  const auto take = [&](Result<void> made) {
    if (!made && problems.empty()) problems = std::move(made.error());
  };
  content::for_each_scenario(content->scenario, [&](content::Scenario& s) {
    for (content::ScenarioCharacter& c : s.characters) take(character(c));
    for (const content::Rule& rule : s.rules)
      if (rule.action.type == content::ActionType::play) take(motion(rule.action.motion));
  });
  if (!problems.empty()) return fail(std::move(problems));
  for (const char* list : {"mechanisms", "motions"})  // also those that no character uses yet
    if (json->contains(list) && (*json)[list].is_object())
      for (const auto& [id, recipe] : (*json)[list].items())
        if (Result<void> made = list[1] == 'e' ? mechanism(id) : motion(id); !made) return fail(std::move(made.error()));
  content->resources = recipes.take();
  return content;
}

}  // namespace ugoki::studio
