#include "ugoki/intake/mapping_file.h"

#include <cmath>

#include "ugoki/json/fields.h"

namespace ugoki::intake {
namespace {

using json::Json;

constexpr std::size_t max_limbs = 16, max_sections = 16;

/// Reads the limbs of the list "limbs".
void read_limbs(json::Fields& document, body::AnatomyMapping& mapping) {
  const Json* limbs = document.list("limbs", max_limbs, "limbs");
  for (std::size_t i = 0; limbs && i < limbs->size(); ++i) {
    json::Fields f((*limbs)[i], document.path("limbs") + "/" + std::to_string(i), document.problems());
    if (!f.is_object()) continue;
    body::LimbMapping limb;
    f.require("limb", "the name of the limb, for example left leg");
    f.text("limb", limb.name);
    (void)f.find("confidence");
    (void)f.find("evidence");
    const Json* sections = f.list("sections", max_sections, "sections");
    for (std::size_t k = 0; sections && k < sections->size(); ++k) {
      json::Fields s((*sections)[k], f.path("sections") + "/" + std::to_string(k), document.problems());
      if (!s.is_object()) continue;
      body::SectionJoint joint;
      s.require("section", "the name of the section, for example thigh");
      s.text("section", joint.section);
      s.text("joint", joint.joint);
      s.refuse_others();
      limb.sections.push_back(std::move(joint));
    }
    f.refuse_others();
    mapping.limbs.push_back(std::move(limb));
  }
}

}  // namespace

std::string write_mapping(const body::AnatomyMapping& mapping) {
  nlohmann::ordered_json limbs = nlohmann::ordered_json::array();
  for (const body::LimbMapping& l : mapping.limbs) {
    nlohmann::ordered_json sections = nlohmann::ordered_json::array();
    for (const body::SectionJoint& s : l.sections) sections.push_back({{"section", s.section}, {"joint", s.joint}});
    limbs.push_back({{"limb", l.name},
                     {"confidence", std::round(100 * l.confidence) / 100},
                     {"evidence", l.evidence},
                     {"sections", std::move(sections)}});
  }
  nlohmann::ordered_json labels = nlohmann::ordered_json::object();
  for (const auto& [own, known] : mapping.labels) labels[own] = known;
  nlohmann::ordered_json document = {{"format", "ugoki anatomy mapping"},
                                     {"version", 1},
                                     {"plan", mapping.plan},
                                     {"confidence", std::round(100 * mapping.confidence) / 100},
                                     {"limbs", std::move(limbs)}};
  if (!mapping.labels.empty()) document["labels"] = std::move(labels);
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Result<body::AnatomyMapping> read_mapping(std::string_view text, std::string_view file_name) {
  const std::string location(file_name);
  Result<Json> document = json::parse_json(text, location);
  if (!document) return fail(std::move(document.error()));
  Error problems;
  json::Fields f(*document, location + ":", problems);
  body::AnatomyMapping out;
  if (f.is_object()) {
    std::string format;
    int version = 0;
    f.require("format", "the format, ugoki anatomy mapping");
    f.text("format", format);
    f.integer("version", version);
    if (!format.empty() && format != "ugoki anatomy mapping")
      f.report(ErrorCode::structure, f.path("format"), "The document is not an anatomy mapping.",
               "Write a mapping with `ugoki info FILE --mapping-out FILE.json`.");
    if (version > 1)
      f.report(ErrorCode::unsupported, f.path("version"), "Version " + std::to_string(version) + " of the format is newer than 1.",
               "Use a newer version of ugoki.");
    f.text("plan", out.plan);
    (void)f.find("confidence");
    read_limbs(f, out);
    if (const Json* labels = f.find("labels"); labels && labels->is_object()) {
      json::Fields list(*labels, f.path("labels"), problems);
      for (const auto& [own, ignored] : labels->items()) {
        std::string known;
        list.text(own, known);
        if (!known.empty()) out.labels.emplace_back(own, std::move(known));
      }
    }
    f.refuse_others();
  }
  if (!problems.empty()) return fail(std::move(problems));
  return out;
}

}  // namespace ugoki::intake
