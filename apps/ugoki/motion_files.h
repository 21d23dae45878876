#pragma once
// Loads the input motions of an operation onto one mechanism, and writes the result of the operation to a file or the library.

#include <string>
#include <vector>

#include "sources.h"

namespace ugoki::cli {

/// Motions of one mechanism.
struct MotionSet {
  MechanismPtr mechanism;
  std::vector<Motion> motions;
  double height = 0;                ///< height of the recorded person, m; 0: not known
  std::vector<std::string> report;  ///< sentences about conversions that were needed
};

/// Loads motions from files or entries of the library, all onto the mechanism of the first motion. Recordings of the same skeleton share
/// one body, whose joints allow all these recordings. Motions of other bodies are retargeted.
[[nodiscard]] Result<MotionSet> load_motions(const std::vector<std::string>& targets, const SourceOptions& options);

/// Whether put_motion() writes a file of this name; otherwise the name is that of a library entry.
[[nodiscard]] bool writes_file(const std::string& out);

/// Writes the motion to a .bvh or .glb file. A name without a dot is the name of a new library entry, with mechanism and motion.
/// @return sentence for the user about the destination
[[nodiscard]] Result<std::string> put_motion(const Mechanism& mechanism, const Motion& motion, double height, const std::string& out,
                                             const SourceOptions& options);

}  // namespace ugoki::cli
