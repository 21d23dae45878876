// Members of Session for breakpoints of the open project's circuit. All pages share the breakpoints, each new interpreter gets them, and
// the project file stores them.

#include "ugoki/circuit/breakpoint.h"
#include "ugoki/studio/session_request.h"

namespace ugoki::studio {

using json::Json;

Result<void> Session::take_breakpoints(const Request& request) {
  constexpr std::size_t maximum = 100;
  const auto list = request.json.find("list");
  if (list == request.json.end() || !list->is_array() || list->size() > maximum)
    return Request::invalid_field("list", "a list of at most " + std::to_string(maximum) + " breakpoints");
  Json kept = Json::array(), conditions = Json::array();
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& item = (*list)[i];
    const std::string location = "list/" + std::to_string(i);
    if (!item.is_object() || !item.contains("condition") || !item["condition"].is_string())
      return Request::invalid_field(location, "an object with a \"condition\"");
    if (item.contains("on") && !item["on"].is_boolean()) return Request::invalid_field(location + "/on", "true or false");
    const std::string condition = item["condition"].get<std::string>();
    Result<circuit::Breakpoint> read = circuit::read_breakpoint(condition);
    if (!read) {
      for (Problem& problem : read.error().problems) problem.location = location + "/" + problem.location;
      return fail(std::move(read.error()));
    }
    const bool on = item.value("on", true);
    kept.push_back({{"condition", condition}, {"pin", read->pin}, {"component", read->component}, {"on", on}});
    if (on) conditions.push_back(condition);
  }
  breakpoints_ = json::to_text(kept);
  breakpoints_request_ = json::to_text({{"op", "breakpoints"}, {"conditions", conditions}});
  return {};
}

Result<std::string> Session::set_breakpoints(const Request& request) {
  if (Result<void> read = take_breakpoints(request); !read) return fail(std::move(read.error()));
  send_to_interpreter(breakpoints_request_, {}, {});
  outbox_.broadcast("{\"event\":\"breakpoints\",\"list\":" + breakpoints_ + "}");
  if (Result<void> kept = project_.keep("breakpoints", breakpoints_); !kept)
    log("warning", "The breakpoints could not be stored and will be lost when the studio is closed. " + kept.error().text());
  return "";
}

void Session::restore_breakpoints() {
  const Result<std::string> kept = project_.kept("breakpoints");
  if (!kept || kept->empty()) return;
  Request request;
  if (Result<Json> list = json::parse_json(*kept, "breakpoints")) request.json = {{"list", std::move(*list)}};
  if (!request.json.is_object() || !take_breakpoints(request)) log("warning", "The project's breakpoints cannot be read. Set them again.");
}

}  // namespace ugoki::studio
