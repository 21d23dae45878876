#pragma once
// The integration file (*.ugoki): everything that a piece of content consists of; what the user edits and saves.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/store/library.h"

namespace ugoki::project {

/// What a command did.
struct Change {
  std::string label;                 ///< "Move clip"; empty if the command changed nothing
  std::vector<std::string> created;  ///< ids of what it made
};

/// An open project. Every command, undo and redo is in the file (and on the disk) when its function returns; so nothing
/// is lost when the program is killed. "Saved" is a mark: which state the user called finished.
/// One thread at a time. When a function fails, project and file are as they were before.
class Project {
 public:
  /// Makes a new file with this content; fails if the file exists, or if the document does not fit the resources.
  [[nodiscard]] static Result<Project> create(const std::string& path, const content::Scenario& scenario,
                                              const content::Resources& resources = {});
  /// Opens for editing. Conflict if another program has it open; a damaged, foreign or newer file is left untouched.
  [[nodiscard]] static Result<Project> open(const std::string& path);
  /// Opens to look: never writes, and works while another program edits.
  [[nodiscard]] static Result<Project> open_read_only(const std::string& path);
  Project(Project&&) noexcept;
  Project& operator=(Project&&) noexcept;
  ~Project();

  [[nodiscard]] const std::string& path() const;
  [[nodiscard]] const content::Scenario& scenario() const;
  /// The document's canonical JSON text.
  [[nodiscard]] const std::string& document() const;
  [[nodiscard]] const content::Resources& resources() const;
  [[nodiscard]] const content::Catalogue& catalogue() const;
  /// Grows with every change of the document.
  [[nodiscard]] std::uint64_t revision() const;

  /// Applies one command of docs/scenario.md (JSON).
  /// @param library where mechanisms and motions are fetched from that the command names and the project lacks; may be null
  [[nodiscard]] Result<Change> execute(std::string_view command, const store::Library* library = nullptr);
  /// @return the label of what was undone or redone; a problem if there is nothing
  [[nodiscard]] Result<std::string> undo();
  [[nodiscard]] Result<std::string> redo();
  [[nodiscard]] bool can_undo() const;
  [[nodiscard]] bool can_redo() const;
  [[nodiscard]] std::string undo_label() const;  ///< empty if there is nothing
  [[nodiscard]] std::string redo_label() const;

  /// True if the document differs from the one that was last saved by the user.
  [[nodiscard]] bool unsaved() const;
  [[nodiscard]] Result<void> save();
  /// Writes a copy, history included, and goes on with that; the old file keeps what it has. An existing file is replaced
  /// only with `overwrite`, and in one step.
  [[nodiscard]] Result<void> save_as(const std::string& path, bool overwrite = false);

  /// Puts a mechanism (JSON of formats/mechanism_json.h) or a motion (formats/motion_binary.h) in, checked. Nothing
  /// happens if the project has the id already. @param kind "mechanism" or "motion"
  [[nodiscard]] Result<void> add_resource(std::string_view id, std::string_view kind, std::span<const std::byte> data);
  /// Fetches a library entry by id into the project, if the project lacks it.
  [[nodiscard]] Result<void> adopt(std::string_view id, const store::Library& library);

  /// What a program keeps beside the document (the studio its breakpoints): on the disk at once, no part of the history and of what is
  /// generated. Copies take it along. Empty where nothing was kept.
  [[nodiscard]] Result<std::string> kept(std::string_view name) const;
  [[nodiscard]] Result<void> keep(std::string_view name, std::string_view text);

  /// Executable data (*.ugx) of the document as it is.
  [[nodiscard]] Result<std::vector<std::byte>> generate() const;

 private:
  struct Body;
  explicit Project(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace ugoki::project
