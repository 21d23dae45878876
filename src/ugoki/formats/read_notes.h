#pragma once
// What a reader decided on its own, for people to know.

#include <string>
#include <vector>

namespace ugoki::formats {

/// Filled by a reader whose caller asks for it. Nothing here is an error.
struct ReadNotes {
  double frame_time = 0;             ///< s, exactly as the file gives it; 0 if it gives none
  double metres_per_unit = 0;        ///< the unit of length that was used
  bool unit_guessed = false;         ///< the file and the caller did not tell the unit
  bool z_up = false;                 ///< the file's Z was taken as up and its X as forward; otherwise Y and Z
  std::vector<std::string> remarks;  ///< sentences: guesses made, names changed, frames filled in
};

}  // namespace ugoki::formats
