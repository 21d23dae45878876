#include "ugoki/content/content_file.h"

#include <string>

#include "ugoki/formats/mechanism_json.h"
#include "ugoki/json/json.h"

namespace ugoki::content {

using json::Json;

Result<ContentText> read_content(std::string_view text, std::string_view name) {
  const std::string place(name);
  const Result<Json> json = json::parse_json(text, place);
  if (!json) return fail(json.error());
  const auto part = [&](const char* key) { return json->is_object() && json->contains(key) ? (*json)[key] : Json(); };
  const Json mechanisms = part("mechanisms"), circuit = part("circuit");
  if (!part("scenario").is_object() || !mechanisms.is_object())
    return fail(ErrorCode::structure, place, "The file has no objects `scenario` and `mechanisms`.", "docs/export.md shows an example.");
  Result<Scenario> document = read_scenario(json::to_text(part("scenario")), place + ", scenario");
  if (!document) return fail(std::move(document.error()));
  ContentText content{std::move(*document), {}};
  for (const auto& [id, mechanism] : mechanisms.items()) {
    Result<MechanismPtr> read = formats::read_mechanism(json::to_text(mechanism), place + ", mechanism " + id);
    if (!read) return fail(std::move(read.error()));
    content.resources.mechanisms[id] = std::move(*read);
  }
  if (!circuit.is_null()) content.scenario.circuit = json::to_text(circuit);
  return content;
}

}  // namespace ugoki::content
