#pragma once
// Decisions of a reader in cases where the file leaves a choice; they are reported to the user.

#include <string>
#include <vector>

namespace ugoki::formats {

/// Notes of one call of a reader. The reader fills them if the caller passes an object. No note is an error.
struct ReadNotes {
  double frame_time = 0;             ///< s between frames, exactly as the file specifies it; 0 if it specifies none
  double metres_per_unit = 0;        ///< unit of length that was used, m per file unit
  bool unit_guessed = false;         ///< true: neither the file nor the caller specified a usable unit
  bool z_up = false;                 ///< true: the file's axes were read as Z up, X forward; false: as Y up, Z forward
  std::vector<std::string> remarks;  ///< one sentence each: guesses made, names changed, missing frames filled
};

}  // namespace ugoki::formats
