#pragma once
// The scenario that the pages show, edit and play: the document of the project, or one of its inner scenarios.

#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/project/project.h"

namespace ugoki::studio {

/// Used by one thread at a time.
class ShownScenario {
 public:
  /// @param project must outlive this object
  explicit ShownScenario(const project::Project& project) : project_(project) {}

  /// Opens the last one of these inner scenarios; an empty list opens the document. @param ids the scenarios through which the user came.
  /// Error `unknown`: there is no such scenario
  [[nodiscard]] Result<void> open(std::vector<std::string> ids);
  /// Ids of the opened scenarios, the shown one last; empty: the document is shown. Scenarios that no longer exist are left out.
  [[nodiscard]] const std::vector<std::string>& opened() const;
  /// Id of the shown inner scenario; empty: the document.
  [[nodiscard]] std::string id() const { return opened().empty() ? std::string() : opened().back(); }

  /// The shown scenario as a document.
  [[nodiscard]] const content::Scenario& scenario() const;
  /// Its canonical JSON text.
  [[nodiscard]] const std::string& document() const;
  /// An inner scenario as a document; the document, if `id` is empty.
  [[nodiscard]] content::Scenario find(const std::string& id) const;

  [[nodiscard]] const content::Resources& resources() const { return project_.resources(); }
  [[nodiscard]] std::uint64_t revision() const { return project_.revision(); }
  /// Path of the project's file and id of the shown scenario.
  [[nodiscard]] std::string path() const { return project_.path() + "#" + id(); }

 private:
  /// Rebuilds the inner scenario if the project has changed.
  void refresh() const;

  const project::Project& project_;
  mutable std::vector<std::string> ids_;
  mutable content::Scenario inner_;     ///< the shown scenario, if ids_ is not empty
  mutable std::string inner_document_;  ///< its JSON text
  mutable std::uint64_t revision_ = 0;  ///< of the project, to which inner_ belongs
};

/// Returns the command (JSON) that applies `command` to an inner scenario; the command itself, if `scenario` is empty.
[[nodiscard]] std::string command_in(const std::string& scenario, const std::string& command);

}  // namespace ugoki::studio
