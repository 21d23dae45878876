#pragma once
// Contact events as records of pins, and in words.

#include <string>

#include "ugoki/contact/contact_events.h"
#include "ugoki/lsi/world.h"

namespace ugoki::lsi {

[[nodiscard]] EventRecord record_of(const contact::TouchEvent& event);

/// "left hand of anna touched box, 12 N s" for the journal; empty for other kinds of events.
[[nodiscard]] std::string describe_touch(const World& world, const EventRecord& record);

}  // namespace ugoki::lsi
