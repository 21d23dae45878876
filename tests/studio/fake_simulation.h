#pragma once
// A simulation for tests of the interpreter: masses on a line that can be pushed and pulled. Its executable data is a JSON object:
// {"step", "duration", "rate", "cast": [{"id", "links"}], "blow_up": time, "crash": time, "hang": time, "unsolved": time from which
// contacts are not solved, "split": time from which steps are split, "wind": force, "start": x of the poses at time 0}. Real executable
// data (*.ugx) is accepted too; the name of its scenario may be such an object with faults to simulate.

#include <array>

#include "ugoki/studio/simulation.h"

namespace ugoki::studio::test {

/// A SimulationOpener for the fake simulation.
[[nodiscard]] Result<std::unique_ptr<Simulation>> open_fake_simulation(std::span<const std::byte> executable);

/// A parsed display frame. The parser follows docs/studio-protocol.md and shares no code with the writer.
struct Frame {
  double time = 0;
  std::uint32_t number = 0, flags = 0;
  float grab[6] = {};
  struct Character {
    std::uint32_t state = 0;
    float assist_force[3] = {}, assist_moment[3] = {}, assist_over_cap = 0, weight = 0, centre[3] = {};
    std::vector<std::array<float, 7>> links;
  };
  std::vector<Character> characters;
  struct Contact {
    float point[3], force[3];
    std::uint32_t character, link;
  };
  std::vector<Contact> contacts;
  bool good = false;  ///< the layout matches the frame's size exactly
};
[[nodiscard]] Frame parse_frame(std::span<const std::byte> bytes);

}  // namespace ugoki::studio::test
