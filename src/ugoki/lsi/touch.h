#pragma once
// Conversion of touch events to event records, and their description as text.

#include <string>

#include "ugoki/contact/contact_events.h"
#include "ugoki/lsi/world.h"

namespace ugoki::lsi {

/// The event as a record of kind `touch` (begin) or `parting` (end).
[[nodiscard]] EventRecord record_of(const contact::TouchEvent& event);

/// A record of kind `omitted`: `count` further events have no record.
[[nodiscard]] EventRecord omitted_record(std::size_t count);

/// Text for the journal: "left hand of anna touched box, 12 N s". Empty for other kinds of events.
[[nodiscard]] std::string describe_touch(const World& world, const EventRecord& record);

}  // namespace ugoki::lsi
