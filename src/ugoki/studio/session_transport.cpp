// Session: what the operations of the transport must contain.

#include "ugoki/base/number.h"
#include "ugoki/circuit/devices.h"
#include "ugoki/json/json.h"
#include "ugoki/studio/interpreter.h"
#include "ugoki/studio/session.h"
#include "ugoki/studio/session_request.h"

namespace ugoki::studio {
namespace {

using json::Json;

constexpr std::size_t max_watched = 1000;  // maximum number of outputs in a `watch` request
constexpr std::size_t max_recorded = 64;   // maximum number of links in a `recorded` request

}  // namespace

Result<void> Session::check_transport(const Request& request) const {
  const std::string& op = request.op;
  const auto field = [&](const char* key) { return request.json.contains(key) ? request.json[key] : Json(); };
  if (op == "mode") {
    if (field("mode") != "edit" && field("mode") != "simulate") return Request::invalid_field("mode", "\"edit\" or \"simulate\"");
  } else if (op == "play") {
    if (!field("speed").is_null() && !request.has_number("speed")) return Request::invalid_field("speed", "a number");
    if (request.has_number("speed") && !request.is_number_from("speed", min_play_speed, max_play_speed))
      return Request::out_of_range("speed", min_play_speed, max_play_speed, "1 is real time.");
  } else if (op == "step" && request.json.contains("ticks")) {
    if (field("ticks") != 1) return Request::invalid_field("ticks", "1");
  } else if (op == "step") {
    if (!field("frames").is_number_integer() || (field("frames") != 1 && field("frames") != -1))
      return Request::invalid_field("frames", "1 or -1");
  } else if (op == "seek") {
    if (!request.has_number("time")) return Request::invalid_field("time", "a number of seconds");
    const double duration = shown_.scenario().duration;
    if (!request.is_number_from("time", 0, duration))
      return Request::out_of_range("time", 0, duration, "The scenario's duration is " + to_text(duration) + " s.");
  } else if (op == "drag") {
    if (!request.has_vector("target")) return Request::invalid_field("target", "three numbers");
  } else if (op == "forget_pull") {
    if (!request.has_number("time")) return Request::invalid_field("time", "the time of a pull in seconds");
  } else if (op == "grab" || op == "push") {
    if (!field("character").is_string()) return Request::invalid_field("character", "a character's id");
    if (!field("link").is_number_integer() && !field("link").is_string()) return Request::invalid_field("link", "a link's index or name");
    const char* vectors[] = {op == "grab" ? "point" : "force", op == "grab" ? "target" : "force"};
    for (const char* key : vectors) {
      if (!request.has_vector(key)) return Request::invalid_field(key, "three numbers");
    }
    if (op == "push" && !request.has_number("duration")) return Request::invalid_field("duration", "a number of seconds");
  } else if (op == "watch") {
    for (const char* key : {"pins", "probes"})
      if (!field(key).is_array() || field(key).size() > max_watched)
        return Request::invalid_field(key, "a list of at most " + std::to_string(max_watched) + " outputs");
    if (!field("timing").is_boolean()) return Request::invalid_field("timing", "true or false");
    for (const char* key : {"closest", "nearest"})  // "nearest" is the old name of "closest"
      if (!field(key).is_null() && !field(key).is_boolean()) return Request::invalid_field(key, "true or false");
  } else if (op == "recorded") {
    if (!field("character").is_string()) return Request::invalid_field("character", "a character's id");
    if (!field("links").is_array() || field("links").size() > max_recorded)
      return Request::invalid_field("links", "a list of at most " + std::to_string(max_recorded) + " names of links");
  } else if (op == "input") {
    if (Result<circuit::DeviceChange> r = circuit::read_device_change(json::to_text(request.json)); !r) return fail(std::move(r.error()));
  } else if (op != "pause" && op != "restart" && op != "release") {
    return fail(ErrorCode::unknown, "op", "There is no operation \"" + op + "\".", "See docs/studio-protocol.md for the operations.");
  }
  return {};
}

}  // namespace ugoki::studio
