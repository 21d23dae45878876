#pragma once
// What FMUs say while they run, for the user of this process. Safe for several threads.

#include <string>
#include <vector>

namespace ugoki::fmi {

void post_message(std::string text);
/// All since it was asked for last; of more than a thousand the first ones, and how many there were.
[[nodiscard]] std::vector<std::string> take_messages();

}  // namespace ugoki::fmi
