#pragma once
// Motions that an operation takes, all on one mechanism, and the motion that it gives, to a file or the library.

#include <string>
#include <vector>

#include "sources.h"

namespace ugoki::cli {

/// Motions of one mechanism.
struct MotionSet {
  MechanismPtr mechanism;
  std::vector<Motion> motions;
  double height = 0;                ///< m; 0: not known
  std::vector<std::string> report;  ///< what was done to bring them together
};

/// Files or entries of the library. All are brought onto the first one's mechanism: trials of one skeleton share a body that can do what
/// each of them does; motions of other bodies are retargeted.
[[nodiscard]] Result<MotionSet> load_motions(const std::vector<std::string>& targets, const SourceOptions& options);

/// Writes the motion: .bvh or .glb by the ending; another name is that of an entry in the library, to which mechanism and motion go.
/// @return what to tell
[[nodiscard]] Result<std::string> put_motion(const Mechanism& mechanism, const Motion& motion, double height, const std::string& out,
                                             const SourceOptions& options);

}  // namespace ugoki::cli
