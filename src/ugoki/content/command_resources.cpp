#include "ugoki/content/commands.h"
#include "ugoki/content/json_fields.h"
#include "ugoki/content/list_commands.h"

namespace ugoki::content {
namespace {

void collect_resources(const Json& command, std::vector<std::string>& out) {
  if (!command.is_object()) return;
  for (const char* key : {"motion", "mechanism", "mesh"})
    if (const auto it = command.find(key); it != command.end() && it->is_string()) out.push_back(it->get_ref<const std::string&>());
  for (const char* key : {"rule", "do", "prop", "command"})
    if (const auto it = command.find(key); it != command.end()) collect_resources(*it, out);
  if (const auto it = command.find("commands"); it != command.end() && it->is_array())
    for (const Json& c : *it) collect_resources(c, out);
}

}  // namespace

std::vector<std::string> resources_named(std::string_view command) {
  std::vector<std::string> ids;
  if (const Result<Json> json = parse_json(command, "command", max_command_size)) collect_resources(*json, ids);
  return ids;
}

}  // namespace ugoki::content
