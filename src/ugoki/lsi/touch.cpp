#include "ugoki/lsi/touch.h"

#include <cmath>
#include <cstdio>

namespace ugoki::lsi {
namespace {

std::string name_of(const World& world, int character, int link) {
  const std::span<const Character> all = world.characters();
  if (character < 0 || static_cast<std::size_t>(character) >= all.size()) return "the ground";
  const Character& c = all[static_cast<std::size_t>(character)];
  if (c.mechanism->link_count() == 1) return c.id;
  if (link < 0 || link >= c.mechanism->link_count()) return c.id;
  return c.mechanism->link(link).name + " of " + c.id;
}

}  // namespace

EventRecord record_of(const contact::TouchEvent& event) {
  const contact::Touch& t = event.touch;
  EventRecord r;
  r.kind = event.phase == contact::TouchPhase::begin ? EventKind::touch : EventKind::parting;
  r.character = static_cast<std::uint32_t>(t.system_a);
  r.link = t.link_a;
  r.a = t.point;
  r.b = t.impulse;
  r.c = {static_cast<double>(t.system_b), static_cast<double>(t.link_b), 0};
  r.duration = t.duration;
  return r;
}

EventRecord omitted_record(std::size_t count) {
  EventRecord r;
  r.kind = EventKind::omitted;
  r.a.x = static_cast<double>(count);
  return r;
}

std::string describe_touch(const World& world, const EventRecord& record) {
  if (record.kind == EventKind::omitted) {
    char text[64];
    std::snprintf(text, sizeof text, "%.0f more touches began or ended in this tick", record.a.x);
    return text;
  }
  if (record.kind != EventKind::touch && record.kind != EventKind::parting) return {};
  const std::string a = name_of(world, static_cast<int>(record.character), record.link);
  const std::string b = name_of(world, static_cast<int>(record.c.x), static_cast<int>(record.c.y));
  char number[32];
  std::snprintf(number, sizeof number, "%.3g N s", norm(record.b));
  return a + (record.kind == EventKind::touch ? " touched " : " left ") + b + ", " + number;
}

}  // namespace ugoki::lsi
