#pragma once
// Entries from one library into another: migration between SQLite and PostgreSQL, export and import of sets.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/store/library.h"

namespace ugoki::store {

struct CopyOptions {
  std::vector<std::string> entries;  ///< ids; empty: everything, with the trash
  bool latest_only = false;          ///< without older versions
  /// What happens to an entry that was changed on both sides. False: it stays as it is there, and is named. True: the newest version
  /// of here is saved there on top of what is there.
  bool save_differing = false;
  std::function<void(double)> progress;  ///< gets 0 ... 1
  std::function<bool()> stop;            ///< true: ends in order after what is being written
};

struct CopyReport {
  std::size_t added = 0;                ///< entries that were not there
  std::size_t continued = 0;            ///< entries that got newer versions
  std::size_t equal = 0;                ///< entries that were there already (as new or newer)
  std::size_t saved = 0;                ///< differing entries whose newest version was saved on top
  std::vector<std::string> differing;   ///< entries changed on both sides, left as they were: "n-... 'walk': ..."
  std::size_t versions = 0, blobs = 0;  ///< written
};

/// Copies entries with their versions, tags, thumbnails and data. Every entry arrives wholly or not at all; doing it again goes on where
/// it was stopped, and changes nothing where nothing is new. Tags are added, never taken away.
[[nodiscard]] Result<CopyReport> copy_entries(const Library& from, Library& to, const CopyOptions& options = {});

/// Writes a set into one file, which is a library of its own; a file of this name is replaced, in one step.
/// @param ids of entries; those that they name in their summaries (a motion's mechanism) go with them; sets bring what they list
[[nodiscard]] Result<CopyReport> export_set(const Library& from, const std::vector<std::string>& ids, const std::string& path,
                                            const CopyOptions& options = {});

/// The entries with all that they need, each once: what their summaries and sets name.
[[nodiscard]] Result<std::vector<std::string>> with_references(const Library& library, const std::vector<std::string>& ids);

}  // namespace ugoki::store
