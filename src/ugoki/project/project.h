#pragma once
// The integration file (*.ugoki): a project with all data of a piece of content. The user edits and saves it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
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

/// Result of a command on a project.
struct Change {
  std::string label;                 ///< label for undo menus, for example "Move clip"; empty if the command changed nothing
  std::vector<std::string> created;  ///< ids of the clips, characters and events that the command created
};

/// Data of an entry of a library, read by Project::fetch().
struct LibraryData {
  std::string id, kind;
  std::vector<std::byte> data;
};

/// An open project. Every command, undo and redo is on the disk when its function returns, so nothing is lost if the program is killed.
/// save() only marks the current state as saved. Used by one thread at a time. A function that fails leaves project and file unchanged.
/// If another program replaced, removed or overwrote the file, edits fail with `conflict`, and the message names a rescue copy of the work.
class Project {
 public:
  /// Creates a new file with this document and these resources. Errors: the file exists, or the document does not fit the resources.
  [[nodiscard]] static Result<Project> create(const std::string& path, const content::Scenario& scenario,
                                              const content::Resources& resources = {});
  /// Opens a file for editing. Error `conflict`: another program has it open, or the -wal file beside it belongs to another file. A
  /// damaged, foreign or newer file is refused and not changed.
  [[nodiscard]] static Result<Project> open(const std::string& path);
  /// Opens a file read-only. Never writes, and works while another program edits the file.
  [[nodiscard]] static Result<Project> open_read_only(const std::string& path);
  Project(Project&&) noexcept;
  Project& operator=(Project&&) noexcept;
  ~Project();

  [[nodiscard]] const std::string& path() const;
  /// A warning for the user: the file could be opened, but its damaged log contains changes that could not be read. A project that is open
  /// for editing has kept a copy of file and log; the warning names it.
  [[nodiscard]] const std::optional<Problem>& warning() const;
  [[nodiscard]] const content::Scenario& scenario() const;
  /// The document's canonical JSON text.
  [[nodiscard]] const std::string& document() const;
  [[nodiscard]] const content::Resources& resources() const;
  [[nodiscard]] const content::Catalogue& catalogue() const;
  /// Increases with every change of the document since the project was opened.
  [[nodiscard]] std::uint64_t revision() const;

  /// Applies one command of docs/scenario.md (JSON).
  /// @param library source of mechanisms and motions that the command names but the project does not contain; may be null
  [[nodiscard]] Result<Change> execute(std::string_view command, const store::Library* library = nullptr);
  /// Ids of the mechanisms and motions that a command names but the project does not contain.
  [[nodiscard]] std::vector<std::string> missing_resources(std::string_view command) const;
  /// Reads these entries from a library; ids that it does not contain are left out.
  [[nodiscard]] static Result<std::vector<LibraryData>> fetch(std::span<const std::string> ids, const store::Library& library);
  /// As execute(), but takes the missing resources as data, which another thread may have read with fetch() before.
  [[nodiscard]] Result<Change> execute_with(std::string_view command, std::span<const LibraryData> from_library);
  /// Undoes or redoes one command. @return its label; error `range` if there is no command to undo or redo
  [[nodiscard]] Result<std::string> undo();
  [[nodiscard]] Result<std::string> redo();
  [[nodiscard]] bool can_undo() const;
  [[nodiscard]] bool can_redo() const;
  [[nodiscard]] std::string undo_label() const;  ///< label of the next command to undo; empty if there is none
  [[nodiscard]] std::string redo_label() const;  ///< label of the next command to redo; empty if there is none

  /// True if the document differs from the one that the user saved last.
  [[nodiscard]] bool unsaved() const;
  /// Marks the current document as saved.
  [[nodiscard]] Result<void> save();
  /// Writes a copy of the project with its history and continues with the copy; the old file is unchanged. An existing file is replaced
  /// only if `overwrite` is true, and atomically.
  [[nodiscard]] Result<void> save_as(const std::string& path, bool overwrite = false);

  /// Checks a mechanism (JSON of formats/mechanism_json.h) or a motion (formats/motion_binary.h) and adds it. Has no effect if the
  /// project already contains the id. @param kind "mechanism" or "motion"
  [[nodiscard]] Result<void> add_resource(std::string_view id, std::string_view kind, std::span<const std::byte> data);
  /// Copies the library entry `id` into the project. Has no effect if the project already contains the id.
  [[nodiscard]] Result<void> adopt(std::string_view id, const store::Library& library);

  // Named texts that a program stores in the file in addition to the document, for example the studio's breakpoints. They are not part of
  // the history or of generated data; save_as() copies them.
  /// The stored text; empty if there is none.
  [[nodiscard]] Result<std::string> kept(std::string_view name) const;
  /// Stores a text; it is on the disk when the function returns.
  [[nodiscard]] Result<void> keep(std::string_view name, std::string_view text);

  /// Executable data (*.ugx) of the current document.
  [[nodiscard]] Result<std::vector<std::byte>> generate() const;

 private:
  struct Body;
  explicit Project(std::unique_ptr<Body> body);
  std::unique_ptr<Body> body_;
};

}  // namespace ugoki::project
