#pragma once
// Answers the requests `pose`, `curves`, `poses` and `joints` of a page (docs/studio-protocol.md): poses of a character on its track,
// changed by hand, and the keys that give these poses. Never changes the project.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/layered_motions.h"
#include "ugoki/json/json.h"
#include "ugoki/studio/body_drag.h"
#include "ugoki/studio/shown_scenario.h"

namespace ugoki::studio {

class PoseDesk {
 public:
  /// The pose of a character at a time, changed by the edit of the request. @return JSON fields of the answer, each with a comma before it
  [[nodiscard]] Result<std::string> pose(const ShownScenario& project, const json::Json& request);
  /// Joint curves of a clip with and without its layers.
  [[nodiscard]] Result<std::string> curves(const ShownScenario& project, const json::Json& request);
  /// Poses of all links for the stored poses that fit a mechanism, for pictures.
  [[nodiscard]] static Result<std::string> stored(const ShownScenario& project, const json::Json& request);
  /// Limits, axes and mirror partners of the joints of a mechanism.
  [[nodiscard]] static Result<std::string> joints(const ShownScenario& project, const json::Json& request);

 private:
  [[nodiscard]] Result<const content::LayeredContent*> layered(const ShownScenario& project);
  /// Continues the drag `id`, or begins it at `q`. @param q [nq, in and out]
  [[nodiscard]] Result<void> drag(const ShownScenario& project, const MechanismPtr& mechanism, const std::string& id,
                                  BodyDragOptions options, const Vec3& target, double seconds, std::span<double> q);

  std::string path_;  ///< project and revision to which layered_ belongs
  std::uint64_t revision_ = 0;
  std::optional<content::LayeredContent> layered_;  ///< the document with all layers applied
  /// A drag with dynamics, which several requests continue.
  struct Drag {
    std::string id;
    std::uint64_t revision = 0;  ///< of the project; a changed project begins a new drag
    std::unique_ptr<BodyDrag> body;
  };
  std::vector<Drag> drags_;  ///< the latest ones, oldest first
};

}  // namespace ugoki::studio
