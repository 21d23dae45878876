#include "sweep.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "output.h"
#include "ugoki/base/number.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/generate.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::cli {
namespace {

constexpr std::uint64_t max_runs = 100'000'000;

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> out;
  std::size_t at = 0;
  for (;;) {
    const std::size_t end = text.find(mark, at);
    out.push_back(text.substr(at, end == std::string::npos ? end : end - at));
    if (end == std::string::npos) return out;
    at = end + 1;
  }
}

std::unexpected<Error> bad_variation(const std::string& text, const char* why) {
  return fail(ErrorCode::syntax, "--vary " + text, why, "Write, for example, --vary push=0,150,300 or --vary friction=0.2:1:9.");
}

const std::vector<std::string>& short_names() {
  static const std::vector<std::string> names = {"push",     "push-angle", "push-time", "push-duration", "push-link",   "assist-limit",
                                                 "tracking", "balance",    "friction",  "restitution",   "steps-per-s", "gravity"};
  return names;
}

/// Reads a number. The error names the quantity.
Result<double> number_of(const Variation& v, const std::string& text) {
  const std::optional<double> x = parse_double(text);
  if (x) return *x;
  return fail(ErrorCode::syntax, "--vary " + v.name, "'" + text + "' is not a number.", "Give numbers for this quantity.");
}

/// Returns the value as JSON: a number if the text is a number, otherwise a string.
Json value_json(const std::string& text) {
  if (const std::optional<double> x = parse_double(text)) return *x;
  if (text == "true" || text == "false") return text == "true";
  return text;
}

/// The LSI with the path `id` ("control", or "human/control" in a nested circuit); null: there is none.
Json* find_lsi(Json& circuit, const std::string& id) {
  const std::size_t slash = id.find('/');
  if (!circuit.contains("lsis") || !circuit["lsis"].is_array()) return nullptr;
  for (Json& one : circuit["lsis"]) {
    if (one.value("id", "") != id.substr(0, slash)) continue;
    if (slash == std::string::npos) return &one;
    if (!circuit.contains("circuits") || !circuit["circuits"].is_array()) return nullptr;
    for (Json& inner : circuit["circuits"])
      if (inner.value("name", "") == one.value("type", "")) return find_lsi(inner, id.substr(slash + 1));
  }
  return nullptr;
}

/// Sets parameter PARAMETER of the LSI with the path ID in the circuit document.
Result<void> set_parameter(content::Scenario& s, const std::string& name, const std::string& value) {
  const std::size_t dot = name.rfind('.');
  const std::string id = name.substr(4, dot == std::string::npos ? dot : dot - 4),
                    parameter = dot == std::string::npos ? "" : name.substr(dot + 1);
  if (s.circuit.empty()) s.circuit = content::default_circuit(content::played_part(s));
  Result<Json> circuit = json::parse_json(s.circuit, "circuit");
  if (!circuit) return fail(std::move(circuit.error()));
  if (Json* lsi = find_lsi(*circuit, id); lsi && !parameter.empty()) {
    (*lsi)["parameters"][parameter] = value_json(value);
    s.circuit = json::to_text(*circuit);
    return {};
  }
  return fail(ErrorCode::unknown, "--vary " + name, "The circuit has no LSI '" + id + "'.",
              "Write lsi:ID.PARAMETER, for example lsi:human/control.tracking.");
}

constexpr const char* usual_link = "chest";  // the link on which pushes act, unless push-link is varied

/// The character on which pushes act; null: there is none.
const content::ScenarioCharacter* pushed_character(const content::Scenario& s) {
  const auto found = std::ranges::find_if(
      s.characters, [](const content::ScenarioCharacter& c) { return c.control.mode != content::ControlMode::passive; });
  return found == s.characters.end() ? nullptr : &*found;
}

Result<void> check_link(const content::ScenarioCharacter& character, const content::Resources& resources, const std::string& link) {
  if (content::find_link(*resources.mechanisms.at(character.mechanism), link) >= 0) return {};
  if (link == usual_link)
    return fail(ErrorCode::unknown, "--vary push", "The character has no link '" + link + "', on which pushes act by default.",
                "Name a link: --vary push-link=LINK. `ugoki info` lists the links.");
  return fail(ErrorCode::unknown, "--vary push-link", "The character has no link '" + link + "'.", "`ugoki info` lists the links.");
}

}  // namespace

Result<Variation> read_variation(const std::string& text, bool random) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    return bad_variation(text, "A variation consists of a name, '=' and values.");
  Variation v;
  v.name = text.substr(0, equals);
  const std::string values = text.substr(equals + 1);
  if (!v.name.starts_with("/") && !v.name.starts_with("lsi:") && std::ranges::find(short_names(), v.name) == short_names().end()) {
    std::string names;
    for (const std::string& n : short_names()) names += (names.empty() ? "" : ", ") + n;
    return fail(ErrorCode::unknown, "--vary " + text, "'" + v.name + "' is not a quantity that can be varied.",
                "Use " + names + ", a JSON pointer into the scenario (/gravity/2), or lsi:ID.PARAMETER.");
  }
  const std::vector<std::string> range = split(values, ':');
  if (range.size() == 2 || range.size() == 3) {
    const std::optional<double> low = parse_double(range[0]), high = parse_double(range[1]);
    if (!low || !high) return bad_variation(text, "The ends of the range are not numbers.");
    v.low = *low;
    v.high = *high;
    if (range.size() == 2) {
      if (!random) return bad_variation(text, "A range needs the number of values: LOW:HIGH:COUNT; LOW:HIGH alone is for --random.");
      return v;
    }
    const std::optional<long> count = parse_long(range[2]);
    if (!count || *count < 1 || *count > 1'000'000) return bad_variation(text, "The number of values is not between 1 and 1000000.");
    for (long i = 0; i < *count; ++i)
      v.values.push_back(
          to_text(*count == 1 ? v.low : v.low + (v.high - v.low) * static_cast<double>(i) / static_cast<double>(*count - 1)));
    return v;
  }
  v.values = split(values, ',');
  return v;
}

std::uint64_t SweepPlan::size() const {
  std::uint64_t each = std::max<std::uint64_t>(random, 1);
  if (random == 0)
    for (const Variation& v : variations) each = std::min(max_runs + 1, each * v.values.size());
  return std::min(max_runs + 1, each * targets.size());
}

std::pair<std::size_t, std::vector<std::string>> SweepPlan::run(std::uint64_t number) const {
  std::vector<std::string> values;
  if (random > 0) {
    std::mt19937_64 source(seed * 0x9E3779B97F4A7C15ULL + number);
    for (const Variation& v : variations) {
      if (!v.values.empty()) {
        values.push_back(v.values[static_cast<std::size_t>(source() % v.values.size())]);
        continue;
      }
      const double s =
          static_cast<double>(source() >> 11) * 0x1p-53;  // the results of std::uniform_real_distribution differ between libraries
      values.push_back(to_text(v.low + (v.high - v.low) * s));
    }
    return {static_cast<std::size_t>(number / random), std::move(values)};
  }
  std::uint64_t rest = number;
  for (const Variation& v : variations) {
    values.push_back(v.values[static_cast<std::size_t>(rest % v.values.size())]);
    rest /= v.values.size();
  }
  return {static_cast<std::size_t>(rest), std::move(values)};
}

std::string SweepPlan::text() const {
  Json varied = Json::array();
  for (const Variation& v : variations) varied.push_back({{"name", v.name}, {"values", v.values}, {"low", v.low}, {"high", v.high}});
  Json names = Json::array();
  for (std::size_t i = 0; i < targets.size(); ++i) names.push_back({{"target", targets[i]}, {"content", hashes[i]}});
  return json::to_text(
      Json{{"version", 1}, {"targets", names}, {"vary", varied}, {"random", random}, {"seed", seed}, {"duration", duration}});
}

Result<void> apply_variations(content::Scenario& s, const content::Resources& resources, const std::vector<Variation>& variations,
                              const std::vector<std::string>& values) {
  double push = 0, angle = 0, time = 1, duration = 0.2;
  std::string link = usual_link;
  // JSON pointers are applied first, because they replace the document.
  for (std::size_t i = 0; i < variations.size(); ++i) {
    if (!variations[i].name.starts_with("/")) continue;
    Result<Json> document = json::parse_json(content::write_scenario(s), "scenario");
    if (!document) return fail(std::move(document.error()));
    const bool exists = [&] {
      Json* at = &*document;
      for (const std::string& part : split(variations[i].name.substr(1), '/')) {
        const std::optional<long> index = parse_long(part);
        if (at->is_array() && index && *index >= 0 && static_cast<std::size_t>(*index) < at->size())
          at = &(*at)[static_cast<std::size_t>(*index)];
        else if (at->is_object() && at->contains(part))
          at = &(*at)[part];
        else
          return false;
      }
      *at = value_json(values[i]);
      return true;
    }();
    if (!exists)
      return fail(ErrorCode::unknown, "--vary " + variations[i].name, "The scenario document has no such value.",
                  "docs/scenario.md lists its fields.");
    Result<content::Scenario> changed =
        content::read_scenario(json::to_text(*document), "scenario with " + variations[i].name + " = " + values[i]);
    if (!changed) return fail(std::move(changed.error()));
    s = std::move(*changed);
  }
  for (std::size_t i = 0; i < variations.size(); ++i) {
    const Variation& v = variations[i];
    if (v.name.starts_with("/")) continue;
    if (v.name.starts_with("lsi:")) {
      if (Result<void> done = set_parameter(s, v.name, values[i]); !done) return done;
      continue;
    }
    if (v.name == "push-link") {
      link = values[i];
      continue;
    }
    const Result<double> x = number_of(v, values[i]);
    if (!x) return fail(x.error());
    if (v.name == "push") push = *x;
    if (v.name == "push-angle") angle = *x;
    if (v.name == "push-time") time = *x;
    if (v.name == "push-duration") duration = *x;
    if (v.name == "friction") s.ground.friction = *x;
    if (v.name == "restitution") s.ground.restitution = *x;
    if (v.name == "gravity") s.gravity.z = -*x;
    if (v.name == "steps-per-s") s.step = 1 / *x;
    for (content::ScenarioCharacter& c : s.characters) {
      if (v.name == "assist-limit") c.control.assist_limit = *x;
      if (v.name == "tracking") c.control.tracking = *x;
      if (v.name == "balance") c.control.balance = *x;
    }
  }
  if (push == 0) return {};
  const content::ScenarioCharacter* target = pushed_character(s);
  if (target == nullptr)
    return fail(ErrorCode::structure, "--vary push", "The content has no character that follows a track.", "Vary another quantity.");
  if (Result<void> known = check_link(*target, resources, link); !known) return known;
  content::ScenarioEvent event;
  event.id = "bake-push";
  event.time = time;
  event.duration = duration;
  event.character = target->id;
  event.link = link;
  const SinCos a = sin_cos((target->place.heading + angle) * pi / 180);  // 0: forward, 90: to the left
  event.force = {push * a.cos, push * a.sin, 0};
  s.events.push_back(std::move(event));
  return {};
}

Result<void> check_push_links(const content::Scenario& scenario, const content::Resources& resources,
                              const std::vector<Variation>& variations) {
  const auto find = [&](const char* name) { return std::ranges::find(variations, name, &Variation::name); };
  const auto links = find("push-link");
  if (links == variations.end()) return {};
  if (find("push") == variations.end())
    return fail(ErrorCode::structure, "--vary push-link", "No push acts on the link.", "Vary the force too, for example --vary push=200.");
  const content::ScenarioCharacter* target = pushed_character(scenario);
  if (target == nullptr)
    return fail(ErrorCode::structure, "--vary push", "The content has no character that follows a track.", "Vary another quantity.");
  for (const std::string& link : links->values)
    if (Result<void> known = check_link(*target, resources, link); !known) return known;
  return {};
}

const std::vector<std::string>& sweep_measures() {
  static const std::vector<std::string> names = {
      "tracking_rms_deg",    "assist_rms_bw",  "assist_force_rms_bw", "assist_max_bw", "foot_skate_cm",
      "foot_skate_worst_cm", "penetration_mm", "penetration_rms_mm",  "fell",          "release_time"};
  return names;
}

}  // namespace ugoki::cli
