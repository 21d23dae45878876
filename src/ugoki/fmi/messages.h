#pragma once
// Queue of the log messages of running FMUs, to be shown to the user. Safe for several threads.

#include <string>
#include <vector>

namespace ugoki::fmi {

/// Adds a message to the queue; drops the message if 1000 messages are already waiting.
void post_message(std::string text);
/// Removes and returns the waiting messages, oldest first. If messages were dropped, a last one states how many.
[[nodiscard]] std::vector<std::string> take_messages();

}  // namespace ugoki::fmi
