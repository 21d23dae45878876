#pragma once
// Converts touch events to event records, and describes them as text.

#include <string>

#include "ugoki/contact/contact_events.h"
#include "ugoki/lsi/world.h"

namespace ugoki::lsi {

/// Returns the event as a record of kind `touch` (the touch began) or `parting` (it ended).
[[nodiscard]] EventRecord record_of(const contact::TouchEvent& event);

/// Returns a record of kind `omitted`: there are `count` further events without a record.
[[nodiscard]] EventRecord omitted_record(std::size_t count);

/// Returns a text for the journal: "left hand of anna touched box, 12 N s". Empty for other kinds of events.
[[nodiscard]] std::string describe_touch(const World& world, const EventRecord& record);

}  // namespace ugoki::lsi
